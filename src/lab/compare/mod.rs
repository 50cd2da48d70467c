//! How well a spread kernel agrees with traced light.
//!
//! The first statistic is the worst error of the encircled energy over the radii that matter: with E the scattered light
//! within radius r, S the traced scattered total and r50 the median radius of the traced scattered light,
//! max |E_model(r) - E_traced(r)| / S over the tally's edges up to 6 r50. It responds to a wrong total as well as to a
//! wrong profile, and unlike the second moment it does not depend on the few grazing paths of wide-angle scattering.
//! Beside it stands the relative [rms error](rms_error) of the light per radius, which is the paper's kind of error.

mod rms;

pub use rms::{RmsError, rms_error};

use crate::spread::SpreadKernel;
use crate::trace::{Estimate, RadialProfile};

/// Radii up to this many median radii of the traced scattered light count.
pub const MEDIAN_RADII: f64 = 6.0;

/// The worst disagreement of a kernel with traced light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstError {
    /// |E_model - E_traced| as a share of the traced scattered light, with its standard error at that radius.
    pub share: Estimate,
    /// The radius at which it occurs, length.
    pub radius: f64,
}

/// The worst error of the encircled energy of `kernel` against `traced`; `None` if no scattered light was traced.
pub fn worst_encircled_error(traced: &RadialProfile, kernel: &dyn SpreadKernel) -> Option<WorstError> {
    let total = traced.scattered();
    if total.value <= 0.0 {
        return None;
    }
    let end = MEDIAN_RADII * traced.quantile_radius(0.5);
    let radii = traced.edges.iter().enumerate().take_while(|(_, r)| **r <= end);
    let errors = radii.map(|(i, &radius)| {
        let within = traced.encircled_energy(i);
        let share = (kernel.encircled_energy(radius) - within.value) / total.value;
        WorstError {
            share: Estimate { value: share.abs(), std_error: error_of(share, within, total, traced.paths) },
            radius,
        }
    });
    errors.max_by(|a, b| a.share.value.total_cmp(&b.share.value))
}

/// Standard error of D = (E_model - E)/S to first order, dD = -(dE + D dS)/S. A path scores in E what it scores in
/// S or nothing, so cov(E, S) = var(E) - E (S - E)/n over `n` paths.
fn error_of(share: f64, within: Estimate, total: Estimate, n: u64) -> f64 {
    let variance = within.std_error * within.std_error;
    let covariance = variance - within.value * (total.value - within.value) / n as f64;
    let sum = variance + share * share * total.std_error * total.std_error + 2.0 * share * covariance;
    sum.max(0.0).sqrt() / total.value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Medium;
    use crate::spread::Model;
    use crate::trace::{RadialConfig, log_spaced, trace_radial};

    fn medium() -> Medium {
        Medium::gaussian(1.0, 0.0, 0.001).unwrap()
    }

    fn traced(seed: u64, paths: u64) -> RadialProfile {
        let edges = log_spaced(1e-4, 10.0, 200);
        let config = RadialConfig { medium: medium(), depths: vec![1.0], edges, paths, seed };
        trace_radial(&config, &|_| ()).unwrap().remove(0)
    }

    #[test]
    fn a_kernel_without_light_is_wrong_by_all_light_within_reach() {
        let profile = traced(1, 50_000);
        let kernel = Model::BeerLambert.kernel(&medium(), 1.0).unwrap();
        let worst = worst_encircled_error(&profile, &*kernel).unwrap();
        let reach = MEDIAN_RADII * profile.quantile_radius(0.5);
        assert!(worst.radius <= reach && worst.radius > 0.9 * reach);
        assert!(worst.share.value > 0.99 && worst.share.value <= 1.0);
    }

    #[test]
    fn half_of_the_light_falls_within_the_median_radius() {
        let profile = traced(1, 400_000);
        let kernel = Model::SmallAngle.kernel(&medium(), 1.0).unwrap();
        let share = kernel.encircled_energy(profile.quantile_radius(0.5)) / kernel.scattered();
        // Four standard errors of a share of a half among 250 000 scattered paths.
        assert!((share - 0.5).abs() < 4e-3, "{share}");
    }

    #[test]
    fn the_stated_error_is_the_scatter_between_seeds() {
        // A kernel wrong by a fifth of the light: its worst error stays near one radius, so that it is normally distributed.
        let kernel = Model::SingleScatter.kernel(&medium(), 1.0).unwrap();
        let worst: Vec<_> = (0..60)
            .map(|seed| worst_encircled_error(&traced(seed, 4_000), &*kernel).unwrap().share)
            .collect();
        let n = worst.len() as f64;
        let mean = worst.iter().map(|e| e.value).sum::<f64>() / n;
        let scatter = (worst.iter().map(|e| (e.value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let stated = worst.iter().map(|e| e.std_error).sum::<f64>() / n;
        // The standard deviation of 60 values is itself known to 9 %.
        assert!((stated / scatter - 1.0).abs() < 0.3, "stated {stated}, scatter {scatter}");
    }
}
