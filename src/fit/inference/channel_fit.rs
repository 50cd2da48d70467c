//! What the fit of one channel has found.

use super::combination::Combination;
use super::covariance::{Covariance, Status};
use super::diagnosis::Finding;
use super::error_images::ErrorSource;
use super::exposure::ExposureEstimate;
use super::input_error::InputError;
use super::lack_of_fit::LACKING;
use super::model_error::ModelError;
use crate::fit::observation::Unseen;
use crate::fit::optimise::PathsUsed;
use crate::fit::parameters::{Id, Parameters};
use crate::image::Image;
use crate::spread::Model;
use nalgebra::DVector;

/// The fit of one channel.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ChannelFit {
    /// The spread model.
    pub model: Model,
    /// Where the fit began.
    pub start: Parameters,
    /// What was found, with what was free and the bounds.
    pub parameters: Parameters,
    /// Their covariance and what the data leave undetermined.
    pub covariance: Covariance,
    /// What the model's own error does to them; `None` where it is not known.
    pub model_error: Option<ModelError>,
    /// What errors of the input do to them.
    pub input_error: InputError,
    /// The Gauss-Newton step by which the data would move the coordinates on from the optimum, were there no bounds.
    pub gauss_newton_step: DVector<f64>,
    /// By how many standard deviations blocks of residuals exceed what noise leaves in them.
    pub lack_of_fit: f64,
    /// Reduced chi² over what a noise that neighbours share leaves of it, where the noise was estimated.
    pub misfit: f64,
    /// What the residual says of the scenes, the largest drop of chi² first.
    pub findings: Vec<Finding>,
    /// Gain, veil, noise and chi² of each scene.
    pub exposures: Vec<ExposureEstimate>,
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
    /// Pixels left out because of light from outside the clear image.
    pub outside_pixels: usize,
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
    /// What Gram matrices found, before renders confirmed it; `None` if renders alone found the optimum.
    pub by_gram: Option<Parameters>,
    /// Evaluations by Gram matrices.
    pub gram_evaluations: u64,
    /// Real 2-D FFTs of one evaluation with derivatives, over all scenes.
    pub transforms: usize,
    /// Paths that were traced; `None` but for the model `traced`.
    pub paths: Option<PathsUsed>,
    /// Whether some scene's gain was free.
    pub free_gain: bool,
    /// Each scene's best fit, gain · object light + veil, over its view: to compare with the observation.
    pub renders: Vec<Image>,
    /// Shares of each scene's light that no image shows, at the best fit.
    pub(crate) unseen: Vec<Unseen>,
    /// What the data determine where they leave a parameter open, or hold two only together.
    pub determined: Vec<Combination>,
}

impl ChannelFit {
    /// Whether blocks of residuals are more than noise leaves in them.
    pub fn lacks_fit(&self) -> bool {
        self.lack_of_fit > LACKING
    }

    /// Akaike's information criterion, chi² + 2 k with k fitted numbers (Akaike 1974): the log-likelihood of a normal noise
    /// that is known, or held at its estimate.
    pub fn aic(&self) -> f64 {
        2.0 * self.cost + 2.0 * self.fitted as f64
    }

    /// Variance of the linear function `gradient`·u of the coordinates by noise and by errors of the input; `None` if the
    /// data do not decide it.
    pub fn variance_of(&self, gradient: &DVector<f64>) -> Option<f64> {
        Some(self.covariance.variance_of(gradient)? + self.input_error.variance_of(gradient))
    }

    /// Standard error of the value of the parameter called `name`, by the noise; `None` if it is fixed or undetermined.
    ///
    /// # Panics
    /// If no parameter is called so.
    pub fn std_error(&self, name: &str) -> Option<f64> {
        let id = self.parameters.find(name).unwrap_or_else(|| panic!("no parameter is called {name}"));
        Some(self.covariance.std_error(id)? * self.parameters.get(id).slope().abs())
    }

    /// The medium's parameters of this status.
    pub fn with_status(&self, status: Status) -> impl Iterator<Item = Id> {
        self.parameters.of_medium().map(|(id, _)| id).filter(move |&id| self.covariance.status(id) == status)
    }

    /// What is stated as the error of the linear function `gradient`·u of the coordinates beside noise and input, source by
    /// source.
    pub fn model_errors(&self, gradient: &DVector<f64>) -> Vec<(ErrorSource, f64)> {
        let mut parts = self.model_error.as_ref().map_or_else(Vec::new, |error| error.parts(gradient));
        if !self.findings.is_empty() {
            let added = self.findings.iter().map(|finding| gradient.dot(&finding.bias).powi(2));
            parts.push((ErrorSource::Residual, added.sum::<f64>().sqrt()));
        }
        parts
    }

    /// Bayesian information criterion, chi² + k ln n over n pixels (Schwarz 1978).
    pub fn bic(&self) -> f64 {
        2.0 * self.cost + self.fitted as f64 * (self.pixels as f64).ln()
    }
}
