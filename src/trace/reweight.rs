//! Histories of one medium serve its neighbours: the likelihood-ratio method.
//!
//! The ratio of two media's likelihoods is the weight of the path in the other, exactly, and its derivatives are closed
//! ([`likelihood`](super::likelihood)). The farther the medium, the fewer paths carry the weight.

use super::histories::{Histories, History};
use super::likelihood::{Effective, Likelihood, Reweighting};
use crate::medium::Medium;

/// A sum over reweighted paths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reweighted {
    /// The sum of weight times score: light, as a share of what set out, where the score is 1.
    pub value: f64,
    /// Its derivatives in tau, sigma_a z and the phase-function parameter.
    pub gradient: [f64; 3],
    /// (sum w)²/(sum w²): as many paths of equal weight would know the light that well. Trace again where it is small.
    pub effective_paths: f64,
}

impl<P: Likelihood> Histories<P> {
    /// The expectation of `score` in `medium`, lengths in units of the plane's depth; its phase function no farther
    /// than [`FARTHEST`](Likelihood::FARTHEST).
    pub fn reweighted(&self, medium: &Medium<P>, score: impl Fn(&History<P::Memory>) -> f64) -> Reweighted {
        let reweighting = Reweighting::new(&self.medium, medium);
        let (mut value, mut gradient, mut effective) = (0.0, [0.0; 3], Effective::default());
        for path in &self.paths {
            let weight = reweighting.of(path.scatterings, path.length, path.memory.as_ref());
            let scored = self.weight * weight.ratio * score(path);
            value += scored;
            gradient.iter_mut().zip(weight.slopes).for_each(|(g, slope)| *g += scored * slope);
            effective.add(1.0, weight.ratio);
        }
        Reweighted { value, gradient, effective_paths: effective.share() * self.paths.len() as f64 }
    }
}
