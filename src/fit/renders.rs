//! All scenes of a fit, planned and rendered, or traced.

use super::comparison::Comparison;
use super::equations::Products;
use super::observed::Observed;
use super::parameters::Bounds;
use super::traced::Traced;
use super::{Datum, Exposure, HEADROOM, Parameters, Settings, with_optics};
use crate::error::Result;
use crate::filter::Coverage;
use crate::image::Image;
use crate::spread::Model;

/// All scenes, prepared and beside their observations.
pub(super) struct Renders<'a> {
    scenes: Vec<Scene<'a>>,
}

/// What renders a scene.
enum Scene<'a> {
    Filtered(Comparison<'a>),
    Traced(Traced<'a>),
}

impl<'a> Renders<'a> {
    /// Plans `data` for kernels about as wide as those of `parameters`, or traces paths in that medium.
    pub(super) fn new(
        data: &[Datum<'a>],
        observed: &[Observed],
        parameters: &Parameters,
        settings: &Settings<'a>,
    ) -> Result<Self> {
        let scene = |(i, (d, o)): (usize, (&Datum<'a>, &Observed))| {
            if settings.model == Model::Traced {
                return Traced::new(d.target, parameters, settings, i as u64).map(Scene::Traced);
            }
            with_optics(parameters, settings.model, |optics| {
                Comparison::new(settings.backend.prepare(d.target, optics, HEADROOM)?, o).map(Scene::Filtered)
            })
        };
        Ok(Self { scenes: data.iter().zip(observed).enumerate().map(scene).collect::<Result<_>>()? })
    }

    /// Takes the pixels of scene `i` that count now.
    pub(super) fn observe(&mut self, i: usize, observed: &Observed) -> Result<()> {
        match &mut self.scenes[i] {
            Scene::Filtered(scene) => scene.observe(observed),
            Scene::Traced(_) => Ok(()),
        }
    }

    /// What the fit needs of every scene at `parameters`.
    pub(super) fn products(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        observed: &[Observed],
    ) -> Result<Vec<Products>> {
        let products = |(scene, observed): (&Scene, &Observed)| {
            let products = match scene {
                Scene::Filtered(scene) => scene.products(parameters, settings, observed),
                Scene::Traced(scene) => scene.products(parameters, observed),
            };
            (settings.progress)();
            products
        };
        self.scenes.iter().zip(observed).map(products).collect()
    }

    /// The same without derivatives.
    pub(super) fn levels(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        observed: &[Observed],
    ) -> Result<Vec<Products>> {
        let products = |(scene, observed): (&Scene, &Observed)| {
            let products = match scene {
                Scene::Filtered(scene) => {
                    with_optics(parameters, settings.model, |optics| scene.levels(optics, observed))
                }
                Scene::Traced(scene) => scene.products(parameters, observed),
            };
            (settings.progress)();
            products
        };
        self.scenes.iter().zip(observed).map(products).collect()
    }

    /// The products of one batch of the paths with all others, of every traced scene.
    pub(super) fn products_of_batch(
        &self,
        parameters: &Parameters,
        observed: &[Observed],
        batch: usize,
    ) -> Result<Vec<Products>> {
        let traced = self.scenes.iter().zip(observed).filter_map(|(scene, observed)| match scene {
            Scene::Traced(scene) => Some((scene, observed)),
            Scene::Filtered(_) => None,
        });
        traced.map(|(scene, observed)| scene.products_of_batch(parameters, observed, batch)).collect()
    }

    /// Every scene at `parameters`, exposed and veiled as it was observed.
    pub(super) fn exposed(
        &self,
        parameters: &Parameters,
        settings: &Settings,
        exposures: &[Exposure],
        data: &[Datum],
    ) -> Result<Vec<Image>> {
        let scenes = self.scenes.iter().zip(exposures).zip(data);
        let exposed = |((scene, exposure), datum): ((&Scene, &Exposure), &Datum)| {
            let image = match scene {
                Scene::Filtered(scene) => scene.image(parameters, settings)?,
                Scene::Traced(scene) => scene.image(parameters)?,
            };
            Ok(exposure.apply(image, datum.veil))
        };
        scenes.map(exposed).collect()
    }

    /// Standard deviation of a pixel's noise in scene `i`, whose best fit is `image`.
    pub(super) fn noise(
        &self,
        i: usize,
        parameters: &Parameters,
        (observed, exposure, image): (&Observed, &Exposure, &Image),
    ) -> Result<f64> {
        let Scene::Traced(scene) = &self.scenes[i] else { return Ok(observed.fine_noise([image; 2])) };
        let halves = scene.halves(parameters)?;
        let exposed = [0, 1].map(|half| exposure.apply(halves[half].image.clone(), observed.datum.veil));
        Ok(observed.fine_noise([&exposed[0], &exposed[1]]))
    }

    /// How far the plans, or the paths, serve the medium of `parameters` too.
    pub(super) fn coverage(&self, parameters: &Parameters, settings: &Settings) -> Result<Coverage> {
        let mut all = Coverage { served: true, cut: false };
        for scene in &self.scenes {
            let coverage = match scene {
                Scene::Filtered(scene) => {
                    with_optics(parameters, settings.model, |optics| scene.filter.coverage(optics))?
                }
                Scene::Traced(scene) => Coverage { served: scene.serves(parameters)?, cut: false },
            };
            all = Coverage { served: all.served && coverage.served, cut: all.cut || coverage.cut };
        }
        Ok(all)
    }

    /// Coordinates between which a step is trusted.
    pub(super) fn trust(&self) -> [Bounds; 3] {
        let everywhere = [[f64::NEG_INFINITY, f64::INFINITY]; 3];
        self.scenes.iter().fold(everywhere, |all, scene| match scene {
            Scene::Filtered(_) => all,
            Scene::Traced(scene) => within(all, scene.trust),
        })
    }

    /// Paths traced for all scenes, and the least share of them that carries the weight at `parameters`; `None` if none were.
    pub(super) fn paths(&self, parameters: &Parameters) -> Result<Option<(u64, f64)>> {
        let mut all: Option<(u64, f64)> = None;
        for scene in &self.scenes {
            if let Scene::Traced(scene) = scene {
                let share = scene.effective_share(parameters)?;
                let (count, least) = all.unwrap_or((0, 1.0));
                all = Some((count + scene.count(), least.min(share)));
            }
        }
        Ok(all)
    }

    /// 2-D FFTs of one evaluation with derivatives.
    pub(super) fn transforms(&self) -> usize {
        let each = |scene: &Scene| match scene {
            Scene::Filtered(scene) => scene.filter.transforms().1,
            Scene::Traced(_) => 0,
        };
        self.scenes.iter().map(each).sum()
    }
}

/// The part of `bounds` that lies between `others`.
pub(super) fn within(bounds: [Bounds; 3], others: [Bounds; 3]) -> [Bounds; 3] {
    std::array::from_fn(|i| [bounds[i][0].max(others[i][0]), bounds[i][1].min(others[i][1])])
}
