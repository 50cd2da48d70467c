//! Time against error of renders in the true medium.

use super::dataset::Dataset;
use super::timing::{Effort, Timing};
use crate::error::Result;
use crate::filter::{Backend, Filter, Prepared};
use crate::image::Image;
use crate::medium::Medium;
use crate::spread::Model;
use crate::trace::{Estimate, ImageConfig, trace_image};

/// Seed of the traced images.
const SEED: u64 = 7;

/// How an image is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// By a spread model and a filter.
    Filter {
        /// The spread model.
        model: Model,
        /// The filter: eq29, or composite where that is another one.
        filter: Filter,
        /// Index of the backend.
        backend: usize,
    },
    /// By tracing.
    Trace {
        /// Paths per pixel.
        samples: u32,
    },
}

/// One way to render, and its result.
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
    /// Time of what is done once for many media; `None` if there is nothing to do.
    pub preparation: Option<Timing>,
    /// Time of a render, all channels, once that is done.
    pub render: Timing,
    /// Its error, relative to the root mean square of the light, the noise of the truth subtracted.
    pub error: Estimate,
}

/// The images of all channels, and how long they took.
struct Made {
    images: Vec<Image>,
    /// Time of what is done once for many media; `None` if there is nothing to do.
    preparation: Option<Timing>,
    render: Timing,
}

impl Dataset {
    /// Every way in which to render it by one of `backends` backends, or to trace it.
    pub(super) fn ways(&self, backends: usize, effort: &Effort) -> Vec<Way> {
        let filters = match Filter::Auto.relief(&self.scene().geometry) {
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
    fn render(&self, model: Model, filter: Filter, backend: Backend, effort: &Effort) -> Result<Made> {
        let relief = filter.relief(&self.scene().geometry);
        let channels = || 0..self.truth.len();
        let prepare =
            |c: usize| backend.prepare(self.target(c, relief.as_ref()), &self.optics(model, c), 1.0);
        // What is done once in a program's life, such as compiling shaders, belongs to no image.
        prepare(0)?;
        let once = Effort { runs: 1, ..effort.clone() };
        let (prepared, preparation) =
            once.time(|| channels().map(prepare).collect::<Result<Vec<Prepared>>>())?;
        let render = |c: usize| prepared[c].render(&self.optics(model, c));
        render(0)?;
        let (images, rendering) = effort.time(|| channels().map(render).collect::<Result<Vec<Image>>>())?;
        Ok(Made { images, preparation: Some(preparation), render: rendering })
    }

    /// Traces it in the true medium.
    fn trace(&self, samples: u32, effort: &Effort) -> Result<Made> {
        let trace = |(c, truth): (usize, &Medium)| {
            let config = ImageConfig {
                geometry: &self.scene().geometry,
                radiance: &self.scene().object[c].image,
                behind: &self.scene().behind[c],
                border: self.scene().border,
                view: self.scene().view,
                medium: *truth,
                samples,
                seed: SEED + c as u64,
            };
            Ok(trace_image(&config, &|_| ())?.mean)
        };
        let (images, render) = effort.time(|| self.truth.iter().enumerate().map(trace).collect())?;
        Ok(Made { images, preparation: None, render })
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
            Self::Filter { model, filter, backend } => set.render(model, filter, backends[backend], effort),
            Self::Trace { samples } => set.trace(samples, effort),
        };
        let backend = match self {
            Self::Filter { backend, .. } => backends[backend].name(),
            Self::Trace { .. } => Backend::Cpu.name(),
        };
        let outcome = found.map(|made| Rendered {
            preparation: made.preparation,
            render: made.render,
            error: set.error_of(&made.images).error,
        });
        RenderTrial { way: self, backend, outcome: outcome.map_err(|error| error.to_string()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(name: &str) -> Dataset {
        Dataset::read(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets").join(name)).unwrap()
    }

    fn error(set: &Dataset, model: Model, filter: Filter) -> Estimate {
        let effort = Effort { runs: 1, patience: 0.0, samples: Vec::new() };
        set.error_of(&set.render(model, filter, Backend::Cpu, &effort).unwrap().images).error
    }

    #[test]
    fn the_right_model_in_the_true_medium_is_within_the_noise_and_a_wrong_medium_is_not() {
        let mut set = set("wide-30");
        // The table's light is good to 0.2 % (tests/it/wide_angle.rs), the floor is that of the observation's noise.
        let right = error(&set, Model::WideAngle, Filter::Eq29);
        assert!(right.value < 3.0 * set.floor() + 0.002, "{right:?}, floor {}", set.floor());
        assert!(error(&set, Model::SmallAngle, Filter::Eq29).value > 0.02);
        // Nearly half of the light is direct: 10 % more scattering darkens the image by more than a hundredth.
        let truth = set.truth[0];
        set.truth[0] = Medium::new(1.1 * truth.sigma_s(), truth.sigma_a(), *truth.phase()).unwrap();
        let wrong = error(&set, Model::WideAngle, Filter::Eq29);
        assert!(wrong.value > 0.01 && wrong.std_error < 1e-3, "{wrong:?}");
    }

    #[test]
    fn half_the_light_errs_by_half_and_the_noise_of_the_truth_is_taken_off() {
        let set = set("mitsuba-checker");
        let observed = &set.observed.observation.image[0].image;
        let halved = Image { data: observed.data.iter().map(|v| 0.5 * v).collect(), ..observed.clone() };
        let error = set.error_of(&[halved]);
        // The observation's own noise, 1.1 % of the mean, is in both images here and adds to neither.
        assert!((error.error.value - 0.5).abs() < 1e-3, "{error:?}");
        assert!(error.noise > 0.005 && set.floor() < 0.25 * error.noise, "{error:?}, floor {}", set.floor());
    }

    #[test]
    fn more_paths_err_less_as_the_root_of_their_number() {
        let set = set("wide-30");
        let effort = Effort { runs: 1, patience: 0.0, samples: Vec::new() };
        let error = |samples| set.error_of(&set.trace(samples, &effort).unwrap().images).error.value;
        let ratio = error(8) / error(128);
        // The rms of 4096 normal pixels has a relative error of 1/sqrt(2 x 4096) = 1.1 %; these are skewed, hence the margin.
        assert!((ratio / 4.0 - 1.0).abs() < 0.1, "{ratio}");
    }

    #[test]
    fn edges_are_charted_with_both_filters_and_composite_is_nearer() {
        let set = set("mitsuba-planes");
        let effort = Effort::quick();
        assert_eq!(set.ways(1, &effort).len(), 2 * Model::ALL.len() + effort.samples.len());
        let [spread, composite] =
            [Filter::Eq29, Filter::Composite].map(|f| error(&set, Model::SmallAngle, f));
        assert!(composite.value < 0.3 * spread.value, "{composite:?} {spread:?}");
    }
}
