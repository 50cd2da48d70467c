//! Scattering and absorption at a first glance, from one scene's direct share and mean level.

use crate::fit::observation::{Observation, Observed, VeilTerm};
use crate::scene::Gain;

/// Range of scattering depths to begin from.
const TAU: (f64, f64) = (0.1, 8.0);

/// Coefficients from one scene's direct share and mean level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Split {
    pub sigma_s: f64,
    pub sigma_a: f64,
}

impl Split {
    pub(super) fn mean(observed: &[Observed], median_z: f64) -> Self {
        let splits: Vec<Split> = observed.iter().map(|o| Split::of(&o.observation, median_z)).collect();
        let mean = |f: fn(&Split) -> f64| splits.iter().map(f).sum::<f64>() / splits.len() as f64;
        Self { sigma_s: mean(|s| s.sigma_s), sigma_a: mean(|s| s.sigma_a) }
    }

    fn of(observation: &Observation, median_z: f64) -> Self {
        let gain = match observation.gain {
            Gain::Fixed(gain) => gain,
            Gain::Free => 1.0,
        };
        let (level, detail) = rayon::join(|| level_ratio(observation), || detail_ratio(observation));
        let level = (level / gain).clamp(1e-6, 1e6);
        let direct = detail.map_or(0.4 * level, |d| (d / gain).clamp(1e-6, level));
        let tau = (level / direct).ln().clamp(TAU.0, TAU.1);
        // With a free gain the level says nothing of the absorption.
        let absorbed = if observation.gain == Gain::Free { 0.0 } else { -level.min(1.0).ln() };
        Self { sigma_s: tau / median_z, sigma_a: absorbed / median_z }
    }
}

/// Pairs of (object, observation) over the view's pixels that count, for `f` of both images.
fn pixel_pairs(
    observation: &Observation,
    f: impl Fn(&dyn Fn(usize, usize) -> f64, usize, usize) -> f64,
) -> Vec<(f64, f64)> {
    let view = observation.target.view;
    let object = |x: usize, y: usize| f64::from(observation.target.radiance.at(view.x + x, view.y + y));
    let observed = |x: usize, y: usize| f64::from(observation.observed.at(x, y));
    let counts = |x: usize, y: usize| {
        let around = [(x, y), (x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
        around.iter().all(|&(x, y)| {
            observation.is_unmasked(y * observation.observed.width + x)
                && observation.target.geometry.path_length(view.x + x, view.y + y).is_some()
        })
    };
    let inner = |n: usize| 1..n.saturating_sub(1);
    inner(view.height)
        .flat_map(|y| inner(view.width).map(move |x| (x, y)))
        .filter(|&(x, y)| counts(x, y))
        .map(|(x, y)| (f(&object, x, y), f(&observed, x, y)))
        .collect()
}

/// Regression of the observation's Laplacian on the object's: the direct share; `None` if the object has no detail.
fn detail_ratio(observation: &Observation) -> Option<f64> {
    let laplacian = |image: &dyn Fn(usize, usize) -> f64, x: usize, y: usize| {
        4.0 * image(x, y) - image(x - 1, y) - image(x + 1, y) - image(x, y - 1) - image(x, y + 1)
    };
    let (mut both, mut object) = (0.0, 0.0);
    for (o, y) in pixel_pairs(observation, laplacian) {
        both += o * y;
        object += o * o;
    }
    (object > 0.0).then(|| both / object)
}

/// Mean level of the observation over the object's; with a free veil, the slope between their means over blocks.
fn level_ratio(observation: &Observation) -> f64 {
    let pairs = pixel_pairs(observation, |image, x, y| image(x, y));
    let known_veil = match observation.veil {
        VeilTerm::Fixed(v) => v,
        VeilTerm::Image(image) => image.mean(),
        VeilTerm::Free(_) => 0.0,
    };
    let mean =
        |f: fn(&(f64, f64)) -> f64, of: &[(f64, f64)]| of.iter().map(f).sum::<f64>() / of.len().max(1) as f64;
    if !matches!(observation.veil, VeilTerm::Free(_)) {
        let object = mean(|p| p.0, &pairs);
        return if object > 0.0 { (mean(|p| p.1, &pairs) - known_veil) / object } else { 1.0 };
    }
    let blocks: Vec<(f64, f64)> =
        pairs.chunks((pairs.len() / 64).max(1)).map(|c| (mean(|p| p.0, c), mean(|p| p.1, c))).collect();
    let (x, y) = (mean(|p| p.0, &blocks), mean(|p| p.1, &blocks));
    let covariance: f64 = blocks.iter().map(|b| (b.0 - x) * (b.1 - y)).sum();
    let variance: f64 = blocks.iter().map(|b| (b.0 - x) * (b.0 - x)).sum();
    if variance > 0.0 { covariance / variance } else { 1.0 }
}
