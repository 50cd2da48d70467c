//! What a model would know of scenes that another has fitted.

use crate::error::Result;
use crate::filter::Target;
use crate::fit::Settings;
use crate::fit::inference::{ChannelFit, Covariance, Displacement, ModelError};
use crate::fit::observation::{Observation, Observed, Unseen};
use crate::fit::optimise::{Problem, SceneModels};
use crate::fit::parameters::Parameters;
use crate::forward::Exposure;
use crate::geometry::path_lengths;
use crate::image::Image;
use crate::scene::FitOptions;

/// What would be known of some parameters.
pub(crate) struct Prospect {
    pub parameters: Parameters,
    pub covariance: Covariance,
    pub model_error: Option<ModelError>,
}

/// Scenes as they would be fitted.
pub(crate) struct Planned<'x, 'a> {
    pub observations: &'x [Observation<'a>],
    /// Gain, veil and noise of each.
    pub exposures: &'x [PlannedExposure],
    pub unseen: &'x [Unseen],
    /// By what every variance is multiplied.
    pub variance_scale: f64,
}

/// How a scene would be exposed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlannedExposure {
    pub exposure: Exposure,
    pub noise: f64,
}

impl PlannedExposure {
    /// As each scene of `fit` was.
    pub(crate) fn of(fit: &ChannelFit) -> Vec<Self> {
        let planned = |e: &crate::fit::inference::ExposureEstimate| Self {
            exposure: Exposure { gain: e.gain, veil: e.veil },
            noise: e.noise,
        };
        fit.exposures.iter().map(planned).collect()
    }
}

impl Prospect {
    /// What `settings.model` would know at the medium of another model's fit `pilot`: one render instead of a fit. `None`
    /// where the model has no kernels or nothing to fit.
    pub(super) fn from_pilot<'a>(
        observations: &[Observation<'a>],
        options: &FitOptions,
        settings: &Settings<'a>,
        pilot: &ChannelFit,
        progress: &dyn Fn(),
    ) -> Result<Option<Self>> {
        let scenes: Vec<_> = observations.iter().map(|o| (o.target.geometry, o.target.radiance)).collect();
        let mut parameters = match Parameters::new(options, settings.model, path_lengths(&scenes)) {
            Err(error) if error.is_about_model() => return Ok(None),
            parameters => parameters?,
        };
        parameters.take_all(&pilot.parameters);
        let planned = Planned {
            observations,
            exposures: &PlannedExposure::of(pilot),
            unseen: &pilot.unseen,
            variance_scale: 1.0,
        };
        Self::new(&planned, parameters, settings, progress).map(Some)
    }

    /// What the scenes of `planned` determine of `parameters`, and the error of the model there.
    pub(crate) fn new<'a>(
        planned: &Planned<'_, 'a>,
        parameters: Parameters,
        settings: &Settings<'a>,
        progress: &dyn Fn(),
    ) -> Result<Self> {
        let mut observed = planned.observations.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
        observed.iter_mut().zip(planned.exposures).for_each(|(o, exposure)| o.noise = exposure.noise);
        for (o, unseen) in observed.iter_mut().zip(planned.unseen) {
            o.leave_out(unseen)?;
        }
        let engine = settings.engine();
        let mut models = SceneModels::prepare(planned.observations, &observed, &parameters, &engine)?;
        let problem = Problem::new(&models, &observed, &parameters, progress);
        let equations = problem.equations(&parameters.point())?;
        let covariance = Covariance::new(&equations, &parameters, planned.variance_scale);
        let model_error = ModelError::new(&mut Displacement {
            observed: &observed,
            models: &mut models,
            parameters: &parameters,
            covariance: &covariance,
            exposures: planned.exposures.iter().map(|e| e.exposure).collect(),
            unseen: planned.unseen,
            engine,
            progress,
        })?
        .map(|(error, _)| error);
        Ok(Self { parameters, covariance, model_error })
    }
}

/// The image that `target`, scene number `scene`, would give if it were exposed like `observation`.
pub(crate) fn seen(
    target: Target,
    observation: &Observation,
    exposure: PlannedExposure,
    parameters: &Parameters,
    settings: &Settings,
    scene: usize,
) -> Result<Image> {
    let image = settings.engine().image(target, &parameters.state(scene)?, scene, 1.0)?;
    Ok(observation.exposed(image, exposure.exposure))
}
