//! What depths and gains that are not exactly known do to an estimate.
//!
//! An image alone cannot tell a wrong depth, nor a wrong gain at one depth: another medium makes the same image. So their
//! errors must be stated in the scene, and are propagated to first order: the estimate moves by a Gauss-Newton step towards
//! the image that the best fit would have with the depth or the gain one standard error off.

use super::displacement::Displacement;
use super::traced::render_stretched;
use super::{Datum, with_optics};
use crate::error::Result;
use crate::filter::Target;
use crate::geometry::{Field, Geometry};
use crate::image::Image;
use crate::relief::Relief;
use crate::scene::Gain;
use crate::spread::Model;
use nalgebra::{Matrix3, Vector3};

/// Covariance of the coordinates (ln sigma_s, sigma_a, ln B) by the errors of the input; those of different scenes are
/// independent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct InputError(Matrix3<f64>);

impl InputError {
    pub(super) fn new(fit: &mut Displacement) -> Result<Self> {
        let data = fit.data;
        let mut covariance = Matrix3::zeros();
        if data.iter().all(|d| d.depth_error == 0.0 && gain_error(d) == 0.0) {
            return Ok(Self(covariance));
        }
        let best = data.iter().enumerate().map(|(i, d)| render(d.target, fit, (i, 1.0)));
        let best = best.collect::<Result<Vec<_>>>()?;
        // Traced images are noisy, and would move the estimate by themselves: of paths of the same shapes the noise cancels.
        let (still, _) = fit.towards(best.clone())?;
        for (i, datum) in data.iter().enumerate() {
            let mut add = |image: Image, fit: &mut Displacement| -> Result<()> {
                let mut images = best.clone();
                images[i] = image;
                let step = fit.towards(images)?.0 - still;
                covariance += step * step.transpose();
                Ok(())
            };
            if datum.depth_error > 0.0 {
                let geometry = deeper(datum.target.geometry, datum.depth_error);
                let relief = datum.target.relief.map(|_| Relief::new(&geometry));
                let target = Target { geometry: &geometry, relief: relief.as_ref(), ..datum.target };
                let image = render(target, fit, (i, 1.0 + datum.depth_error))?;
                add(image, fit)?;
            }
            let share = gain_error(datum) as f32;
            if share > 0.0 {
                let mut image = best[i].clone();
                image.data.iter_mut().for_each(|v| *v *= 1.0 + share);
                add(image, fit)?;
            }
        }
        Ok(Self(covariance))
    }

    /// Variance of the linear function `gradient`·u of the coordinates.
    pub fn variance_of(&self, gradient: &Vector3<f64>) -> f64 {
        gradient.dot(&(self.0 * gradient))
    }
}

/// Relative error of a gain that is given.
fn gain_error(datum: &Datum) -> f64 {
    if datum.gain == Gain::Free { 0.0 } else { datum.gain_error }
}

/// The object farther away by the share `error`, the medium's surface where it is.
fn deeper(geometry: &Geometry, error: f64) -> Geometry {
    let mut deeper = geometry.clone();
    for field in std::iter::once(&mut deeper.depth).chain(&mut deeper.behind) {
        match field {
            Field::Uniform(depth) => *depth *= 1.0 + error,
            Field::Map(map) => map.data.iter_mut().for_each(|depth| *depth *= 1.0 + error as f32),
        }
    }
    deeper
}

/// Scene number `scene`, `deeper` by some factor, by the model at the optimum. If traced, by other paths than the fit's, whose noise
/// is in its derivatives.
fn render(target: Target, fit: &Displacement, (scene, deeper): (usize, f64)) -> Result<Image> {
    let (settings, scene) = (fit.settings, fit.data.len() + scene);
    with_optics(fit.parameters, settings.model, |optics| {
        if optics.model == Model::Traced {
            return render_stretched(target, optics, settings.tracing, (scene as u64, deeper));
        }
        settings.backend.prepare(target, optics, 1.0)?.render(optics)
    })
}
