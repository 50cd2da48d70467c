//! Light in bins of radius expanded in the mixture's Gaussians.
//!
//! The shares that make the binned light most likely, found by expectation maximisation (Dempster, Laird and Rubin
//! 1977; in imaging, Richardson 1972 and Lucy 1974): p_j <- p_j sum_b d_b g_jb / sum_l p_l g_lb, with d the light in
//! bin b and g_jb the share of Gaussian j that falls there. Shares stay positive and add up to 1. The iteration
//! starts from equal shares and stops early, so noise is not fitted.

use crate::spread::wide_angle::layout::relative_width;
use libm::erf;
use std::f64::consts::PI;

/// Steps of the iteration.
const STEPS: usize = 3000;

/// Where the light of each Gaussian falls: [bin][Gaussian].
pub(super) struct Laid(Vec<Vec<f64>>);

impl Laid {
    /// Of `gaussians` Gaussians: within r is 1 - exp(-r²/2s²).
    pub(super) fn light(gaussians: usize, edges: &[f64]) -> Self {
        Self::new(gaussians, edges, |y| -(-0.5 * y * y).exp_m1())
    }

    /// Of the gradients of Gaussians, whose light in a ring is ∝ r² exp(-r²/2s²): Maxwell's distribution.
    pub(super) fn slope(gaussians: usize, edges: &[f64]) -> Self {
        Self::new(gaussians, edges, |y| {
            erf(y / 2.0_f64.sqrt()) - (2.0 / PI).sqrt() * y * (-0.5 * y * y).exp()
        })
    }

    fn new(gaussians: usize, edges: &[f64], within: impl Fn(f64) -> f64) -> Self {
        let mut inner = vec![0.0; gaussians];
        let bins = edges.iter().copied().chain([f64::INFINITY]).map(|edge| {
            let up_to = |j: usize| if edge.is_finite() { within(edge / relative_width(j)) } else { 1.0 };
            let outer: Vec<f64> = (0..gaussians).map(up_to).collect();
            let bin = outer.iter().zip(&inner).map(|(outer, inner)| outer - inner).collect();
            inner = outer;
            bin
        });
        Self(bins.collect())
    }

    /// The shares of the Gaussians in the light of all bins; bins without light count as empty.
    pub(super) fn shares(&self, light: &[f64]) -> Vec<f64> {
        let total: f64 = light.iter().map(|l| l.max(0.0)).sum();
        let gaussians = self.0[0].len();
        let mut shares = vec![1.0 / gaussians as f64; gaussians];
        let mut next = vec![0.0; gaussians];
        for _ in 0..STEPS {
            next.fill(0.0);
            for (gaussians, light) in self.0.iter().zip(light).filter(|(_, l)| **l > 0.0) {
                let model: f64 = gaussians.iter().zip(&shares).map(|(g, p)| g * p).sum();
                let ratio = light / (total * model.max(f64::MIN_POSITIVE));
                for (n, g) in next.iter_mut().zip(gaussians) {
                    *n += ratio * g;
                }
            }
            shares.iter_mut().zip(&next).for_each(|(p, n)| *p *= n);
        }
        shares
    }
}
