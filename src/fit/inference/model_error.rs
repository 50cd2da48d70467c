//! How far an estimate is off because of its model.
//!
//! To first order a fit of model M to an image that is off by E ends (JᵀWJ)⁻¹JᵀW E away: a Gauss-Newton step, gain, veil and
//! nuisances eliminated as for the noise. E is each of the [`ErrorImages`] in turn. Sources are independent, and their
//! effects add in squares.

use super::covariance::Status;
use super::displacement::{Displacement, Moved};
use super::error_images::{ErrorImages, ErrorSource};
use crate::error::Result;
use crate::forward::Quantity;
use crate::image::Image;
use crate::phase::Family;
use nalgebra::{DMatrix, DVector};

/// Relative error of the phase function's width by which the shape of the reference's kernel is off. The encircled energy of Henyey-Greenstein's is off
/// by up to 0.6 % of the scattered light (`cargo test --release --test it wide_angle:: -- --nocapture`), and a phase function wider by w changes that of light scattered once by up to 0.3 w;
/// that of `hg-90` came out half a percent too narrow. The Gaussian's shape is off by less than its total.
fn width_error(family: Family) -> f64 {
    match family {
        Family::Gaussian => 0.0,
        Family::HenyeyGreenstein => 0.02,
    }
}

/// What the model's error does to the coordinates, to first order.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelError {
    /// What each source adds to the estimate, or might; a source may do so in more ways than one.
    steps: Vec<(ErrorSource, DVector<f64>)>,
    /// Covariance by the noise of traced paths.
    noise: Option<DMatrix<f64>>,
    /// Root mean square difference of a pixel from the reference's image, in units of its noise.
    pub image: f64,
}

impl ModelError {
    /// The error at the optimum, and the images that it comes from; `None` where the reference has no kernels, or no parameter
    /// is estimated.
    pub(crate) fn new(fit: &mut Displacement) -> Result<Option<(Self, ErrorImages)>> {
        let estimated = |(id, _)| fit.covariance.status(id) == Status::Free;
        if !fit.parameters.of_medium().any(estimated) {
            return Ok(None);
        }
        if let Some(batches) = fit.models.batches() {
            return Ok(Some((Self::of_paths(fit, batches)?, ErrorImages(Vec::new()))));
        }
        let light = fit.models.images(fit.parameters)?;
        let mut worst: Option<(Self, ErrorImages)> = None;
        for images in ErrorImages::all(fit, &light)?.into_iter().flatten() {
            let error = Self::of_images(fit, &light, &images)?;
            if worst.as_ref().is_none_or(|(w, _)| error.bias().norm() > w.bias().norm()) {
                worst = Some((error, images));
            }
        }
        Ok(worst)
    }

    fn of_images(fit: &mut Displacement, light: &[Image], images: &ErrorImages) -> Result<Self> {
        let mut this = Self { steps: Vec::new(), noise: None, image: 0.0 };
        for (source, images) in &images.0 {
            let Moved { step, image } = fit.by(light, images)?;
            if *source == ErrorSource::Model {
                this.image = image;
            }
            this.steps.push((*source, step));
        }
        let phase = fit.parameters.along(fit.parameters.id(Quantity::Phase));
        this.steps.push((ErrorSource::Table, phase * width_error(fit.parameters.family())));
        Ok(this)
    }

    /// The error by the noise of traced paths, from batches of them that are independent of each other.
    ///
    /// The gradient of the cost is a mean over pairs of batches, one of which renders and the other derives. Of such a mean
    /// over pairs of n (a U-statistic, Hoeffding 1948) the jackknife's variance is 4/n · ((n - 1)/(n - 2))² times that of the
    /// means over the pairs of one batch.
    fn of_paths(fit: &mut Displacement, batches: usize) -> Result<Self> {
        let steps = (0..batches).map(|batch| fit.by_batch(batch)).collect::<Result<Vec<_>>>()?;
        let n = batches as f64;
        let none = || DVector::zeros(fit.parameters.count());
        let mean = steps.iter().fold(none(), |sum, step| sum + step) / n;
        let mut squares = DMatrix::zeros(mean.len(), mean.len());
        for step in &steps {
            let off = step - &mean;
            squares += &off * off.transpose();
        }
        let noise = squares / (n - 1.0) * 4.0 / n * ((n - 1.0) / (n - 2.0)).powi(2);
        Ok(Self { steps: Vec::new(), noise: Some(noise), image: 0.0 })
    }

    /// Variance of the linear function `gradient`·u of the coordinates by the noise of traced paths.
    pub fn variance_of(&self, gradient: &DVector<f64>) -> f64 {
        self.noise.as_ref().map_or(0.0, |noise| gradient.dot(&(noise * gradient)).max(0.0))
    }

    /// What is stated as the error of the linear function `gradient`·u of the coordinates, source by source.
    pub fn parts(&self, gradient: &DVector<f64>) -> Vec<(ErrorSource, f64)> {
        let mut parts: Vec<(ErrorSource, f64)> = Vec::new();
        for (source, step) in &self.steps {
            let error = source.margin() * gradient.dot(step).abs();
            match parts.iter_mut().find(|(of, _)| of == source) {
                Some((_, sum)) => *sum = sum.hypot(error),
                None => parts.push((*source, error)),
            }
        }
        if self.noise.is_some() {
            parts.push((ErrorSource::Paths, self.variance_of(gradient).sqrt()));
        }
        parts
    }

    /// All of them together.
    pub fn of(&self, gradient: &DVector<f64>) -> f64 {
        self.parts(gradient).iter().map(|(_, error)| error * error).sum::<f64>().sqrt()
    }

    /// The part of it that the reference makes as well: what no model here can know better.
    pub(crate) fn reference_of(&self, gradient: &DVector<f64>) -> f64 {
        let parts = self.parts(gradient).into_iter();
        parts.filter(|(source, _)| *source != ErrorSource::Model).map(|(_, e)| e * e).sum::<f64>().sqrt()
    }

    /// What the model adds that the reference would not: estimate minus truth.
    pub fn bias_of(&self, gradient: &DVector<f64>) -> f64 {
        gradient.dot(&self.bias())
    }

    fn bias(&self) -> DVector<f64> {
        let mut steps = self.steps.iter().filter(|(source, _)| *source == ErrorSource::Model);
        steps.next().map_or_else(|| DVector::zeros(self.count()), |(_, step)| step.clone())
    }

    fn count(&self) -> usize {
        let of_steps = self.steps.first().map(|(_, step)| step.len());
        of_steps.or(self.noise.as_ref().map(DMatrix::nrows)).unwrap_or(0)
    }
}
