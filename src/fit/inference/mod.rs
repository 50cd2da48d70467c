//! From the optimum to what is known: covariance, errors of model and input, what the data determine, and whether the residual
//! is noise.

mod channel_fit;
mod combination;
mod covariance;
mod diagnosis;
mod displacement;
mod error_images;
mod exposure;
mod identifiability;
mod input_error;
mod lack_of_fit;
mod model_error;

pub use channel_fit::ChannelFit;
pub use combination::Combination;
pub use covariance::{Covariance, Status};
pub use diagnosis::{Cause, Finding};
pub use error_images::ErrorSource;
pub use exposure::ExposureEstimate;
pub use input_error::InputError;
pub use model_error::ModelError;

pub(super) use covariance::Z95;
pub(super) use displacement::Displacement;
pub(super) use error_images::ErrorKind;

use super::observation::{Observation, Observed};
use super::optimise::{Optimum, Task};
use crate::error::Result;
use crate::forward::Exposure;
use crate::medium::Medium;
use crate::scene::Gain;
use crate::spread::Model;
use diagnosis::Diagnosis;
use exposure::exposures;
use identifiability::determined;
use lack_of_fit::{LACKING, lack_of_fit};
use nalgebra::DVector;

/// What `optimum` says of the medium of `task`.
///
/// # Errors
/// Those of renders by the model and by the reference of all errors.
pub(super) fn infer<'a>(task: &Task<'_, 'a>, mut optimum: Optimum<'a>) -> Result<ChannelFit> {
    let size = Size::of(task, &optimum);
    let (transforms, paths) = (optimum.models.transforms(), optimum.models.paths(&optimum.parameters)?);
    let errors = Errors::at(task, &mut optimum, &size)?;
    let first = task.observations[0].target;
    let mut fit = ChannelFit {
        model: task.settings.model,
        start: optimum.start,
        model_error: errors.of_model,
        input_error: errors.of_inputs,
        gauss_newton_step: errors.gauss_newton_step,
        lack_of_fit: errors.lack_of_fit,
        misfit: errors.misfit,
        findings: errors.findings,
        exposures: errors.exposures,
        covariance: errors.covariance,
        cost: optimum.equations.cost,
        reduced_chi2: size.reduced_chi2,
        fitted: size.fitted,
        pixels: size.pixels,
        hidden_pixels: optimum.observed.iter().map(|o| o.hidden).sum(),
        outside_pixels: optimum.observed.iter().map(|o| o.outside).sum(),
        median_z: task.lengths().median,
        pixel_pitch: first.geometry.median_pixel_pitch(),
        view_px: first.view.width.min(first.view.height),
        converged: optimum.converged,
        settled: optimum.settled,
        cut: optimum.cut,
        stop: optimum.stop,
        iterations: optimum.iterations,
        evaluations: optimum.evaluations,
        by_gram: optimum.by_gram,
        gram_evaluations: optimum.gram_evaluations,
        transforms,
        paths,
        free_gain: task.observations.iter().any(|o| o.gain == Gain::Free),
        renders: optimum.images,
        unseen: optimum.unseen,
        parameters: optimum.parameters,
        determined: Vec::new(),
    };
    fit.determined = determined(task.observations, &fit);
    Ok(fit)
}

/// How many numbers were fitted to how many pixels, and how well.
struct Size {
    fitted: usize,
    pixels: usize,
    reduced_chi2: f64,
}

impl Size {
    fn of(task: &Task, optimum: &Optimum) -> Self {
        let free_exposures = task.observations.iter().map(Observation::free_exposure).sum::<usize>();
        let fitted = optimum.parameters.free_count() + free_exposures;
        let pixels = optimum.observed.iter().map(Observed::count).sum::<usize>();
        let reduced_chi2 = 2.0 * optimum.equations.cost / pixels.saturating_sub(fitted).max(1) as f64;
        Self { fitted, pixels, reduced_chi2 }
    }
}

/// How well everything is known at an optimum.
struct Errors {
    covariance: Covariance,
    gauss_newton_step: DVector<f64>,
    exposures: Vec<ExposureEstimate>,
    of_model: Option<ModelError>,
    of_inputs: InputError,
    findings: Vec<Finding>,
    lack_of_fit: f64,
    misfit: f64,
}

impl Errors {
    fn at<'a>(task: &Task<'_, 'a>, optimum: &mut Optimum<'a>, size: &Size) -> Result<Self> {
        let (equations, parameters) = (&optimum.equations, &optimum.parameters);
        // Where the noise was only estimated, a misfit counts as noise for the error bars.
        let variance_scale = if task.estimates_noise() { size.reduced_chi2.max(1.0) } else { 1.0 };
        let mut covariance = Covariance::new(equations, parameters, variance_scale);
        let gauss_newton_step = covariance.step(&equations.gradient);
        let mut at_optimum = Displacement {
            exposures: Displacement::exposures(equations),
            unseen: &optimum.unseen,
            observed: &optimum.observed,
            models: &mut optimum.models,
            parameters,
            covariance: &covariance,
            engine: task.settings.engine(),
            progress: task.progress,
        };
        let (of_model, images) = ModelError::new(&mut at_optimum)?.unzip();
        let of_inputs = InputError::new(&mut at_optimum)?;
        let diagnosis = Diagnosis::new(&at_optimum, images.as_ref())?;
        let scenes = optimum.observed.iter().zip(&optimum.images).enumerate();
        let (model, medium) = (at_optimum.models.model(), parameters.medium()?);
        let inflation = |i: usize, side: usize| {
            let by_object =
                by_object(&optimum.observed[i], equations.scenes[i].linear.exposure, (model, &medium), side);
            diagnosis.block_inflation(i, side).max(by_object.unwrap_or(1.0))
        };
        let lacking = scenes.map(|(i, (o, image))| lack_of_fit(o, image, |side| inflation(i, side)));
        let lack_of_fit = lacking.fold(0.0, f64::max);
        let misfit = size.reduced_chi2 / diagnosis.underestimated(&at_optimum);
        let wider = diagnosis.wider(&covariance, lack_of_fit > LACKING);
        covariance.widen(wider, parameters);
        if let Some(error) = &of_model {
            covariance.mark_undetermined(parameters, |g| error.reference_of(g));
        }
        let exposures = exposures(equations, &optimum.observed, &covariance);
        let findings = diagnosis.findings;
        Ok(Self {
            covariance,
            gauss_newton_step,
            exposures,
            of_model,
            of_inputs,
            findings,
            lack_of_fit,
            misfit,
        })
    }
}

/// Variance of the mean of a block of `side`² pixels over that of white noise, by the noise of the clear image; `None` if it has none.
fn by_object(
    observed: &Observed,
    exposure: Exposure,
    (model, medium): (Model, &Medium),
    side: usize,
) -> Option<f64> {
    let weights = (exposure.gain, observed.precision(), observed.count());
    let noise = observed.object_noise.as_ref()?;
    noise.block_inflation((model, medium), weights, &observed.observation, side).ok()
}
