//! What the residual says of the scene: a score test of each cause that could have made it.
//!
//! A fault that is left out of a fit leaves a residual along the derivative of the image in that fault. So the residual is
//! projected on the derivatives of each [`Cause`], orthogonalised against all that was fitted (Rao 1948). The square of that, in
//! units of its own variance, is the drop of chi² if the fault were fitted along, with as many degrees of freedom as the cause
//! has columns. One step along the columns gives the size of the fault, and what it has done to the estimate.
//!
//! The variance is that of the noise found in the residual with all candidates taken out, correlation between neighbours
//! included, and of what the model is known to err. So a noise level that was estimated with the fault in it does not hide
//! the fault.
//!
//! Causes are taken one after the other, the largest drop of chi² first, and the others are looked at again with it taken out.
//! Those that then have nothing left to explain are named beside it: the image cannot tell them apart.

mod anomalies;
mod cause;
mod columns;
mod fields;
mod finding;
mod frame;
mod grid;
mod noise;
mod object;
mod projected;
mod sandwich;
mod score;

pub use cause::Cause;
pub use finding::Finding;

use super::covariance::Covariance;
use super::displacement::Displacement;
use super::error_images::ErrorImages;
use crate::error::Result;
use columns::Columns;
use fields::Fields;
use frame::Frame;
use nalgebra::DMatrix;
use noise::Noise;
use projected::Projected;
use sandwich::{gradients, of_coordinates};
use score::Scores;

/// Standard deviations from which on a cause is named: of some twenty tests a fit, one of a thousand faultless fits names one.
const SIGNIFICANT: f64 = 4.0;

/// What the residuals of a fit say.
#[derive(Debug)]
pub(super) struct Diagnosis {
    /// Faults, the largest drop of chi² first.
    pub findings: Vec<Finding>,
    /// The noise of each scene.
    pub scenes: Vec<Noise>,
    /// Sum over all scenes of the covariance of the cost's gradient: by the noise that was found, and by blocks of residuals.
    gradients: [DMatrix<f64>; 2],
    /// The same by the noise of the clear images, and of the rest as it is stated; `None` if none has any.
    by_objects: Option<DMatrix<f64>>,
}

impl Diagnosis {
    /// Of the residuals of `fit`, whose model errs by `errors`.
    pub(super) fn new(fit: &Displacement, errors: Option<&ErrorImages>) -> Result<Self> {
        let count = fit.parameters.count();
        let none = || DMatrix::zeros(count, count);
        let mut this =
            Self { findings: Vec::new(), scenes: Vec::new(), gradients: [none(), none()], by_objects: None };
        let is_noisy = fit.observed.iter().any(|o| o.object_noise.is_some());
        // The noise of traced paths is in the residual and in the derivatives alike, and would be taken for a fault.
        let scenes = if fit.models.batches().is_some() { 0 } else { fit.observed.len() };
        for scene in 0..scenes {
            let rendering = fit.models.get(scene).rendering(&fit.parameters.state(scene)?)?;
            let columns = Columns::new(fit, scene, &rendering, errors)?;
            let frame = Frame::new(fit, scene, &columns, rendering);
            let gram = match &fit.observed[scene].object_noise {
                None => frame.gram(),
                Some(noise) => {
                    let medium = fit.parameters.state(scene)?.medium;
                    let observation = &fit.observed[scene].observation;
                    let (power, left) = noise.products(fit.models.model(), &medium, observation)?;
                    frame.without_object_noise(frame.gram(), &power, left)
                }
            };
            let projected = Projected::new(fit, &frame, &gram);
            let fields = Fields::new(&frame, &projected);
            let noise = Noise::new(&frame, &projected, &fields, scene);
            this.findings.extend(Scores::new(&frame, &columns, &projected, &noise).findings(scene));
            this.findings.extend_from_slice(noise.findings());
            let gradients = gradients(&frame, &fields, &noise, count);
            this.gradients.iter_mut().zip(gradients).for_each(|(sum, part)| *sum += part);
            if is_noisy {
                let by_object = match object::gradient(fit, scene, &frame, &fields.slopes)? {
                    Some(gradient) => gradient,
                    None => white(&fields.slopes),
                };
                *this.by_objects.get_or_insert_with(none) += of_coordinates(&frame, &by_object, count);
            }
            this.scenes.push(noise);
        }
        this.findings.sort_by(|a, b| b.delta_chi2.total_cmp(&a.delta_chi2));
        Ok(this)
    }

    /// Variance of the mean of a block of `side`² pixels of scene number `scene` over that of white noise.
    pub(super) fn block_inflation(&self, scene: usize, side: usize) -> f64 {
        self.scenes.get(scene).map_or(1.0, |noise| noise.block_inflation(side))
    }

    /// By how much the variance of the noise of `fit` was taken too small where it was estimated: by fine structure, of which
    /// noise that neighbours share has less.
    pub(super) fn underestimated(&self, fit: &Displacement) -> f64 {
        let scenes = self.scenes.iter().zip(fit.observed);
        let (sum, pixels) = scenes.fold((0.0, 0.0), |(sum, pixels), (noise, observed)| {
            let n = observed.count() as f64;
            let is_estimated = observed.observation.noise.is_none() && !noise.is_white();
            (sum + n * if is_estimated { noise.variance.max(1.0) } else { 1.0 }, pixels + n)
        });
        if pixels > 0.0 { sum / pixels } else { 1.0 }
    }

    /// Covariances of the coordinates that allow for what was found: a noise that is not white, and a residual that is not
    /// noise at all if it is `lacking`.
    pub(super) fn wider(&self, covariance: &Covariance, lacking: bool) -> Vec<DMatrix<f64>> {
        let [by_noise, by_blocks] = &self.gradients;
        let is_other = self.scenes.iter().any(|noise| !noise.findings().is_empty());
        let lacking = lacking && !self.scenes.is_empty();
        let wanted = [is_other.then_some(by_noise), lacking.then_some(by_blocks), self.by_objects.as_ref()];
        let inverse = covariance.inverse();
        wanted.into_iter().flatten().map(|gradient| &inverse * gradient * &inverse).collect()
    }
}

/// Covariance of the gradient along `slopes` by white noise of the stated level.
fn white(slopes: &[Vec<f64>]) -> DMatrix<f64> {
    let n = slopes.len();
    DMatrix::from_fn(n, n, |i, j| slopes[i].iter().zip(&slopes[j]).map(|(a, b)| a * b).sum())
}
