//! How far an estimate is off because of its model.
//!
//! To first order a fit of model M to an image of the reference model W ends (JᵀWJ)⁻¹JᵀW (I_W - I_M) away from the medium
//! that W rendered: the Gauss-Newton step of M towards the image of W at the medium found. The reference is the
//! `wide-angle` model, whose own error is measured. What that does to the estimate is reckoned in the same way, and the
//! two are added.
//!
//! The model `traced` has no such error, but its paths are a sample.

use super::displacement::Displacement;
use super::{Datum, Settings, Status, with_optics};
use crate::error::Result;
use crate::filter::Optics;
use crate::image::Image;
use crate::phase::Family;
use crate::spread::Model;
use crate::trace::BATCHES;
use nalgebra::{Matrix3, Vector3};

/// What every other model is measured against.
const REFERENCE: Model = Model::WideAngle;
/// Error of its scattered total: over 40 random media the largest that stands out of the noise of fresh tracing is .17 %,
/// at tau 7.2, for the Gaussian (with `--ignored`); .3 % for Henyey-Greenstein's lobe (`cargo test --release --test it wide_angle:: -- --nocapture`).
fn reference_error(family: Family) -> f64 {
    match family {
        Family::Gaussian => 0.002,
        Family::HenyeyGreenstein => 0.003,
    }
}

/// Relative error of the lobe's width by which the shape of its kernel is off. The encircled energy of Henyey-Greenstein's is off
/// by up to .6 % of the scattered light (same command), and a lobe wider by w changes that of light scattered once by up to .3 w;
/// the lobe of `hg-90` came out half a percent too narrow. The Gaussian's shape is off by less than its total.
fn width_error(family: Family) -> f64 {
    match family {
        Family::Gaussian => 0.0,
        Family::HenyeyGreenstein => 0.02,
    }
}
/// The bias is of first order: it foretells errors of up to 10 % to a quarter (tests/it/ladder.rs).
const MARGIN: f64 = 1.25;
/// Squared planar widths (rad², B of a Gaussian) of the lobes for which the error of a model without a width is reckoned, where
/// none is given: the worst counts.
const SQUARED_WIDTHS: [f64; 3] = [1e-3, 1e-2, 5e-2];

/// What the model's error does to the coordinates (ln sigma_s, sigma_a, ln B), to first order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelError {
    /// Away from what the reference would have found.
    bias: Vector3<f64>,
    /// By the error of the reference itself.
    reference: Vector3<f64>,
    /// Of the last coordinate by the shape of the reference's kernel.
    width: f64,
    /// Covariance by the noise of traced paths.
    noise: Matrix3<f64>,
    /// Root mean square difference of a pixel from the reference's image, in units of its noise.
    pub image: f64,
}

impl ModelError {
    /// The error at the optimum; `None` where the reference has no kernels, or no parameter is estimated.
    pub(super) fn new(fit: &mut Displacement) -> Result<Option<Self>> {
        if (0..3).all(|i| fit.uncertainty.status(i) != Status::Free) {
            return Ok(None);
        }
        if fit.settings.model == Model::Traced {
            return Self::of_paths(fit).map(Some);
        }
        let (parameters, settings) = (fit.parameters, fit.settings);
        let shapes = if parameters.is_placeholder(2) {
            SQUARED_WIDTHS.map(|square: f64| parameters.family().of_width(square.sqrt())).to_vec()
        } else {
            vec![parameters.values()[2]]
        };
        let mut worst: Option<Self> = None;
        for shape in shapes {
            let images = with_optics(&parameters.with_shape(shape), REFERENCE, |optics| {
                let image = |d| reference(d, optics, settings);
                fit.data.iter().map(image).collect::<Result<Vec<_>>>()
            });
            let images = match images {
                Err(error) if error.is_about_model() => return Ok(None),
                images => images?,
            };
            let share = reference_error(parameters.family()) as f32;
            let more = |(whole, direct): &(Image, Image)| {
                let mut image = whole.clone();
                let pairs = image.data.iter_mut().zip(&direct.data);
                pairs.for_each(|(w, d)| *w += share * (*w - d));
                image
            };
            let (with_more, _) = fit.towards(images.iter().map(more).collect())?;
            let (bias, image) = fit.towards(images.into_iter().map(|(whole, _)| whole).collect())?;
            let width = width_error(parameters.family());
            let error = Self { bias, reference: with_more - bias, width, noise: Matrix3::zeros(), image };
            if worst.is_none_or(|w| error.bias.norm() > w.bias.norm()) {
                worst = Some(error);
            }
        }
        Ok(worst)
    }

    /// The error by the noise of traced paths, from batches of them that are independent of each other.
    ///
    /// The gradient of the cost is a mean over pairs of batches, one of which renders and the other derives. Of such a mean
    /// over pairs of n (a U-statistic, Hoeffding 1948) the jackknife's variance is 4/n · ((n - 1)/(n - 2))² times that of the
    /// means over the pairs of one batch.
    fn of_paths(fit: &mut Displacement) -> Result<Self> {
        let steps = (0..BATCHES).map(|batch| fit.by_batch(batch)).collect::<Result<Vec<_>>>()?;
        let n = BATCHES as f64;
        let mean = steps.iter().sum::<Vector3<f64>>() / n;
        let squares: Matrix3<f64> = steps.iter().map(|s| (s - mean) * (s - mean).transpose()).sum();
        let noise = squares / (n - 1.0) * 4.0 / n * ((n - 1.0) / (n - 2.0)).powi(2);
        Ok(Self { bias: Vector3::zeros(), reference: Vector3::zeros(), width: 0.0, noise, image: 0.0 })
    }

    /// Variance of the linear function `gradient`·u of the coordinates by the noise of traced paths.
    pub fn variance_of(&self, gradient: &Vector3<f64>) -> f64 {
        gradient.dot(&(self.noise * gradient))
    }

    /// What is stated as the error of the linear function `gradient`·u of the coordinates.
    pub fn of(&self, gradient: &Vector3<f64>) -> f64 {
        MARGIN * self.bias_of(gradient).abs()
            + self.reference_of(gradient)
            + self.variance_of(gradient).sqrt()
    }

    /// The part of it that the reference makes as well: what no model here can know better.
    pub(super) fn reference_of(&self, gradient: &Vector3<f64>) -> f64 {
        gradient.dot(&self.reference).abs() + self.width * gradient[2].abs()
    }

    /// The part of it that the reference would not make, with its sign: estimate minus truth.
    pub fn bias_of(&self, gradient: &Vector3<f64>) -> f64 {
        gradient.dot(&self.bias)
    }
}

/// What the reference renders of a scene, and the direct light in it.
fn reference(datum: &Datum, optics: &Optics, settings: &Settings) -> Result<(Image, Image)> {
    let prepared = settings.backend.prepare(datum.target, optics, 1.0)?;
    let direct = prepared.render(&Optics { model: Model::BeerLambert, ..*optics })?;
    Ok((prepared.render(optics)?, direct))
}
