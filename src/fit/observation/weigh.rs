//! Weights that depend on what is fitted, computed again from round to round: the noise of a sensor, that of the clear image, and what is doubted of
//! pixels that are far off.

use super::pixel_noise::{first_variance, sensor};
use super::{NoiseTerm, Observed};
use crate::error::Result;
use crate::image::Image;
use crate::medium::Medium;
use crate::scene::Loss;
use crate::spread::Model;

/// What the weights depend on.
pub(crate) struct Fitted<'x> {
    pub model: Model,
    pub medium: Medium,
    pub gain: f64,
    /// The image that is fitted to the observation; `None` before there is one.
    pub image: Option<&'x Image>,
}

impl Observed<'_> {
    /// Whether the weights depend on what is fitted.
    pub(crate) fn weights_are_fitted(&self) -> bool {
        let given = self.observation.noise;
        let is_robust = self.observation.loss == Loss::Huber;
        is_robust
            || matches!(given, Some(NoiseTerm::Sensor { .. }))
            || (given.is_some() && self.object_noise.is_some())
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
        let level = match (self.observation.noise, fitted.image) {
            (Some(NoiseTerm::Level(level)), _) => level,
            (None, Some(image)) => self.robust_noise(image),
            _ => self.noise,
        };
        let Image { width, height, .. } = *self.observation.observed;
        let mut variance = own.unwrap_or_else(|| Image::filled(width, height, (level * level) as f32));
        // Noise that is estimated holds that of the clear image.
        if let Some(noise) = self.object_noise.as_ref().filter(|_| self.observation.noise.is_some()) {
            let rendered = noise.rendered(fitted.model, &fitted.medium, &self.observation)?;
            let square = fitted.gain * fitted.gain;
            variance.data.iter_mut().zip(rendered).for_each(|(v, more)| *v += (square * more) as f32);
        }
        if let Some(image) = fitted.image.filter(|_| self.observation.loss == Loss::Huber) {
            self.doubt_outliers(&mut variance, image);
        }
        Ok(variance)
    }
}
