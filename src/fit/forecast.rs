//! What a planned measurement will tell: standard errors and correlations before anyone measures.
//!
//! At the true medium the expected Gauss-Newton matrix is the Fisher information of white noise, and its inverse bounds the
//! covariance from below (Cramér-Rao). It is that of a fit of the scene's own noiseless render, started at the truth.

use super::Settings;
use super::scenes::{SceneFit, fit_scenes};
use crate::error::Result;
use crate::filter::{Filter, Optics, Target};
use crate::image::{Channel, Image};
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use crate::scene::{FitOptions, Gain, Noise, Observation, ObservedScene, Scene, Veil};

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
/// As [`fit_scenes`] and the renders.
pub fn forecast(
    scenes: &[Scene],
    media: &[Medium],
    plan: &Plan,
    settings: &Settings,
    filter: Filter,
) -> Result<SceneFit> {
    let planned = |scene: &Scene| -> Result<ObservedScene> {
        let mut scene = scene.clone();
        let observation = Observation {
            path: scene.path.clone(),
            image: images(&scene, media, settings, filter)?,
            noise: Some(Noise::Level(plan.noise)),
            mask: None,
            gain: if plan.free_gain { Gain::Free } else { Gain::Fixed(1.0) },
            veil: if plan.free_veil { Veil::Free } else { Veil::Fixed(0.0) },
            gain_error: 0.0,
            hidden_share_max: 0.01,
        };
        scene.fit = scene.fit.iter().zip(media).map(|(options, medium)| at(options, medium)).collect();
        Ok(ObservedScene { scene, observation })
    };
    let planned = scenes.iter().map(planned).collect::<Result<Vec<_>>>()?;
    // The optimum is known: nothing needs to be searched for.
    let mut fit = fit_scenes(&planned, &Settings { sums: false, ..*settings }, filter)?;
    fit.add_advice(&planned, settings, filter)?;
    Ok(fit)
}

/// Starts at the truth, and what is held is held there.
fn at(options: &FitOptions, medium: &Medium) -> FitOptions {
    let truth = medium.parameters();
    let held = |i: usize| options.fixed[i].map(|_| truth[i]);
    FitOptions {
        family: medium.phase().family(),
        start: truth.map(Some),
        fixed: std::array::from_fn(held),
        bounds: [None; 3],
    }
}

/// What `scene` looks like through `media`, over its view.
fn images(scene: &Scene, media: &[Medium], settings: &Settings, filter: Filter) -> Result<Vec<Channel>> {
    let relief = filter.relief(&scene.geometry);
    let image = |i: usize| -> Result<Channel> {
        let optics = Optics { model: settings.model, medium: media[i] };
        let target = Target {
            radiance: &scene.object[i].image,
            behind: &scene.behind[i],
            geometry: &scene.geometry,
            border: scene.border,
            view: scene.view,
            relief: relief.as_ref(),
        };
        let image: Image = settings.backend.prepare(target, &optics, 1.0)?.render(&optics)?;
        Ok(Channel { name: scene.object[i].name.clone(), image })
    };
    (0..scene.object.len()).map(image).collect()
}
