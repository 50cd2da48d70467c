//! How each scene was exposed: gain, veil and noise, with what the fit says of them.

use super::datum::VeilTerm;
use super::equations::{Linear, NormalEquations};
use super::observed::Observed;
use super::uncertainty::Uncertainty;
use crate::image::Image;
use crate::scene::Gain;
use nalgebra::Vector3;

/// Gain, veil, noise and misfit of one scene after a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Exposure: observed = gain · object light + veil.
    pub gain: f64,
    /// Standard error of the gain; `None` if it was given or the data leave it undetermined.
    pub gain_error: Option<f64>,
    /// Veil, the constant part.
    pub veil: f64,
    /// Standard error of the veil; `None` if it was given or the data leave it undetermined.
    pub veil_error: Option<f64>,
    /// Standard deviation of a pixel's noise, given or estimated; of given variances the root of their harmonic mean.
    pub noise: f64,
    /// Sum of squared residuals over noise².
    pub chi2: f64,
    /// Pixels that counted.
    pub pixels: usize,
    /// Pixels left out because of hidden light.
    pub hidden_pixels: usize,
    /// Change of the logarithm of a free gain with the coordinates (ln sigma_s, sigma_a, ln B), and its variance where these
    /// are given; `None` for a given gain, or where the data leave it open even then.
    pub(super) gain_response: Option<(Vector3<f64>, f64)>,
}

impl Exposure {
    /// The image as observed: gain · `image` + veil.
    pub(super) fn apply(&self, mut image: Image, veil: VeilTerm) -> Image {
        let (gain, constant) = (self.gain as f32, self.veil as f32);
        for (i, v) in image.data.iter_mut().enumerate() {
            let veil = if let VeilTerm::Image(veil) = veil { veil.data[i] } else { constant };
            *v = gain * *v + veil;
        }
        image
    }
}

/// Gain and veil of every scene, with their errors if the parameters' are given.
pub(super) fn exposures(
    equations: &NormalEquations,
    observed: &[Observed],
    uncertainty: Option<&Uncertainty>,
) -> Vec<Exposure> {
    let inflation = uncertainty.map_or(1.0, Uncertainty::inflation);
    let error = |l: &Linear, row: usize, free: bool| {
        let shared = uncertainty?.variance_of(&l.coupling.row(row).transpose())?;
        let variance = inflation * l.inverse[(row, row)] + shared;
        (free && variance.is_finite()).then(|| variance.sqrt())
    };
    let response = |l: &Linear| {
        let variance = inflation * l.inverse[(0, 0)] / (l.gain * l.gain);
        (l.gain > 0.0 && variance.is_finite()).then(|| (l.coupling.row(0).transpose() / l.gain, variance))
    };
    let exposure = |(l, o): (&Linear, &Observed)| Exposure {
        gain: l.gain,
        gain_error: error(l, 0, o.datum.gain == Gain::Free),
        veil: match o.datum.veil {
            VeilTerm::Fixed(v) => v,
            _ => l.veil,
        },
        veil_error: error(l, 1, matches!(o.datum.veil, VeilTerm::Free)),
        noise: o.noise,
        chi2: l.chi2,
        pixels: o.pixels(),
        hidden_pixels: o.hidden,
        gain_response: if o.datum.gain == Gain::Free { response(l) } else { None },
    };
    equations.linear.iter().zip(observed).map(exposure).collect()
}
