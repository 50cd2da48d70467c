//! Intervals by parametric bootstrap.

use super::Intervals;
use crate::error::Result;
use crate::filter::Backend;
use crate::fit::inference::{ChannelFit, Status};
use crate::fit::observation::white_noise::{with_noise, with_variance};
use crate::fit::observation::{NoiseTerm, Observation};
use crate::fit::parameters::Parameters;
use crate::fit::{Settings, fit_channel};
use crate::image::Image;
use crate::scene::FitOptions;
use rayon::prelude::*;

/// How often the noise is drawn, and by which random numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draws {
    /// Number of draws.
    pub count: usize,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Percentile intervals of the parametric bootstrap (Efron and Tibshirani 1993, ch. 6 and 13): the best fit with fresh noise,
/// fitted again as often as `draws` says; `progress` is called after each.
///
/// # Errors
/// As [`fit_channel`].
pub fn bootstrap(
    observations: &[Observation],
    fit: &ChannelFit,
    options: &FitOptions,
    settings: &Settings,
    draws: Draws,
    progress: &(dyn Fn() + Sync),
) -> Result<Intervals> {
    let Settings { model, method, max_iterations, tracing, .. } = *settings;
    let options = options.started_at(|quantity| fit.parameters.value(quantity));
    // What the fit left out for hidden light stays out: its render is compared with itself there.
    let refit = |draw: usize| -> Result<Parameters> {
        let noisy = |(i, o): (usize, &Observation)| {
            let seed = seed_of(draws.seed, (draw * observations.len() + i) as u64);
            match o.noise {
                Some(NoiseTerm::Variance(variance)) => with_variance(&fit.renders[i], variance, seed),
                Some(NoiseTerm::Sensor { read, shot }) => {
                    let of = |v: &f32| (read * read + shot * shot * f64::from(v.max(0.0))) as f32;
                    let render = &fit.renders[i];
                    let variance = Image { data: render.data.iter().map(of).collect(), ..*render };
                    with_variance(render, &variance, seed)
                }
                _ => with_noise(&fit.renders[i], fit.exposures[i].noise, seed),
            }
        };
        let noisy: Vec<Image> = observations.iter().enumerate().map(noisy).collect();
        let drawn: Vec<Observation> =
            observations.iter().zip(&noisy).map(|(o, image)| planned(o, image)).collect();
        let settings =
            Settings { model, method, max_iterations, backend: Backend::Cpu, gram: false, tracing };
        let found = fit_channel(&drawn, &options, &settings, &|| ())?.parameters;
        progress();
        Ok(found)
    };
    let estimates: Vec<Parameters> = (0..draws.count).into_par_iter().map(refit).collect::<Result<_>>()?;
    let interval = |(id, name): (_, &str)| {
        let mut sorted: Vec<f64> = estimates.iter().map(|found| found[name].value()).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
        let moved = fit.covariance.status(id) != Status::Fixed && !sorted.is_empty();
        (name.to_string(), moved.then(|| [Some(at(0.025)), Some(at(0.975))]))
    };
    Ok(fit.parameters.of_medium().map(|(id, parameter)| interval((id, parameter.name()))).collect())
}

/// `observation` seen as `image`, which is a render of its object as it stands: that one's noise is in the noise of a pixel.
fn planned<'a>(observation: &Observation<'a>, image: &'a Image) -> Observation<'a> {
    Observation { observed: image, object_noise: None, ..*observation }
}

/// A seed of its own for each draw: steps of the golden ratio, as by the generator SplitMix64.
fn seed_of(seed: u64, draw: u64) -> u64 {
    seed ^ draw.wrapping_mul(0x9e37_79b9_7f4a_7c15)
}
