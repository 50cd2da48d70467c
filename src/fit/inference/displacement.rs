//! How far an estimate moves when the images that it is made from change, to first order: one Gauss-Newton step.

use super::covariance::Covariance;
use crate::error::Result;
use crate::filter::Target;
use crate::fit::observation::{Observation, Observed, Unseen};
use crate::fit::optimise::{Eliminated, NormalEquations, Problem, SceneModels};
use crate::fit::parameters::Parameters;
use crate::forward::{Engine, Exposure};
use crate::image::Image;
use nalgebra::DVector;

/// A fit at its optimum.
pub(crate) struct Displacement<'x, 'a> {
    pub observed: &'x [Observed<'a>],
    pub models: &'x mut SceneModels<'a>,
    pub parameters: &'x Parameters,
    pub covariance: &'x Covariance,
    pub exposures: Vec<Exposure>,
    /// Each scene's shares of light that no image shows.
    pub unseen: &'x [Unseen],
    pub engine: Engine<'a>,
    pub progress: &'x dyn Fn(),
}

/// What other images would do to a fit.
pub(crate) struct Moved {
    /// Change of the coordinates.
    pub step: DVector<f64>,
    /// Root mean square difference of the images from the best fit, in units of a pixel's noise.
    pub image: f64,
}

impl<'a> Displacement<'_, 'a> {
    /// Gain and veil of every scene of `equations`.
    pub(crate) fn exposures(equations: &NormalEquations) -> Vec<Exposure> {
        equations.scenes.iter().map(|Eliminated { linear, .. }| linear.exposure).collect()
    }

    /// What was observed.
    pub(crate) fn observations(&self) -> impl Iterator<Item = &Observation<'a>> {
        self.observed.iter().map(|o| &o.observation)
    }

    /// What happens if the object light of every scene is that of `images`.
    pub(crate) fn towards(&mut self, images: Vec<Image>) -> Result<Moved> {
        let scenes = images.into_iter().zip(&self.exposures).zip(self.observed);
        let exposed: Vec<Image> = scenes.map(|((i, e), o)| o.observation.exposed(i, *e)).collect();
        let seen: Vec<Observed> = self.observed.iter().zip(&exposed).map(|(o, i)| o.seen_as(i)).collect();
        for (scene, seen) in seen.iter().enumerate() {
            self.models.observe(scene, seen)?;
        }
        let problem = Problem::new(self.models, &seen, self.parameters, self.progress);
        let equations = problem.equations(&self.parameters.point())?;
        let image = (2.0 * equations.cost.max(0.0) / equations.pixels.max(1) as f64).sqrt();
        Ok(Moved { step: self.covariance.step(&equations.gradient), image })
    }

    /// What happens if the object light of every scene is off by that of `differences` from `light`.
    pub(crate) fn by(&mut self, light: &[Image], differences: &[Image]) -> Result<Moved> {
        let sum = |(light, difference): (&Image, &Image)| Image {
            data: light.data.iter().zip(&difference.data).map(|(v, d)| v + d).collect(),
            ..*light
        };
        self.towards(light.iter().zip(differences).map(sum).collect())
    }

    /// Where one batch of the paths of a traced model would lead the coordinates.
    pub(crate) fn by_batch(&self, batch: usize) -> Result<DVector<f64>> {
        let problem =
            Problem::new(self.models, self.observed, self.parameters, self.progress).of_batch(batch);
        Ok(self.covariance.step(&problem.equations(&self.parameters.point())?.gradient))
    }

    /// The light of `target`, which stands in for that of scene number `scene`, at the optimum. If it is traced, by other
    /// paths than the fit's, whose noise is in its derivatives, and by the shapes of those of a scene that is nearer by the
    /// factor `stretch`.
    pub(crate) fn render(&self, target: Target, scene: usize, stretch: f64) -> Result<Image> {
        let state = self.parameters.state(scene)?;
        self.engine.image(target, &state, self.observed.len() + scene, stretch)
    }
}
