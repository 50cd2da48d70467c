//! The noise of the clear image, and what it leaves in a fit.
//!
//! A render of a noisy object is noisy, and so are its derivatives, with the same noise. Left alone, that biases least squares as errors
//! of a regressor do: the fit prefers media that blur the noise away. To first order in its variance the noise adds its kernel power
//! ([`kernel_power`]) to every inner product of the render and its derivatives. That is subtracted from them, which leaves equations that
//! have the right root on average (Fuller 1987, Measurement Error Models, ch. 2; corrected score, Nakamura 1990).

use super::smooth::smoothed;
use super::{NoiseTerm, Observation};
use crate::error::Result;
use crate::forward::{Pixel, kernel_power};
use crate::image::Image;
use crate::medium::Medium;
use crate::spread::Model;
use nalgebra::DMatrix;

/// Path lengths, at most, for which the kernel's power is computed.
const DEPTHS: usize = 8;

/// The noise of the object of one scene.
#[derive(Clone)]
pub(crate) struct ObjectNoise {
    /// Variance of each pixel of the object image.
    variance: Image,
    /// The depths at which the power is computed.
    depths: Vec<Depth>,
    /// Which of them each pixel of the view has; none if no object is there.
    depth_of: Vec<Option<u8>>,
    /// Variance of each pixel of the view.
    seen: Vec<f32>,
    /// What is left in the sum of squared residuals: the noise is expected there, and chi² counts it as noise.
    expected: f64,
}

/// Some pixels, all about as far away; z is 0 if there are none.
#[derive(Debug, Clone, Copy, Default)]
struct Depth {
    z: f64,
    pitch: f64,
    /// Sum over the pixels that count of weight times variance.
    sum: f64,
}

impl ObjectNoise {
    /// That of `observation`; `None` if its object is without.
    pub(super) fn new(observation: &Observation) -> Option<Self> {
        let noise = observation.object_noise?;
        let (target, view) = (observation.target, observation.target.view);
        let (width, height) = (target.radiance.width, target.radiance.height);
        let variance = match noise {
            NoiseTerm::Level(level) => Image::filled(width, height, (level * level) as f32),
            NoiseTerm::Sensor { read, shot } => {
                let signal = smoothed(target.radiance, |_| true);
                let of = |light: f32| (read * read + shot * shot * f64::from(light.max(0.0))) as f32;
                Image { data: signal.data.iter().map(|&light| of(light)).collect(), ..signal }
            }
            NoiseTerm::Variance(image) => image.clone(),
        };
        let place = |i: usize| (view.x + i % view.width, view.y + i / view.width);
        let length = |i: usize| {
            let (x, y) = place(i);
            let z = target.geometry.path_length(x, y)?;
            let axis = target.geometry.along_axis(x, y, target.geometry.object_distance(x, y)?);
            (z > 0.0).then(|| (z, target.geometry.pixel_pitch(axis)))
        };
        let lengths: Vec<Option<(f64, f64)>> = (0..view.pixels()).map(length).collect();
        let (depths, depth_of) = groups(&lengths);
        let seen = variance.crop(view).data;
        Some(Self { variance, depths, depth_of, seen, expected: 0.0 })
    }

    /// Variance of each pixel of the object image.
    pub(crate) fn variance(&self) -> &Image {
        &self.variance
    }

    /// Takes the pixels that count from now on.
    pub(super) fn observe(&mut self, pixels: &[Pixel]) {
        self.depths.iter_mut().for_each(|depth| depth.sum = 0.0);
        for pixel in pixels {
            let i = pixel.index as usize;
            if let Some(depth) = self.depth_of[i] {
                self.depths[usize::from(depth)].sum += f64::from(pixel.weight) * f64::from(self.seen[i]);
            }
        }
    }

    /// Variance that the noise leaves in each pixel of a render of gain 1 by `model` through `medium`.
    pub(crate) fn rendered(
        &self,
        model: Model,
        medium: &Medium,
        observation: &Observation,
    ) -> Result<Vec<f64>> {
        let power = |depth: &Depth| match depth.z {
            0.0 => Ok(0.0),
            _ => Ok(depth.power(model, medium, observation, 1)?[(0, 0)]),
        };
        let powers = self.depths.iter().map(power).collect::<Result<Vec<f64>>>()?;
        let of =
            |(depth, v): (&Option<u8>, &f32)| depth.map_or(0.0, |d| powers[usize::from(d)] * f64::from(*v));
        Ok(self.depth_of.iter().zip(&self.seen).map(of).collect())
    }

