//! Makes the tables of the model `wide-angle`: light scattered once by quadrature, the rest traced, both expanded
//! in the mixture's Gaussians.

mod mixture;
mod once;

use crate::error::Result;
use crate::medium::Medium;
use crate::phase::{Phase, PhaseFunction};
use crate::spread::wide_angle::layout::{Layout, Place, total_scale};
use crate::trace::{Likelihood, Scattered, log_spaced, trace_paths};
use mixture::Laid;

/// Edges of the radius bins, in units of z times the planar width of the phase function.
fn edges() -> Vec<f64> {
    log_spaced(1e-4, 1e4, 231)
}

/// Light, and light times radial slope, in bins of radius; the first and the last bin are open.
struct Radial {
    light: Vec<f64>,
    slope: Vec<f64>,
}

impl Radial {
    /// Adds the light scattered more than once of traced paths in `medium`, lengths in units of z, between `edges` in units of
    /// z times the planar width.
    fn trace<P: Likelihood>(
        &mut self,
        medium: Medium<P>,
        edges: &[f64],
        paths: u64,
        seed: u64,
    ) -> Result<()> {
        let width = medium.phase().planar_width();
        let records = trace_paths(medium, Scattered::Twice, paths, seed)?;
        for path in &records.paths {
            let bin = edges.partition_point(|&e| e <= f64::from(path.radius) / width);
            self.light[bin] += records.weight;
            self.slope[bin] += records.weight * f64::from(path.slope);
        }
        Ok(())
    }
}

/// Smallest and largest number of paths of a node, as a multiple of those requested.
const EFFORT: (f64, f64) = (0.02, 8.0);

/// Paths that a node needs, as a multiple of those requested, for the same noise relative to the scattered light. Only light
/// scattered more than once is traced; and where small-angle theory is off by some tau D² a /4 in the logarithm of the
/// light, most paths are absorbed on their excess length.
fn effort(place: &Place) -> f64 {
    let Place { tau, absorption, angle, .. } = *place;
    let more_than_once = 1.0 + tau * (-tau).exp() / (-tau).exp_m1();
    (more_than_once * (1.0 + tau * angle * angle * absorption / 8.0)).clamp(EFFORT.0, EFFORT.1)
}

/// The numbers of one node of the table with this `layout`, from `paths` times its `effort` paths.
///
/// # Errors
/// Those of the tracer.
pub fn node(layout: &Layout, place: &Place, paths: u64, seed: u64) -> Result<Vec<f32>> {
    let medium = Medium::new(place.tau, place.absorption, layout.family.phase(place.phase)?)?;
    let edges = edges();
    let mut radial = once::radial(&medium, &edges);
    let paths = (paths as f64 * effort(place)).ceil() as u64;
    match *medium.phase() {
        Phase::Gaussian(phase) => radial.trace(medium.with_phase(phase), &edges, paths, seed)?,
        Phase::HenyeyGreenstein(phase) => radial.trace(medium.with_phase(phase), &edges, paths, seed)?,
    }
    let phi = medium.scattered_total(1.0);
    let (total, rise) = (radial.light.iter().sum::<f64>(), radial.slope.iter().sum::<f64>());
    let light = Laid::light(layout.gaussians, &edges).shares(&radial.light);
    let slope = Laid::slope(layout.gaussians, &edges).shares(&radial.slope);
    // The gradient of a Gaussian of width s, r/s² G, has the integral sqrt(pi/2)/s.
    let per_light = rise / (total * (0.5 * std::f64::consts::PI).sqrt());
    let logarithms =
        [(total / phi).ln() / total_scale(place.angle), (per_light / medium.phase().planar_width()).ln()];
    let roots = light.iter().chain(&slope).map(|share| share.sqrt());
    Ok(logarithms.into_iter().chain(roots).map(|v| v as f32).collect())
}
