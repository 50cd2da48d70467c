//! The fit of one channel of any number of scenes.

use super::Settings;
use super::inference::{ChannelFit, Status, infer};
use super::observation::{Aligned, Observation, Observed};
use super::optimise::{Begun, Driver, From, OTHER_WIDTHS, SceneModels, Task};
use crate::error::Result;
use crate::forward::Quantity;
use crate::relief::Relief;
use crate::scene::{FitOptions, Gain, ParameterOptions};

/// Reduced chi² above which a fit is said not to describe the image: half as much misfit as noise.
pub(super) const MISFIT: f64 = 1.5;

/// Optical depth of absorption that is believed of an image that does not determine it: it bends the kernel by less than 1 % of B.
const BELIEVED: f64 = 0.5;

/// Fits one channel's medium to `observations`; all scenes share it. `progress` is called after every render.
///
/// If the fit from the automatic start does not describe the images or ends on a bound, it may have ended in a false
/// minimum. Kernels of other widths are then tried as starts too, and the best of all fits counts; by Gram matrices they
/// always are. Edges and slopes explain a misfit in another way, so scenes that have some are not tried again.
///
/// # Errors
/// [`NothingToFit`](crate::Error::NothingToFit) if no pixel counts or every parameter is fixed,
/// [`OutOfRange`](crate::Error::OutOfRange) for contradictory options, [`NotFinite`](crate::Error::NotFinite) if a render is not
/// finite, those of [`Model::range`](crate::spread::Model::range).
///
/// Where no exposure is known and the image leaves sigma_a undetermined, any value describes it nearly as well, and the best one may lie
/// anywhere. A large one still bends the kernel and takes the others with it, so it is held to half an optical depth then.
pub fn fit_channel(
    observations: &[Observation],
    options: &FitOptions,
    settings: &Settings,
    progress: &dyn Fn(),
) -> Result<ChannelFit> {
    let fit = fit_within(observations, options, settings, progress)?;
    let most = BELIEVED / fit.median_z;
    let sigma_a = fit.parameters.id(Quantity::SigmaA);
    let is_open = observations.iter().all(|o| o.gain == Gain::Free)
        && options.sigma_a == ParameterOptions::default()
        && fit.covariance.status(sigma_a) == Status::Undetermined;
    if !is_open || fit.parameters.get(sigma_a).value() <= most {
        return Ok(fit);
    }
    let sigma_a = ParameterOptions { bounds: Some([0.0, most]), ..options.sigma_a };
    let held = fit_within(observations, &FitOptions { sigma_a, ..*options }, settings, progress)?;
    // At its bound it must not pass for determined.
    let id = held.parameters.id(Quantity::SigmaA);
    Ok(if held.covariance.status(id) == Status::Undetermined { held } else { fit })
}

/// The same, whatever becomes of sigma_a.
fn fit_within(
    observations: &[Observation],
    options: &FitOptions,
    settings: &Settings,
    progress: &dyn Fn(),
) -> Result<ChannelFit> {
    let aligned = Aligned::new(observations)?;
    let views = aligned.observations(observations);
    let registered = views.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
    let task =
        Task { observations, registered: &registered, places: &aligned.places, options, settings, progress };
    if let Some(pilot) = settings.engine().pilot() {
        let pilot = fit_channel(observations, options, &settings.with(pilot), progress)?;
        let value = |quantity| pilot.parameters.value(quantity);
        let options = options.or_started_at(value);
        return fit_from(&Task { options: &options, ..task }, From::Images, None);
    }
    let gram = if settings.gram { SceneModels::gram(&registered, &settings.engine())? } else { None };
    let mut best = fit_from(&task, From::Images, gram.as_ref())?;
    let automatic = settings.model.spreads() && options.is_unstarted();
    if automatic && best.by_gram.is_none() && is_doubtful(&best) && is_flat(observations) {
        for width in OTHER_WIDTHS {
            let other = fit_from(&task, From::Width(width), None)?;
            if other.reduced_chi2 < best.reduced_chi2 {
                best = other;
            }
        }
    }
    Ok(best)
}

/// The fit from one start; by Gram matrices, if there are any, from the best of all starts.
fn fit_from<'x>(task: &Task<'x, '_>, from: From, gram: Option<&'x SceneModels<'x>>) -> Result<ChannelFit> {
    let begun = Begun::new(task, from, gram)?;
    infer(task, Driver::new(task, begun)?.run()?)
}

/// Whether a fit may have ended in a false minimum.
fn is_doubtful(fit: &ChannelFit) -> bool {
    fit.reduced_chi2 > MISFIT
        || fit.lacks_fit()
        || fit.parameters.of_medium().any(|(_, p)| p.is_logarithmic() && p.is_at_bound())
}

fn is_flat(observations: &[Observation]) -> bool {
    observations.iter().all(|o| Relief::new(o.target.geometry).is_flat())
}
