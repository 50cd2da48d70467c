//! The variances of pixels as far as they follow from what is given: an image of them, or the noise of a sensor.

use super::smooth::smoothed;
use super::{NoiseTerm, Observation};
use crate::image::Image;

/// The variances of the pixels of `observation` as far as they are known before a fit; `None` if all are the same.
pub(super) fn first_variance(observation: &Observation) -> Option<Image> {
    match observation.noise? {
        NoiseTerm::Level(_) => None,
        NoiseTerm::Variance(image) => Some(image.clone()),
        NoiseTerm::Sensor { read, shot } => {
            let signal = smoothed(observation.observed, |i| observation.is_unmasked(i));
            Some(sensor(&signal, read, shot))
        }
    }
}

/// The variance of a sensor's pixels at this `signal`.
pub(super) fn sensor(signal: &Image, read: f64, shot: f64) -> Image {
    let of = |v: f32| (read * read + shot * shot * f64::from(v.max(0.0))) as f32;
    Image { data: signal.data.iter().map(|&v| of(v)).collect(), ..*signal }
}
