//! What the noise of the clear image does to the cost's gradient.
//!
//! It reaches the residual through the kernel K, so neighbouring residuals share it. The gradient along the derivative J is J'W times the
//! residual, and its covariance J'W (N + g² K V K') W J, with the observation's own noise N and the variance V of the object. K'(WJ) is a
//! render of WJ: kernels are symmetric.

use super::frame::Frame;
use crate::error::{Error, Result};
use crate::filter::Target;
use crate::fit::inference::displacement::Displacement;
use crate::image::{Border, Image, View};
use nalgebra::DMatrix;

/// The covariance of the gradient along `slopes`, the derivatives of scene number `scene` over the standard deviation of each pixel; `None`
/// if the object has no noise, or the model no kernels.
pub(super) fn gradient(
    fit: &Displacement,
    scene: usize,
    frame: &Frame,
    slopes: &[Vec<f64>],
) -> Result<Option<DMatrix<f64>>> {
    let observed = frame.observed();
    let Some(noise) = &observed.object_noise else { return Ok(None) };
    let target = observed.observation.target;
    let gain = fit.exposures[scene].gain;
    let medium = fit.parameters.state(scene)?.medium;
    let rendered = noise.rendered(fit.models.model(), &medium, &observed.observation)?;
    // Of each pixel, the standard deviation of all its noise, and the share of its own in the variance.
    let pixels: Vec<(usize, f64, f64)> = observed
        .counted()
        .iter()
        .map(|pixel| {
            let (i, deviation) = (pixel.index as usize, observed.noise / f64::from(pixel.weight).sqrt());
            (i, deviation, (1.0 - gain * gain * rendered[i] / (deviation * deviation)).max(0.0))
        })
        .collect();
    let variance = noise.variance();
    let spread = |slope: &Vec<f64>| -> Result<Image> {
        let mut image = Image::filled(variance.width, variance.height, 0.0);
        for ((i, deviation, _), slope) in pixels.iter().zip(slope) {
            let (x, y) = (target.view.x + i % target.view.width, target.view.y + i / target.view.width);
            image.data[y * variance.width + x] = (slope / deviation) as f32;
        }
        let behind: Vec<Image> =
            target.behind.iter().map(|_| Image::filled(variance.width, variance.height, 0.0)).collect();
        let view = View::whole(variance.width, variance.height);
        let seen =
            Target { radiance: &image, behind: &behind, border: Border::Zero, view, relief: None, ..target };
        fit.engine.without_noise().image(seen, &medium.into(), scene, 1.0)
    };
    let spread = match slopes.iter().map(spread).collect::<Result<Vec<_>>>() {
        Err(error) if error.is_about_model() || matches!(error, Error::OutOfRange { .. }) => return Ok(None),
        spread => spread?,
    };
    let n = slopes.len();
    Ok(Some(DMatrix::from_fn(n, n, |i, j| {
        let own = pixels.iter().zip(&slopes[i]).zip(&slopes[j]).map(|(((_, _, own), a), b)| own * a * b);
        let objects = variance.data.iter().zip(&spread[i].data).zip(&spread[j].data);
        let object = objects.map(|((v, a), b)| f64::from(*v) * f64::from(*a) * f64::from(*b));
        own.sum::<f64>() + gain * gain * object.sum::<f64>()
    })))
}
