//! What the fit of one channel has found.

use super::{Combination, Exposure, InputError, ModelError, Parameters, Uncertainty};
use crate::image::Image;
use crate::spread::Model;
use nalgebra::Vector3;

/// The fit of one channel.
#[derive(Debug, Clone)]
pub struct ChannelFit {
    /// The spread model.
    pub model: Model,
    /// Where the fit began.
    pub start: [f64; 3],
    /// sigma_s, sigma_a (1/length) and the shape of the phase function, B (rad²) or g, found, with what was free and the bounds.
    pub parameters: Parameters,
    /// Their covariance and what the data leave undetermined.
    pub uncertainty: Uncertainty,
    /// What the model's own error does to them; `None` where it is not known.
    pub model_error: Option<ModelError>,
    /// What errors of the input do to them.
    pub input_error: InputError,
    /// How far the data would move the coordinates on from the optimum, were there no bounds: a Gauss-Newton step.
    pub pull: Vector3<f64>,
    /// By how many standard deviations blocks of residuals exceed what noise leaves in them.
    pub structure: f64,
    /// Gain, veil, noise and chi² of each scene.
    pub exposures: Vec<Exposure>,
    /// Half the sum of squared residuals in units of the noise.
    pub cost: f64,
    /// Sum of squared residuals over pixels minus fitted numbers.
    pub reduced_chi2: f64,
    /// Numbers that were fitted: free parameters, gains and veils.
    pub fitted: usize,
    /// Pixels that counted.
    pub pixels: usize,
    /// Pixels left out because of hidden light.
    pub hidden_pixels: usize,
    /// Median path length over all scenes, length.
    pub median_z: f64,
    /// Median length of a pixel at the object of the first scene.
    pub pixel_pitch: f64,
    /// Shorter side of the first scene's view, px.
    pub view_px: usize,
    /// Whether the optimiser converged.
    pub converged: bool,
    /// Whether the noise of the scenes, the planning of the renders and the pixels left out settled.
    pub settled: bool,
    /// Whether the kernels reach beyond the padding, [`Coverage::cut`](crate::filter::Coverage).
    pub cut: bool,
    /// Why it stopped.
    pub stop: String,
    /// Iterations of the optimiser.
    pub iterations: u64,
    /// Renders, with and without derivatives.
    pub evaluations: u64,
    /// sigma_s, sigma_a and the shape as sums over the image had them, before renders confirmed them; `None` if renders alone found
    /// the optimum.
    pub by_sums: Option<[f64; 3]>,
    /// Evaluations by sums.
    pub sum_evaluations: u64,
    /// Real 2-D FFTs of one evaluation with derivatives, over all scenes.
    pub transforms: usize,
    /// Paths traced in all, and the least share of those of a scene that carries the weight at the best fit; `None` but for the model
    /// `traced`.
    pub paths: Option<(u64, f64)>,
    /// Whether some scene's gain was free.
    pub free_gain: bool,
    /// Each scene's best fit, gain · object light + veil, over its view: to compare with the observation.
    pub renders: Vec<Image>,
    /// Share of hidden light of each scene's pixels at the best fit; `None` for a scene in which nothing is hidden.
    pub hidden_shares: Vec<Option<Image>>,
    /// What the data determine where they leave a parameter open, or hold two only together.
    pub determined: Vec<Combination>,
}

impl ChannelFit {
    /// Akaike's information criterion, chi² + 2 k with k fitted numbers (Akaike 1974): the log-likelihood of a normal noise
    /// that is known, or held at its estimate.
    pub fn aic(&self) -> f64 {
        2.0 * self.cost + 2.0 * self.fitted as f64
    }

    /// Variance of the linear function `gradient`·u of the coordinates by noise and by errors of the input; `None` if the
    /// data do not decide it.
    pub fn variance_of(&self, gradient: &Vector3<f64>) -> Option<f64> {
        Some(self.uncertainty.variance_of(gradient)? + self.input_error.variance_of(gradient))
    }

    /// Bayesian information criterion, chi² + k ln n over n pixels (Schwarz 1978).
    pub fn bic(&self) -> f64 {
        2.0 * self.cost + self.fitted as f64 * (self.pixels as f64).ln()
    }
}
