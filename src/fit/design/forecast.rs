//! Predicted errors of a planned measurement: standard errors and correlations before anyone measures.
//!
//! At the true medium the expected Gauss-Newton matrix is the Fisher information of white noise, and its inverse bounds the
//! covariance from below (Cramér-Rao). It is that of a fit of the scene's own noiseless render, started at the truth.

use super::add_advice;
use crate::error::{Error, Result};
use crate::filter::{Filter, Target};
use crate::fit::Settings;
use crate::fit::scenes::{SceneFit, fit_scenes};
use crate::image::{Channel, Sampling};
use crate::imaging::VeilField;
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use crate::scene::{FitOptions, Gain, Noise, Observation, ObservedScene, ParameterOptions, Scene, Veil};
use crate::spread::Model;

/// How the planned images will be taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// Standard deviation of a pixel's noise, in units of the radiance.
    pub noise: f64,
    /// Whether the gain of each image will be unknown; it is 1 here.
    pub free_gain: bool,
    /// Whether the veil of each image will be unknown; it is 0 here.
    pub free_veil: bool,
}

/// The fit of noiseless images of `scenes` through `media`, one for each channel, with the noise of `plan`: its errors are
/// those to expect. `[fit]` of the first scene says what is known; its phase function, starts and bounds are not used.
///
/// # Errors
/// [`Error::NoKernel`] for the model `traced`, whose images have noise of their own; otherwise as [`fit_scenes`] and the renders.
pub fn forecast(
    scenes: &[Scene],
    media: &[Medium],
    plan: &Plan,
    settings: &Settings,
    filter: Filter,
) -> Result<SceneFit> {
    if settings.model == Model::Traced {
        return Err(Error::NoKernel);
    }
    let planned = |scene: &Scene| -> Result<ObservedScene> {
        let observation = plan.observation(scene, images(scene, media, settings, filter)?);
        let mut scene = scene.clone();
        // The planned image is one of the object as it stands: its noise is no error there.
        scene.object_noise = None;
        scene.fit = scene.fit.iter().zip(media).map(|(options, medium)| at(options, medium)).collect();
        Ok(ObservedScene { scene, observation })
    };
    let planned = scenes.iter().map(planned).collect::<Result<Vec<_>>>()?;
    // The optimum is known: nothing needs to be searched for.
    let mut fit = fit_scenes(&planned, &Settings { gram: false, ..*settings }, filter, &|| ())?;
    add_advice(&mut fit, &planned, settings, filter, &|| ())?;
    Ok(fit)
}

impl Plan {
    /// `scene` seen as `image`, as planned.
    fn observation(&self, scene: &Scene, image: Vec<Channel>) -> Observation {
        Observation {
            noise: Some(Noise::Level(self.noise)),
            gain: if self.free_gain { Gain::Free } else { Gain::Fixed(1.0) },
            veil: if self.free_veil { Veil::Free(VeilField::Constant) } else { Veil::Fixed(0.0) },
            ..Observation::plain(scene.path.clone(), image)
        }
    }
}

/// Starts at the truth, and what is held is held there.
fn at(options: &FitOptions, medium: &Medium) -> FitOptions {
    let known = |options: &ParameterOptions, truth: f64| ParameterOptions {
        start: Some(truth),
        fixed: options.fixed.map(|_| truth),
        bounds: None,
    };
    FitOptions {
        family: medium.phase().family(),
        sigma_s: known(&options.sigma_s, medium.sigma_s()),
        sigma_a: known(&options.sigma_a, medium.sigma_a()),
        phase: known(&options.phase, medium.phase().parameter()),
    }
}

/// What `scene` looks like through `media`, over its view.
fn images(scene: &Scene, media: &[Medium], settings: &Settings, filter: Filter) -> Result<Vec<Channel>> {
    let relief = filter.relief(&scene.geometry);
    let image = |(i, medium): (usize, &Medium)| -> Result<Channel> {
        let target = Target {
            radiance: &scene.object[i].image,
            behind: &scene.behind[i],
            geometry: &scene.geometry,
            border: scene.border,
            sampling: Sampling::Pixel,
            view: scene.view,
            relief: relief.as_ref(),
        };
        let image = settings.engine().render(target, *medium)?.image;
        Ok(Channel { name: scene.object[i].name.clone(), image })
    };
    media.iter().enumerate().take(scene.object.len()).map(image).collect()
}
