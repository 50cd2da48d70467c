//! Path replay: paths traced in one medium serve its neighbours (perturbation Monte Carlo).
//!
//! The ratio of a path's likelihoods in two media is its exact weight in the other medium. The derivatives of the weight
//! have a closed form ([`likelihood`](super::likelihood)). The farther the medium, the fewer paths carry the weight.

use super::likelihood::{EffectiveSampleSize, Likelihood, Replay};
use super::path_records::{PathRecord, PathRecords};
use crate::medium::Medium;

/// A sum over replayed paths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayedSum {
    /// The sum of weight times score. If every score is 1, this is the light that arrives, as a share of the light emitted.
    pub value: f64,
    /// Its derivatives in tau, sigma_a z and the phase-function parameter.
    pub gradient: [f64; 3],
    /// Effective sample size (sum w)²/(sum w²): as many paths of equal weight would give the same variance. Trace again
    /// where it is small.
    pub effective_paths: f64,
}

impl<P: Likelihood> PathRecords<P> {
    /// The expectation of `score` in `medium`, lengths in units of the plane's depth. Its phase function may lie no farther
    /// than [`FARTHEST`](Likelihood::FARTHEST).
    pub fn replay(&self, medium: &Medium<P>, score: impl Fn(&PathRecord<P::Memory>) -> f64) -> ReplayedSum {
        let replay = Replay::new(&self.medium, medium);
        let (mut value, mut gradient, mut effective) = (0.0, [0.0; 3], EffectiveSampleSize::default());
        for path in &self.paths {
            let weight = replay.weight(path.scatterings, path.length, path.memory.as_ref());
            let scored = self.weight * weight.ratio * score(path);
            value += scored;
            gradient.iter_mut().zip(weight.slopes).for_each(|(g, slope)| *g += scored * slope);
            effective.add(1.0, weight.ratio);
        }
        ReplayedSum { value, gradient, effective_paths: effective.relative() * self.paths.len() as f64 }
    }
}
