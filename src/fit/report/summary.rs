//! How a fit went, over all its channels.

use crate::fit::inference::ChannelFit;
use serde::{Deserialize, Serialize};

/// How a fit went, over all its channels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Summary {
    /// Whether all channels converged.
    pub converged: bool,
    /// Why the optimiser stopped.
    pub stop: String,
    /// Half of chi².
    pub cost: f64,
    /// Sum of squared residuals in units of the noise.
    pub chi2: f64,
    /// The same over pixels minus fitted numbers.
    pub reduced_chi2: f64,
    /// Akaike's information criterion.
    pub aic: f64,
    /// Bayesian information criterion.
    pub bic: f64,
    /// Numbers that were fitted.
    pub fitted: u64,
    /// Pixels that counted.
    pub pixels: u64,
    /// Pixels left out because of hidden light.
    pub hidden_pixels: u64,
    /// `sums` where Gram matrices found the optimum, `renders` where renders did.
    pub path: String,
    /// Iterations of the optimiser.
    pub iterations: u64,
    /// Renders.
    pub evaluations: u64,
    /// Evaluations by Gram matrices.
    pub sum_evaluations: u64,
    /// What was traced, by the model `traced`.
    pub traced: Option<TracedSummary>,
    /// Time that it took, seconds.
    pub seconds: f64,
}

/// What was traced.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct TracedSummary {
    /// Paths, over all scenes and channels.
    pub paths: u64,
    /// Least relative effective sample size of a scene at the best fit.
    pub effective_share: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

impl Summary {
    pub(super) fn new(channels: &[(String, ChannelFit)], seed: u64, seconds: f64) -> Self {
        let fits = || channels.iter().map(|(_, fit)| fit);
        let sum = |f: fn(&ChannelFit) -> u64| fits().map(f).sum::<u64>();
        let pixels = sum(|f| f.pixels as u64);
        let chi2 = fits().map(|f| f.reduced_chi2 * f.pixels as f64).sum::<f64>() / pixels.max(1) as f64;
        let stops: Vec<&str> = fits().map(|f| f.stop.as_str()).collect();
        let all_same = stops.iter().all(|s| *s == stops[0]);
        Self {
            converged: fits().all(|f| f.converged),
            stop: if all_same { stops[0].to_string() } else { stops.join("; ") },
            cost: fits().map(|f| f.cost).sum::<f64>(),
            chi2: fits().map(|f| 2.0 * f.cost).sum::<f64>(),
            reduced_chi2: chi2,
            aic: fits().map(ChannelFit::aic).sum::<f64>(),
            bic: fits().map(ChannelFit::bic).sum::<f64>(),
            fitted: sum(|f| f.fitted as u64),
            pixels,
            hidden_pixels: sum(|f| f.hidden_pixels as u64),
            path: if fits().all(|f| f.by_gram.is_some()) { "sums" } else { "renders" }.into(),
            iterations: sum(|f| f.iterations),
            evaluations: sum(|f| f.evaluations),
            sum_evaluations: sum(|f| f.gram_evaluations),
            traced: fits().find_map(|f| f.paths).map(|_| TracedSummary {
                paths: sum(|f| f.paths.map_or(0, |paths| paths.count)),
                effective_share: fits()
                    .filter_map(|f| f.paths)
                    .map(|paths| paths.relative_sample_size)
                    .fold(1.0, f64::min),
                seed,
            }),
            seconds,
        }
    }
}
