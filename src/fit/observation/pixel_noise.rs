//! Weights of pixels whose noise is not the same everywhere: given as an image, or as that of a sensor, or with the noise of the clear image on
//! top. The latter two depend on what is fitted, so they are computed again from round to round.

use super::smooth::smoothed;
use super::{NoiseTerm, Observation, Observed};
use crate::error::Result;
use crate::image::Image;
use crate::medium::Medium;
use crate::spread::Model;

/// What the weights depend on.
pub(crate) struct Fitted<'x> {
    pub model: Model,
    pub medium: Medium,
    pub gain: f64,
    /// The image that is fitted to the observation; `None` before there is one.
    pub image: Option<&'x Image>,
}

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
fn sensor(signal: &Image, read: f64, shot: f64) -> Image {
    let of = |v: f32| (read * read + shot * shot * f64::from(v.max(0.0))) as f32;
    Image { data: signal.data.iter().map(|&v| of(v)).collect(), ..*signal }
}

impl Observed<'_> {
    /// Whether the weights depend on what is fitted.
    pub(crate) fn weights_are_fitted(&self) -> bool {
        let given = self.observation.noise;
        matches!(given, Some(NoiseTerm::Sensor { .. })) || (given.is_some() && self.object_noise.is_some())
    }

    /// Weighs the pixels anew; returns the largest relative change of the standard deviation of a pixel.
    ///
    /// # Errors
    /// As [`Model::kernel`].
    pub(crate) fn weigh(&mut self, fitted: &Fitted) -> Result<f64> {
        let mut change = 0.0;
        if self.weights_are_fitted() {
            let variance = self.variance_at(fitted)?;
            let unit = self.noise * self.noise;
            for pixel in self.counted() {
                let before = unit / f64::from(pixel.weight);
                let now = f64::from(variance.data[pixel.index as usize]);
                change = f64::max(change, ((now / before).sqrt() - 1.0).abs());
            }
            self.set_variance(variance);
        }
        let observation = self.observation;
        if let Some(noise) = &mut self.object_noise {
            noise.expect(fitted.model, &fitted.medium, fitted.gain, &observation)?;
        }
        Ok(change)
    }

    /// The variance of each pixel by its own noise and by that of the clear image.
    fn variance_at(&self, fitted: &Fitted) -> Result<Image> {
        let own = match (self.observation.noise, fitted.image) {
            (Some(NoiseTerm::Sensor { read, shot }), Some(image)) => Some(sensor(image, read, shot)),
            _ => first_variance(&self.observation),
        };
        let level = if let Some(NoiseTerm::Level(level)) = self.observation.noise { level } else { 0.0 };
        let Image { width, height, .. } = *self.observation.observed;
        let mut variance = own.unwrap_or_else(|| Image::filled(width, height, (level * level) as f32));
        if let Some(noise) = &self.object_noise {
            let rendered = noise.rendered(fitted.model, &fitted.medium, &self.observation)?;
            let square = fitted.gain * fitted.gain;
            variance.data.iter_mut().zip(rendered).for_each(|(v, more)| *v += (square * more) as f32);
        }
        Ok(variance)
    }
}
