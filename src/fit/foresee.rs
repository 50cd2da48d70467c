//! What a model would know of scenes that another has fitted.

use super::displacement::Displacement;
use super::observed::Observed;
use super::problem::{Problem, Source};
use super::renders::Renders;
use super::{ChannelFit, Datum, ModelError, Parameters, Settings, Uncertainty, path_lengths};
use crate::error::Result;
use crate::geometry::Geometry;
use crate::scene::FitOptions;

/// What `settings.model` would know, and what its error would be, at the medium of another model's fit `pilot`: one render
/// instead of a fit. `None` where the model has no kernels or nothing to fit.
pub(super) fn foresee<'a>(
    data: &[Datum<'a>],
    options: &FitOptions,
    settings: &Settings<'a>,
    pilot: &ChannelFit,
) -> Result<Option<(Parameters, Uncertainty, Option<ModelError>)>> {
    let scenes: Vec<&Geometry> = data.iter().map(|d| d.target.geometry).collect();
    let mut parameters = match Parameters::new(options, settings.model, path_lengths(&scenes)) {
        Err(error) if error.is_about_model() => return Ok(None),
        parameters => parameters?,
    };
    parameters.set_internal(&pilot.parameters.internal());
    let mut observed = data.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
    for ((o, exposure), share) in observed.iter_mut().zip(&pilot.exposures).zip(&pilot.hidden_shares) {
        o.noise = exposure.noise;
        if let Some(share) = share {
            o.leave_out_hidden(share)?;
        }
    }
    let mut renders = Renders::new(data, &observed, &parameters, settings)?;
    let problem = Problem::new(Source::Renders(&renders), &observed, &parameters, settings);
    let equations = problem.equations(&parameters.internal())?;
    let uncertainty = Uncertainty::new(&equations, &parameters, pilot.median_z, 1.0);
    let error = ModelError::new(&mut Displacement {
        data,
        observed: &observed,
        renders: &mut renders,
        parameters: &parameters,
        uncertainty: &uncertainty,
        exposures: &pilot.exposures,
        settings,
    })?;
    Ok(Some((parameters, uncertainty, error)))
}
