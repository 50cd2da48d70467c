//! Time against error of renders in the true medium.

use super::dataset::Dataset;
use super::timing::{Effort, Timing};
use crate::error::Result;
use crate::filter::{Backend, Filter, Prepared};
use crate::image::Image;
use crate::medium::Medium;
use crate::phase::Gaussian;
use crate::scene::MediumValues;
use crate::spread::Model;
use crate::trace::{Estimate, ImageConfig, trace_image};

/// Seed of the traced images.
const SEED: u64 = 7;

/// How an image comes about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// A spread model by a filter.
    Filter {
        /// The spread model.
        model: Model,
        /// The filter: eq29, or composite where that is another one.
        filter: Filter,
        /// Index of the backend.
        backend: usize,
    },
    /// So many paths a pixel.
    Trace {
        /// Paths a pixel.
        samples: u32,
    },
}

/// One way and what came of it.
#[derive(Debug, Clone)]
pub struct RenderTrial {
    /// How it was rendered.
    pub way: Way,
    /// Name of the backend.
    pub backend: &'static str,
    /// Time and error, or why there is no render.
    pub outcome: std::result::Result<Rendered, String>,
}

/// Time and error of a render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendered {
    /// Seconds for what is done once for many media.
    pub prepare_seconds: f64,
    /// Time of a render, all channels, once that is done.
    pub render: Timing,
    /// Its error, relative to the root mean square of the light, the noise of the truth taken off.
    pub error: Estimate,
}

impl Dataset {
    /// Every way in which to render it by one of `backends` backends, or to trace it.
    pub(super) fn ways(&self, backends: usize, effort: &Effort) -> Vec<Way> {
        let filters = match Filter::Auto.relief(&self.scene.geometry) {
            Some(_) => &[Filter::Eq29, Filter::Composite][..],
            None => &[Filter::Eq29],
        };
        let mut all = Vec::new();
        for backend in 0..backends {
            for &filter in filters {
                all.extend(Model::ALL.map(|model| Way::Filter { model, filter, backend }));
            }
        }
        all.extend(effort.samples.iter().map(|&samples| Way::Trace { samples }));
        all
    }

    /// Renders it in the true medium, with the time that the preparation took and that of the renders.
    fn render(
        &self,
        (model, filter, backend): (Model, Filter, Backend),
        effort: &Effort,
    ) -> Result<(Vec<Image>, Timing, Timing)> {
        let relief = filter.relief(&self.scene.geometry);
        let channels = || 0..self.truth.len();
        let prepare = |c: usize| {
            self.with_optics(model, c, |optics| backend.prepare(self.target(c, relief.as_ref()), optics, 1.0))
        };
        // What is done once in a program's life, such as compiling shaders, belongs to no image.
        prepare(0)?;
        let once = Effort { least: 1, most: 1, ..effort.clone() };
        let (prepared, preparation) =
            once.time(|| channels().map(prepare).collect::<Result<Vec<Prepared>>>())?;
        let render = |c: usize| self.with_optics(model, c, |optics| prepared[c].render(optics));
        render(0)?;
        let (images, rendering) = effort.time(|| channels().map(render).collect::<Result<Vec<Image>>>())?;
        Ok((images, preparation, rendering))
    }

    /// Traces it in the true medium.
    fn trace(&self, samples: u32, effort: &Effort) -> Result<(Vec<Image>, Timing)> {
        let trace = |(c, truth): (usize, &MediumValues)| {
            let config = ImageConfig {
                geometry: &self.scene.geometry,
                radiance: &self.scene.object[c].image,
                behind: &self.scene.behind[c],
                border: self.scene.border,
                view: self.scene.view,
                medium: Medium::new(truth.sigma_s, truth.sigma_a)?,
                samples,
                seed: SEED + c as u64,
            };
            Ok(trace_image(&config, &Gaussian::new(truth.b)?, &|_| ())?.mean)
        };
        effort.time(|| self.truth.iter().enumerate().map(trace).collect())
    }
}

impl Way {
    /// Name of the model, or `traced`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Filter { model, .. } => model.name(),
            Self::Trace { .. } => "traced",
        }
    }

    /// Renders `set` in its medium.
    pub(super) fn try_on(self, set: &Dataset, backends: &[Backend], effort: &Effort) -> RenderTrial {
        let found = match self {
            Self::Filter { model, filter, backend } => set.render((model, filter, backends[backend]), effort),
            Self::Trace { samples } => {
                let nothing = Timing { seconds: 0.0, runs: 0 };
                set.trace(samples, effort).map(|(images, time)| (images, nothing, time))
            }
        };
        let backend = match self {
            Self::Filter { backend, .. } => backends[backend].name(),
            Self::Trace { .. } => Backend::Cpu.name(),
        };
        let outcome = found.map(|(images, preparation, render)| Rendered {
            prepare_seconds: preparation.seconds,
            render,
            error: set.error_of(&images).error,
        });
        RenderTrial { way: self, backend, outcome: outcome.map_err(|error| error.to_string()) }
    }
}
