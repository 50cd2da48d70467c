//! Intervals by profile likelihood.

use super::Intervals;
use crate::error::Result;
use crate::fit::inference::{ChannelFit, Status};
use crate::fit::observation::{NoiseTerm, Observation};
use crate::fit::parameters::{Id, Parameter};
use crate::fit::{Settings, fit_channel};
use crate::scene::FitOptions;

/// 95 % quantile of chi² with one degree of freedom.
const CHI2_95: f64 = 3.841_459;
/// Widest half-interval that is looked for, in standard errors, and in natural scales of the coordinate where none is known.
const WIDEST_IN_ERRORS: f64 = 8.0;
const WIDEST_IN_SCALES: f64 = 3.0;
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
    observations: &[Observation],
    fit: &ChannelFit,
    options: &FitOptions,
    settings: &Settings,
    progress: &dyn Fn(),
) -> Result<Intervals> {
    let known: Vec<Observation> = observations
        .iter()
        .zip(&fit.exposures)
        .map(|(o, e)| Observation { noise: o.noise.or(Some(NoiseTerm::Level(e.noise))), ..*o })
        .collect();
    let estimated = observations.iter().any(|o| o.noise.is_none());
    let unit = if estimated { fit.reduced_chi2.max(1.0) } else { 1.0 };
    let settings = Settings { gram: false, ..*settings };
    let start = options.started_at(|quantity| fit.parameters.value(quantity));
    let free_of_medium = fit.parameters.of_medium().filter(|(_, p)| p.is_free()).count();
    let interval = |(id, parameter): (Id, &Parameter)| {
        if fit.covariance.status(id) == Status::Fixed {
            return Ok((parameter.name().to_string(), None));
        }
        let quantity = parameter.descriptor().quantity;
        let rise = |value: f64| -> Result<f64> {
            let held = match free_of_medium {
                1 => start.nearly_held_at(quantity, value),
                _ => start.held_at(quantity, value),
            };
            let other = fit_channel(&known, &held, &settings, progress)?;
            Ok(2.0 * (other.cost - fit.cost) / unit)
        };
        let search = Search { parameter, std_error: fit.covariance.std_error(id), rise: &rise };
        let ends = [search.end(Side::Below)?, search.end(Side::Above)?];
        Ok((parameter.name().to_string(), Some(ends)))
    };
    fit.parameters.of_medium().map(interval).collect()
}

/// A side of the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Below,
    Above,
}

/// The search for the ends of the interval of one parameter.
struct Search<'a> {
    parameter: &'a Parameter,
    std_error: Option<f64>,
    /// How much chi² rises if the parameter is held at a value.
    rise: &'a dyn Fn(f64) -> Result<f64>,
}

/// A distance from the estimate and the root of the rise there, which is nearly proportional to it.
#[derive(Debug, Clone, Copy)]
struct Tried {
    distance: f64,
    root: f64,
}

impl Search<'_> {
    /// One end of the interval; `None` if the data do not close it.
    fn end(&self, side: Side) -> Result<Option<f64>> {
        let parameter = self.parameter;
        // Of g the coordinate falls where the value rises.
        let sign = if side == Side::Below { -1.0 } else { 1.0 } * parameter.slope().signum();
        let here = parameter.coordinate();
        let at = |distance: f64| parameter.value_at(here + sign * distance);
        let (first, widest) = match self.std_error {
            Some(error) => (1.96 * error, WIDEST_IN_ERRORS * error),
            None => (0.5 * parameter.scale(), WIDEST_IN_SCALES * parameter.scale()),
        };
        let [low, high] = parameter.bounds();
        let bound = if side == Side::Below { low } else { high };
        let room = (parameter.coordinate_of(bound) - here).abs();
        let farthest = widest.min(room);
        let mut inner = Tried { distance: 0.0, root: 0.0 };
        let mut outer: Option<Tried> = None;
        let mut distance = first.min(farthest);
        let target = CHI2_95.sqrt();
        for _ in 0..MOST_STEPS {
            let root = (self.rise)(at(distance))?.max(0.0).sqrt();
            if (root / target - 1.0).abs() < CLOSE {
                return Ok(Some(at(distance)));
            }
            if root > target {
                outer = Some(Tried { distance, root });
            } else {
                inner = Tried { distance, root };
                if distance >= farthest {
                    return Ok((farthest < widest || room <= widest).then_some(bound));
                }
            }
            distance = match outer {
                Some(outer) => between(inner, outer, target),
                None => (2.0 * distance).min(farthest),
            };
        }
        Ok(Some(at(distance)))
    }
}

/// The distance at which the root is `target`, if it is a straight line between two that were tried.
fn between(inner: Tried, outer: Tried, target: f64) -> f64 {
    let gap = outer.distance - inner.distance;
    let straight = inner.distance + gap * (target - inner.root) / (outer.root - inner.root);
    straight.clamp(inner.distance + 0.05 * gap, outer.distance - 0.05 * gap)
}
