//! The forward models of all scenes of a fit.

use crate::error::Result;
use crate::filter::Coverage;
use crate::fit::observation::{Observation, Observed};
use crate::fit::parameters::{Bounds, Parameter, Parameters};
use crate::forward::{Engine, ForwardModel, GramModel, Radius};
use crate::image::Image;
use crate::spread::Model;

/// How much wider than at the start the kernels may become before a fit is planned again.
pub const HEADROOM: f64 = 1.4;

/// One forward model a scene.
pub(crate) struct SceneModels<'a> {
    model: Model,
    scenes: Vec<Box<dyn ForwardModel + 'a>>,
}

/// Paths that were traced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathsUsed {
    /// How many, over all scenes.
    pub count: u64,
    /// The least relative effective sample size of a scene at the best fit.
    pub relative_sample_size: f64,
}

impl<'a> SceneModels<'a> {
    /// Those of `engine`, made for `parameters`, with the pixels that count.
    pub(crate) fn prepare(
        observations: &[Observation<'a>],
        observed: &[Observed],
        parameters: &Parameters,
        engine: &Engine<'a>,
    ) -> Result<Self> {
        let model = |(scene, (observation, observed)): (usize, (&Observation<'a>, &Observed))| {
            let state = parameters.state(scene)?;
            let mut model = engine.prepare(observation.target, &state, HEADROOM, scene)?;
            model.observe(observed.pixels())?;
            Ok(model)
        };
        let scenes = observations.iter().zip(observed).enumerate().map(model).collect::<Result<_>>()?;
        Ok(Self { model: engine.model, scenes })
    }

    /// Rough ones with at most `slices` depths, padded for kernels as `reach_px` says.
    pub(crate) fn prepare_roughly(
        observed: &[Observed<'a>],
        engine: &Engine<'a>,
        slices: usize,
        reach_px: impl Fn(&Observation) -> f64,
    ) -> Result<Self> {
        let model = |observed: &Observed<'a>| {
            let observation = &observed.observation;
            let target = crate::filter::Target { relief: None, ..observation.target };
            let mut model = engine.prepare_roughly(target, slices, reach_px(observation))?;
            model.observe(observed.pixels())?;
            Ok(model)
        };
        let scenes = observed.iter().map(model).collect::<Result<_>>()?;
        Ok(Self { model: engine.model, scenes })
    }

    /// By Gram matrices, if every scene has one.
    pub(crate) fn gram(observed: &[Observed<'a>], engine: &Engine<'a>) -> Result<Option<Self>> {
        let mut models: Vec<Box<dyn ForwardModel + 'a>> = Vec::new();
        for observed in observed {
            let target = observed.observation.target;
            match GramModel::new(engine.model, target, observed.pixels())? {
                Some(model) => models.push(Box::new(model)),
                None => return Ok(None),
            }
        }
        Ok(Some(Self { model: engine.model, scenes: models }))
    }

    /// The spread model of all.
    pub(crate) fn model(&self) -> Model {
        self.model
    }

    /// That of scene number `scene`.
    pub(crate) fn get(&self, scene: usize) -> &(dyn ForwardModel + 'a) {
        self.scenes[scene].as_ref()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &(dyn ForwardModel + 'a)> {
        self.scenes.iter().map(Box::as_ref)
    }

    /// Takes the pixels of scene number `scene` that count now.
    pub(crate) fn observe(&mut self, scene: usize, observed: &Observed) -> Result<()> {
        self.scenes[scene].observe(observed.pixels())
    }

    /// The object's light in every scene at `parameters`.
    pub(crate) fn images(&self, parameters: &Parameters) -> Result<Vec<Image>> {
        self.iter().enumerate().map(|(scene, model)| model.image(&parameters.state(scene)?)).collect()
    }

    /// How far all of them serve `parameters` too.
    pub(crate) fn coverage(&self, parameters: &Parameters) -> Result<Coverage> {
        let mut all = Coverage { served: true, cut: false };
        for (scene, model) in self.iter().enumerate() {
            let Coverage { served, cut } = model.coverage(&parameters.state(scene)?)?;
            let inside = parameters.iter().all(|(_, p)| is_inside(p, trusted(model, scene, p)));
            all = Coverage { served: all.served && served && inside, cut: all.cut || cut };
        }
        Ok(all)
    }

    /// Bounds of the coordinates of `parameters`, and of where the models may be trusted.
    pub(crate) fn bounds(&self, parameters: &Parameters) -> Vec<Bounds> {
        let bounds = |parameter: &Parameter| {
            let models = self.iter().enumerate();
            models.fold(parameter.coordinate_bounds(), |[low, high], (scene, model)| {
                let [least, most] = trusted(model, scene, parameter);
                [low.max(least), high.min(most)]
            })
        };
        parameters.iter().map(|(_, parameter)| bounds(parameter)).collect()
    }

    /// Paths traced, if any were.
    pub(crate) fn paths(&self, parameters: &Parameters) -> Result<Option<PathsUsed>> {
        let mut all: Option<PathsUsed> = None;
        for (scene, model) in self.iter().enumerate() {
            let Some(noise) = model.noise() else { continue };
            let size = noise.relative_sample_size(&parameters.state(scene)?)?;
            let PathsUsed { count, relative_sample_size } =
                all.unwrap_or(PathsUsed { count: 0, relative_sample_size: 1.0 });
            all = Some(PathsUsed {
                count: count + noise.paths(),
                relative_sample_size: relative_sample_size.min(size),
            });
        }
        Ok(all)
    }

    /// Independent batches of the paths, if all models are samples of paths.
    pub(crate) fn batches(&self) -> Option<usize> {
        let batches = self.iter().map(|model| model.noise().map(|noise| noise.batches()));
        batches.collect::<Option<Vec<_>>>()?.into_iter().min()
    }

    /// 2-D FFTs of one evaluation with derivatives.
    pub(crate) fn transforms(&self) -> usize {
        self.iter().map(ForwardModel::transforms).sum()
    }
}

/// Coordinates of `parameter` between which the model of scene number `scene` may be trusted.
fn trusted(model: &dyn ForwardModel, scene: usize, parameter: &Parameter) -> Bounds {
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    let Some(trust) = model.trust() else { return everywhere };
    let descriptor = parameter.descriptor();
    let mine = descriptor.scene.is_none_or(|of| of == scene);
    let Some(radius) = trust.radii.iter().find(|r| mine && r.quantity == descriptor.quantity) else {
        return everywhere;
    };
    let Radius { quantity, linear, logarithmic } = *radius;
    let value = trust.origin.value(quantity);
    let slope = if parameter.is_free() { descriptor.coordinate.slope(value).abs() } else { 0.0 };
    let (here, step) = (parameter.coordinate_of(value), (linear / slope).min(logarithmic));
    [here - step, here + step]
}

/// Whether the coordinate of `parameter` is not cut short by these bounds.
fn is_inside(parameter: &Parameter, [low, high]: Bounds) -> bool {
    let margin = 1e-6 * (high - low);
    margin.is_infinite() || (low + margin..high - margin).contains(&parameter.coordinate())
}