    /// What the noise is expected to add to the products of the render and its derivatives in the medium, and what of it stays in those
    /// of the residual.
    pub(crate) fn products(
        &self,
        model: Model,
        medium: &Medium,
        observation: &Observation,
    ) -> Result<(DMatrix<f64>, f64)> {
        let mut sum = DMatrix::zeros(4, 4);
        for depth in self.depths.iter().filter(|depth| depth.sum > 0.0) {
            sum += depth.power(model, medium, observation, 1)? * depth.sum;
        }
        Ok((sum, self.expected))
    }

    /// Variance of the mean over a block of `side`² pixels over that of white noise: neighbours share what the kernel spreads. `precision`
    /// is 1 over the variance of a pixel of weight 1, of which `pixels` count.
    pub(crate) fn block_inflation(
        &self,
        (model, medium): (Model, &Medium),
        (gain, precision, pixels): (f64, f64, usize),
        observation: &Observation,
        side: usize,
    ) -> Result<f64> {
        let mut excess = 0.0;
        for depth in self.depths.iter().filter(|depth| depth.sum > 0.0) {
            let block = depth.power(model, medium, observation, side)?[(0, 0)];
            let pixel = depth.power(model, medium, observation, 1)?[(0, 0)];
            excess += depth.sum * ((side * side) as f64 * block - pixel);
        }
        Ok(1.0 + gain * gain * precision * excess / pixels as f64)
    }

    /// Counts as noise from now on what is left in the residual at `gain` and this `medium`.
    pub(super) fn expect(
        &mut self,
        model: Model,
        medium: &Medium,
        gain: f64,
        observation: &Observation,
    ) -> Result<()> {
        self.expected = gain * gain * self.products(model, medium, observation)?.0[(0, 0)];
        Ok(())
    }
}

impl Depth {
    fn power(
        &self,
        model: Model,
        medium: &Medium,
        observation: &Observation,
        side: usize,
    ) -> Result<DMatrix<f64>> {
        // Traced paths have no kernels: those of the model that sees the same light stand in.
        let model = if model == Model::Traced { Model::WideAngle } else { model };
        kernel_power(model, medium, (self.z, self.pitch), observation.target.sampling, side)
    }
}

/// Pixels in groups of about the same path length: the mean length and pitch of each, and the group of each pixel.
fn groups(lengths: &[Option<(f64, f64)>]) -> (Vec<Depth>, Vec<Option<u8>>) {
    let all = lengths.iter().flatten();
    let (low, high) = all.fold((f64::INFINITY, 0.0_f64), |(low, high), (z, _)| (low.min(*z), high.max(*z)));
    let group = |z: f64| {
        let share = if high > low { (z / low).ln() / (high / low).ln() } else { 0.0 };
        ((share * DEPTHS as f64) as usize).min(DEPTHS - 1)
    };
    let (mut depths, mut counts) = ([Depth::default(); DEPTHS], [0.0; DEPTHS]);
    for (z, pitch) in lengths.iter().flatten() {
        let i = group(*z);
        (depths[i].z, depths[i].pitch, counts[i]) =
            (depths[i].z + z, depths[i].pitch + pitch, counts[i] + 1.0);
    }
    for (depth, count) in depths.iter_mut().zip(counts).filter(|(_, count)| *count > 0.0) {
        (depth.z, depth.pitch) = (depth.z / count, depth.pitch / count);
    }
    let of = |length: &Option<(f64, f64)>| length.map(|(z, _)| group(z) as u8);
    (depths.to_vec(), lengths.iter().map(of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_grouped_by_their_length() {
        let lengths = [Some((1.0, 0.1)), Some((1.01, 0.1)), None, Some((8.0, 0.4))];
        let (depths, of) = groups(&lengths);
        assert_eq!(of, [Some(0), Some(0), None, Some(7)]);
        assert_eq!((depths[0].z, depths[7].z, depths[7].pitch), (1.005, 8.0, 0.4));
        let (one, of) = groups(&[Some((2.0, 0.1)); 3]);
        assert_eq!((one[0].z, of), (2.0, vec![Some(0); 3]));
    }
}
