//! Makes the table of the model `wide-angle`: light scattered once by quadrature, the rest traced, both laid out on
//! the mixture's Gaussians.

mod mixture;
mod once;

use crate::error::Result;
use crate::phase::{Gaussian, b_of_spread_angle};
use crate::spread::wide_angle::table::{NUMBERS, Place, RUNGS, bending};
use crate::trace::{Turbid, log_spaced, trace_histories};
use mixture::Laid;

/// Edges of the radius bins, in units of z sqrt(B).
fn edges() -> Vec<f64> {
    log_spaced(1e-4, 1e4, 231)
}

/// Light, and light times radial slope, in bins of radius; the first and the last bin are open.
struct Radial {
    light: Vec<f64>,
    slope: Vec<f64>,
}

/// Most paths of a node, as a multiple of those asked for.
const MOST: f64 = 8.0;

/// The numbers of one node from `paths` paths; more where most of them are absorbed on the excess path, some tau D² a
/// /4 of the light.
///
/// # Errors
/// Those of the tracer.
pub fn node(place: &Place, paths: u64, seed: u64) -> Result<[f32; NUMBERS]> {
    let Place { tau, absorption, spread_angle } = *place;
    let b = b_of_spread_angle(spread_angle);
    let edges = edges();
    let phase = Gaussian::new(b)?;
    let mut radial = once::radial(tau, absorption, &phase, &edges);
    let effort = (1.0 + tau * spread_angle * spread_angle * absorption / 8.0).min(MOST);
    let paths = (paths as f64 * effort) as u64;
    let histories = trace_histories(Turbid { sigma_s: tau, sigma_a: absorption, phase }, paths, seed)?;
    for history in histories.paths.iter().filter(|h| h.scatterings > 1) {
        let bin = edges.partition_point(|&e| e <= f64::from(history.radius) / b.sqrt());
        radial.light[bin] += histories.weight;
        radial.slope[bin] += histories.weight * f64::from(history.slope);
    }
    let phi = -(-absorption).exp() * (-tau).exp_m1();
    let (total, rise) = (radial.light.iter().sum::<f64>(), radial.slope.iter().sum::<f64>());
    let light = Laid::light(&edges).shares(&radial.light);
    let slope = Laid::slope(&edges).shares(&radial.slope);
    let mut numbers = [0.0; NUMBERS];
    numbers[0] = ((total / phi).ln() / bending(spread_angle)) as f32;
    // The gradient of a Gaussian of width s, r/s² G, has the integral sqrt(pi/2)/s.
    numbers[1] = (rise / (total * (0.5 * std::f64::consts::PI).sqrt())).ln() as f32;
    for j in 0..RUNGS {
        numbers[2 + j] = light[j].sqrt() as f32;
        numbers[2 + RUNGS + j] = slope[j].sqrt() as f32;
    }
    Ok(numbers)
}
