//! How each scene was exposed: gain, veil and noise, with what the fit says of them.

use super::covariance::Covariance;
use crate::fit::observation::{LinearTerm, Observed, VeilTerm};
use crate::fit::optimise::{Eliminated, NormalEquations};
use crate::forward::Veil;
use crate::image::Sampling;
use crate::imaging::MONOMIALS;
use nalgebra::DVector;

/// Gain, veil, noise and misfit of one scene after a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct ExposureEstimate {
    /// Exposure: observed = gain · object light + veil.
    pub gain: f64,
    /// Standard error of the gain; `None` if it was given or the data leave it undetermined.
    pub gain_error: Option<f64>,
    /// Veil, by its monomials; of an image 0.
    pub veil: Veil,
    /// How many of them were fitted.
    pub veil_terms: usize,
    /// Standard error of each; `None` if it was given or the data leave it undetermined.
    pub veil_errors: [Option<f64>; MONOMIALS],
    /// Standard deviation of a pixel's noise, given or estimated; of given variances the root of their harmonic mean.
    pub noise: f64,
    /// Sum of squared residuals over noise².
    pub chi2: f64,
    /// Pixels that counted.
    pub pixels: usize,
    /// Pixels left out because of hidden light.
    pub hidden_pixels: usize,
    /// Pixels left out because of light from outside the clear image.
    pub outside_pixels: usize,
    /// Pixels left out because they are saturated.
    pub saturated_pixels: usize,
    /// What lies between the pixels of the clear image.
    pub sampling: Sampling,
    /// Whether that was stated or shows in the image.
    pub sampling_is_known: bool,
    /// How a free gain hangs together with the parameters; `None` for a given gain, or where the data leave it open even if
    /// they are given.
    pub(crate) gain_response: Option<GainResponse>,
}

/// How the logarithm of a gain hangs together with the parameters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GainResponse {
    /// Its change with the coordinates.
    pub slope: DVector<f64>,
    /// Its variance where the parameters are given.
    pub variance: f64,
}

/// Gain and veil of every scene, with their errors.
pub(super) fn exposures(
    equations: &NormalEquations,
    observed: &[Observed],
    covariance: &Covariance,
) -> Vec<ExposureEstimate> {
    equations.scenes.iter().zip(observed).map(|(e, o)| estimate(e, o, covariance)).collect()
}

fn estimate(scene: &Eliminated, observed: &Observed, covariance: &Covariance) -> ExposureEstimate {
    let Eliminated { linear, coupling, .. } = scene;
    let row = |term: LinearTerm| linear.terms.iter().position(|t| *t == term);
    let apart = |row: usize| covariance.variance_scale() * scene.covariance[(row, row)];
    let error = |term: LinearTerm| {
        let row = row(term)?;
        let variance = apart(row) + covariance.variance_of(&coupling.row(row).transpose())?;
        variance.is_finite().then(|| variance.sqrt())
    };
    let gain = linear.exposure.gain;
    let response = || {
        let row = row(LinearTerm::Gain)?;
        let variance = apart(row) / (gain * gain);
        let slope = coupling.row(row).transpose() / gain;
        (gain > 0.0 && variance.is_finite()).then_some(GainResponse { slope, variance })
    };
    ExposureEstimate {
        gain,
        gain_error: error(LinearTerm::Gain),
        veil: match observed.observation.veil {
            VeilTerm::Fixed(v) => Veil::constant(v),
            _ => linear.exposure.veil,
        },
        veil_terms: observed.observation.veil.free_terms(),
        veil_errors: std::array::from_fn(|term| error(LinearTerm::Veil(term))),
        noise: observed.noise,
        chi2: scene.chi2,
        pixels: observed.count(),
        hidden_pixels: observed.hidden,
        outside_pixels: observed.outside,
        saturated_pixels: observed.observation.saturated_pixels,
        sampling: observed.observation.target.sampling,
        sampling_is_known: observed.observation.sampling_is_known,
        gain_response: response(),
    }
}
