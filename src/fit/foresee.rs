//! What a model would know of scenes that another has fitted.

use super::displacement::Displacement;
use super::observed::Observed;
use super::problem::{Problem, Source};
use super::renders::Renders;
use super::{ChannelFit, Datum, Exposure, ModelError, Parameters, Settings, Uncertainty, path_lengths};
use crate::error::Result;
use crate::geometry::Geometry;
use crate::image::Image;
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
    let (uncertainty, error) =
        known_at(data, &pilot.exposures, &pilot.hidden_shares, &parameters, (pilot.median_z, 1.0), settings)?;
    Ok(Some((parameters, uncertainty, error)))
}

/// What scenes, exposed and with shares of hidden light as given, tell of `parameters`, every variance multiplied by `inflation`;
/// and the error of the model there.
pub(super) fn known_at<'a>(
    data: &[Datum<'a>],
    exposures: &[Exposure],
    hidden_shares: &[Option<Image>],
    parameters: &Parameters,
    (median_z, inflation): (f64, f64),
    settings: &Settings<'a>,
) -> Result<(Uncertainty, Option<ModelError>)> {
    let mut observed = data.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
    observed.iter_mut().zip(exposures).for_each(|(o, exposure)| o.noise = exposure.noise);
    for (o, share) in observed.iter_mut().zip(hidden_shares) {
        if let Some(share) = share {
            o.leave_out_hidden(share)?;
        }
    }
    let mut renders = Renders::new(data, &observed, parameters, settings)?;
    let problem = Problem::new(Source::Renders(&renders), &observed, parameters, settings);
    let equations = problem.equations(&parameters.internal())?;
    let uncertainty = Uncertainty::new(&equations, parameters, median_z, inflation);
    let error = ModelError::new(&mut Displacement {
        data,
        observed: &observed,
        renders: &mut renders,
        parameters,
        uncertainty: &uncertainty,
        exposures,
        settings,
    })?;
    Ok((uncertainty, error))
}
