//! Histories of one medium serve its neighbours: the likelihood-ratio method.
//!
//! The likelihood of a path with n scatterings, length L and squared deflections S is, for the Gaussian phase function
//! p(theta) = N(B) exp(-theta²/4B), tau^n exp(-(tau + a) L) N(B)^n exp(-S/4B) times what no parameter moves. The ratio
//! of two media's is the weight of the path in the other, exactly, and its derivatives are closed:
//! n/tau - L, -L, and (S - n <theta²>)/4B². The farther the medium, the fewer paths carry the weight.

use super::histories::{Histories, History, ScaledMedium};
use crate::error::{Error, Result};
use crate::phase::{Gaussian, Lobe, PhaseFunction};

/// A sum over reweighted paths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reweighted {
    /// The sum of weight times score: light, as a share of what set out, where the score is 1.
    pub value: f64,
    /// Its derivatives in tau, sigma_a z and B.
    pub gradient: [f64; 3],
    /// (sum w)²/(sum w²): as many paths of equal weight would know the light that well. Trace afresh where it is small.
    pub effective_paths: f64,
}

/// The Gaussian that `lobe` is.
fn gaussian(lobe: &Lobe) -> Result<&Gaussian> {
    match lobe {
        Lobe::Gaussian(phase) => Ok(phase),
        other => Err(Error::OnlyGaussian { what: "reweighting of paths", phase: other.family() }),
    }
}

impl Histories {
    /// The expectation of `score` in `medium`.
    ///
    /// # Errors
    /// [`Error::OnlyGaussian`] for another phase function.
    pub fn reweighted(&self, medium: ScaledMedium, score: impl Fn(&History) -> f64) -> Result<Reweighted> {
        let (from, to) = (self.medium, medium);
        let (phase_from, phase_to) = (gaussian(&from.lobe)?, gaussian(&to.lobe)?);
        let (b_from, b_to) = (phase_from.b(), phase_to.b());
        let per_scattering = (to.tau * phase_to.eval(1.0) / (from.tau * phase_from.eval(1.0))).ln();
        let per_length = from.tau + from.absorption - to.tau - to.absorption;
        let per_square = 0.25 / b_from - 0.25 / b_to;
        let mean_square = phase_to.mean_square_angle();
        let (mut value, mut gradient, mut weights, mut squares) = (0.0, [0.0; 3], 0.0, 0.0);
        for path in &self.paths {
            let (n, length) = (f64::from(path.scatterings), f64::from(path.length));
            let square = f64::from(path.square_angles);
            let ratio = (n * per_scattering + length * per_length + square * per_square).exp();
            let scored = self.weight * ratio * score(path);
            let slopes = [n / to.tau - length, -length, 0.25 * (square - n * mean_square) / (b_to * b_to)];
            value += scored;
            gradient.iter_mut().zip(slopes).for_each(|(g, slope)| *g += scored * slope);
            weights += ratio;
            squares += ratio * ratio;
        }
        Ok(Reweighted { value, gradient, effective_paths: weights * weights / squares })
    }
}
