//! What depths and gains that are not exactly known do to an estimate.
//!
//! An image alone does not show a wrong depth, nor a wrong gain at one depth: another medium makes the same image. So their
//! errors must be stated in the scene, and are propagated to first order: the estimate moves by a Gauss-Newton step towards
//! the image that the best fit would have with the depth or the gain one standard error off.

use super::displacement::Displacement;
use crate::error::Result;
use crate::filter::Target;
use crate::fit::observation::Observation;
use crate::image::Image;
use crate::relief::Relief;
use crate::scene::Gain;
use nalgebra::{DMatrix, DVector};

/// Covariance of the coordinates by the errors of the input; those of different scenes are independent.
#[derive(Debug, Clone, PartialEq)]
pub struct InputError(DMatrix<f64>);

impl InputError {
    pub(crate) fn new(fit: &mut Displacement) -> Result<Self> {
        let count = fit.parameters.count();
        let mut covariance = DMatrix::zeros(count, count);
        if fit.observations().all(|o| o.depth_error == 0.0 && gain_error(o) == 0.0) {
            return Ok(Self(covariance));
        }
        let best = fit.observations().enumerate().map(|(scene, o)| fit.render(o.target, scene, 1.0));
        let best = best.collect::<Result<Vec<_>>>()?;
        // Traced images are noisy, and would move the estimate by themselves: of paths of the same shapes the noise cancels.
        let still = fit.towards(best.clone())?.step;
        for scene in 0..best.len() {
            let observation = fit.observed[scene].observation;
            for image in displaced(&observation, scene, &best[scene], fit)? {
                let mut images = best.clone();
                images[scene] = image;
                let step = fit.towards(images)?.step - &still;
                covariance += &step * step.transpose();
            }
        }
        Ok(Self(covariance))
    }

    /// Variance of the linear function `gradient`·u of the coordinates.
    pub fn variance_of(&self, gradient: &DVector<f64>) -> f64 {
        gradient.dot(&(&self.0 * gradient))
    }
}

/// What scene number `scene`, at `best`, would look like with its depth, and with its gain, one standard error off.
fn displaced(
    observation: &Observation,
    scene: usize,
    best: &Image,
    fit: &Displacement,
) -> Result<Vec<Image>> {
    let mut images = Vec::new();
    if observation.depth_error > 0.0 {
        let geometry = observation.target.geometry.deeper(observation.depth_error);
        let relief = observation.target.relief.map(|_| Relief::new(&geometry));
        let target = Target { geometry: &geometry, relief: relief.as_ref(), ..observation.target };
        images.push(fit.render(target, scene, 1.0 + observation.depth_error)?);
    }
    let share = gain_error(observation) as f32;
    if share > 0.0 {
        let mut image = best.clone();
        image.data.iter_mut().for_each(|v| *v *= 1.0 + share);
        images.push(image);
    }
    Ok(images)
}

/// Relative error of a gain that is given.
fn gain_error(observation: &Observation) -> f64 {
    if observation.gain == Gain::Free { 0.0 } else { observation.gain_error }
}
