//! Intervals that do not rest on the curvature at the optimum: profile likelihood and parametric bootstrap.

use super::noise::{with_noise, with_variance};
use super::{ChannelFit, Datum, Exposure, NoiseTerm, Parameters, Settings, Status, fit_channel};
use crate::error::Result;
use crate::filter::Backend;
use crate::image::Image;
use crate::scene::FitOptions;
use rayon::prelude::*;

/// Ends of 95 % intervals of sigma_s, sigma_a and the shape; an end is `None` where the data do not close the interval, an interval
/// where the parameter is fixed.
pub type Intervals = [Option<[Option<f64>; 2]>; 3];

/// 95 % quantile of chi² with one degree of freedom.
const CHI2_95: f64 = 3.841_459;
/// Widest half-interval that is looked for, in standard errors, and in logarithms (or sigma_a z) where none is known.
const WIDEST: [f64; 2] = [8.0, 3.0];
/// Steps of the search for an end, and the share of [`CHI2_95`] to which it is found.
const MOST_STEPS: usize = 12;
const CLOSE: f64 = 0.02;

/// Profile-likelihood intervals (Venzon and Moolgavkar 1988): where chi², minimised over the other parameters, gain and
/// veil, is 3.84 above its least value, in units of the reduced chi² if the noise was estimated. An end at a bound is that
/// bound.
///
/// # Errors
/// As [`fit_channel`].
pub fn profile(
    data: &[Datum],
    fit: &ChannelFit,
    options: &FitOptions,
    settings: &Settings,
) -> Result<Intervals> {
    let estimated = |e: &Exposure| Some(NoiseTerm::Level(e.noise));
    let known: Vec<Datum> = data
        .iter()
        .zip(&fit.exposures)
        .map(|(d, e)| Datum { noise: d.noise.or_else(|| estimated(e)), ..*d })
        .collect();
    let inflation = if data.iter().any(|d| d.noise.is_none()) { fit.reduced_chi2.max(1.0) } else { 1.0 };
    let mut intervals = [None; 3];
    for (i, interval) in intervals.iter_mut().enumerate() {
        if fit.uncertainty.status(i) == Status::Fixed {
            continue;
        }
        let rise = |value: f64| -> Result<f64> {
            let mut held = FitOptions { start: fit.parameters.values().map(Some), ..*options };
            if fit.parameters.free_count() > 1 {
                held.fixed[i] = Some(value);
            } else {
                // Something must be free for a fit: next to nothing.
                held.bounds[i] = Some([value, value * (1.0 + 1e-9) + 1e-300]);
                held.start[i] = Some(value);
            }
            let other = fit_channel(&known, &held, &Settings { sums: false, ..*settings })?;
            Ok(2.0 * (other.cost - fit.cost) / inflation)
        };
        *interval = Some([end(fit, i, -1.0, &rise)?, end(fit, i, 1.0, &rise)?]);
    }
    Ok(intervals)
}

/// One end of the interval of parameter `i`, below (-1) or above (1) its value.
fn end(fit: &ChannelFit, i: usize, side: f64, rise: &dyn Fn(f64) -> Result<f64>) -> Result<Option<f64>> {
    let parameters = &fit.parameters;
    // Of g the coordinate falls where the value rises.
    let side_of_coordinate = side * parameters.slope(i).signum();
    let here = parameters.coordinate(i, parameters.values()[i]);
    let at = |distance: f64| parameters.value_at(i, here + side_of_coordinate * distance);
    let scale = if Parameters::is_logarithmic(i) { 1.0 } else { 1.0 / fit.median_z };
    let (first, widest) = match fit.uncertainty.std_error(i) {
        Some(error) => (1.96 * error, WIDEST[0] * error),
        None => (0.5 * scale, WIDEST[1] * scale),
    };
    let [low, high] = parameters.bounds(i);
    let bound = if side < 0.0 { low } else { high };
    let room = (parameters.coordinate(i, bound) - here).abs();
    let farthest = widest.min(room);
    // Distance and the root of the rise, which is nearly proportional to it.
    let (mut inner, mut outer): ((f64, f64), Option<(f64, f64)>) = ((0.0, 0.0), None);
    let mut distance = first.min(farthest);
    let target = CHI2_95.sqrt();
    for _ in 0..MOST_STEPS {
        let root = rise(at(distance))?.max(0.0).sqrt();
        if (root / target - 1.0).abs() < CLOSE {
            return Ok(Some(at(distance)));
        }
        if root > target {
            outer = Some((distance, root));
        } else {
            inner = (distance, root);
            if distance >= farthest {
                return Ok((farthest < widest || room <= widest).then_some(bound));
            }
        }
        distance = match outer {
            Some(outer) => {
                let straight = inner.0 + (outer.0 - inner.0) * (target - inner.1) / (outer.1 - inner.1);
                straight.clamp(inner.0 + 0.05 * (outer.0 - inner.0), outer.0 - 0.05 * (outer.0 - inner.0))
            }
            None => (2.0 * distance).min(farthest),
        };
    }
    Ok(Some(at(distance)))
}

/// Percentile intervals of the parametric bootstrap (Efron and Tibshirani 1993, ch. 6 and 13): the best fit with fresh noise,
/// fitted again, `draws` times; `progress` is called after each.
///
/// # Errors
/// As [`fit_channel`].
pub fn bootstrap(
    data: &[Datum],
    fit: &ChannelFit,
    options: &FitOptions,
    settings: &Settings,
    (draws, seed): (usize, u64),
    progress: &(dyn Fn() + Sync),
) -> Result<Intervals> {
    let (model, method, max_iterations) = (settings.model, settings.method, settings.max_iterations);
    let options = FitOptions { start: fit.parameters.values().map(Some), ..*options };
    // What the fit left out for hidden light stays out: its render is compared with itself there.
    let estimates = (0..draws).into_par_iter().map(|draw| {
        let noisy = |(i, datum): (usize, &Datum)| {
            let (render, seed) = (&fit.renders[i], seed_of(seed, (draw * data.len() + i) as u64));
            match datum.noise {
                Some(NoiseTerm::Variance(variance)) => with_variance(render, variance, seed),
                _ => with_noise(render, fit.exposures[i].noise, seed),
            }
        };
        let noisy: Vec<Image> = data.iter().enumerate().map(noisy).collect();
        let drawn: Vec<Datum> =
            data.iter().zip(&noisy).map(|(d, image)| Datum { observed: image, ..*d }).collect();
        let settings =
            Settings { model, method, max_iterations, backend: Backend::Cpu, sums: false, progress: &|| () };
        let values = fit_channel(&drawn, &options, &settings)?.parameters.values();
        progress();
        Ok(values)
    });
    let estimates: Vec<[f64; 3]> = estimates.collect::<Result<_>>()?;
    Ok(std::array::from_fn(|i| {
        let mut sorted: Vec<f64> = estimates.iter().map(|values| values[i]).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share).round() as usize];
        (fit.uncertainty.status(i) != Status::Fixed && !sorted.is_empty())
            .then(|| [Some(at(0.025)), Some(at(0.975))])
    }))
}

/// A seed of its own for each draw: steps of the golden ratio, as by the generator SplitMix64.
fn seed_of(seed: u64, draw: u64) -> u64 {
    seed ^ draw.wrapping_mul(0x9e37_79b9_7f4a_7c15)
}
