//! The optimisation problem: from a point in the parameters' coordinates to normal equations.

use super::equations::NormalEquations;
use super::scene_models::SceneModels;
use crate::error::{Error, Result};
use crate::fit::observation::Observed;
use crate::fit::parameters::{Bounds, Parameters};
use crate::forward::{ForwardModel, Products};
use nalgebra::DVector;

/// Which products make the equations.
#[derive(Clone, Copy)]
enum Part {
    /// Those of whole images.
    Whole,
    /// Those of one batch of the paths with all others, where a model is a sample of paths.
    Batch(usize),
}

/// Parameters in, normal equations out.
pub(crate) struct Problem<'x> {
    models: &'x SceneModels<'x>,
    observed: &'x [Observed<'x>],
    parameters: &'x Parameters,
    progress: &'x dyn Fn(),
    part: Part,
}

impl<'x> Problem<'x> {
    /// The fit of `observed` by `models`; `progress` is called after every render.
    pub(crate) fn new(
        models: &'x SceneModels<'x>,
        observed: &'x [Observed<'x>],
        parameters: &'x Parameters,
        progress: &'x dyn Fn(),
    ) -> Self {
        Self { models, observed, parameters, progress, part: Part::Whole }
    }

    /// The same by one batch of the paths.
    pub(crate) fn of_batch(self, batch: usize) -> Self {
        Self { part: Part::Batch(batch), ..self }
    }

    pub(crate) fn parameters(&self) -> &Parameters {
        self.parameters
    }

    /// Bounds of the coordinates, and of where the models may be trusted.
    pub(crate) fn bounds(&self) -> Vec<Bounds> {
        self.models.bounds(self.parameters)
    }

    /// Cost, gradient and Gauss-Newton matrix at `point`.
    pub(crate) fn equations(&self, point: &DVector<f64>) -> Result<NormalEquations> {
        let parameters = self.parameters.at(point);
        let equations = self.compare(&parameters, |model, scene| {
            let (state, pixels) = (parameters.state(scene)?, self.observed[scene].pixels());
            match self.part {
                Part::Whole => model.products(&state, pixels),
                Part::Batch(batch) => {
                    let noise = model.noise().expect("batches are asked of a model that has some");
                    noise.batch_products(&state, pixels, batch)
                }
            }
        })?;
        if equations.is_finite() {
            return Ok(equations);
        }
        let place: Vec<String> =
            parameters.iter().map(|(_, p)| format!("{} = {}", p.name(), p.value())).collect();
        Err(Error::NotFinite(format!("the cost is not finite at {}", place.join(", "))))
    }

    /// Cost alone at `point`.
    pub(crate) fn cost(&self, point: &DVector<f64>) -> Result<f64> {
        let parameters = self.parameters.at(point);
        let levels = |model: &dyn ForwardModel, scene: usize| {
            model.levels(&parameters.state(scene)?, self.observed[scene].pixels())
        };
        Ok(self.compare(&parameters, levels)?.cost)
    }

    fn compare(
        &self,
        parameters: &Parameters,
        products: impl Fn(&dyn ForwardModel, usize) -> Result<Products>,
    ) -> Result<NormalEquations> {
        let mut equations = NormalEquations::empty(parameters.count());
        for (scene, (model, observed)) in self.models.iter().zip(self.observed).enumerate() {
            let mut products = products(model, scene)?;
            if let Some(noise) = &observed.object_noise {
                let medium = parameters.state(scene)?.medium;
                let (power, left) = noise.products(self.models.model(), &medium, &observed.observation)?;
                products = products.without_object_noise(&power, left);
            }
            (self.progress)();
            equations.add(scene, observed, &products, parameters);
            model.refer_to(equations.scenes[scene].linear.exposure);
        }
        Ok(equations)
    }
}
