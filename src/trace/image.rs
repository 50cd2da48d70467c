//! Traced images: what a camera sees of an object through the medium, with the variance of every pixel.
//!
//! Each sample starts at a uniformly random position in its pixel. The direct light, exp(-sigma_t z) of the radiance
//! that the ray meets after a path z, is added without noise. The scattered light comes from one path whose first
//! scattering is forced to lie before the object (weight 1 - exp(-sigma_s z)) and which then continues at random until
//! it meets the object, where it picks up exp(-sigma_a L) of the radiance, or is lost. Rays that see no object
//! scatter too. The radiance is constant over a pixel of the object image.
//!
//! An object of several layers is met where the nearest of them is. A path that passes an edge of one and gets behind
//! it may meet the next.

use super::config::ImageConfig;
use super::rng::Stream;
use super::scene::{Arrival, Tracer};
use crate::error::{Error, Result};
use crate::image::{Image, View};
use crate::phase::PhaseFunction;
use rayon::prelude::*;

/// A traced image.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedImage {
    /// Mean radiance over each pixel.
    pub mean: Image,
    /// Variance of that mean.
    pub variance: Image,
    /// Paths traced.
    pub paths: u64,
}

/// Traces an image, rows in parallel; `progress` receives the number of paths of each finished row, from any thread.
///
/// # Errors
/// [`Error::OutOfRange`] for sizes that do not match, fewer than 2 samples, or what
/// [`Geometry::check`](crate::geometry::Geometry::check) refuses; [`Error::NothingToFit`] if no pixel shows an object;
/// [`Error::NotFinite`] if a pixel is not finite.
pub fn trace_image<P: PhaseFunction + Copy>(
    config: &ImageConfig<P>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<TracedImage> {
    config.check()?;
    let View { width, height, .. } = config.view;
    let tracer = Tracer::new(config);
    let key = Stream::key(config.seed);
    let row = |y: usize| -> Vec<[f32; 2]> {
        let pixels = (0..width).map(|x| pixel(config, &tracer, key, x, y)).collect();
        progress(width as u64 * u64::from(config.samples));
        pixels
    };
    let pixels: Vec<[f32; 2]> = (0..height).into_par_iter().flat_map_iter(row).collect();
    checked(&pixels, width)?;
    let plane = |c: usize| Image { width, height, data: pixels.iter().map(|p| p[c]).collect() };
    let paths = config.view.pixels() as u64 * u64::from(config.samples);
    Ok(TracedImage { mean: plane(0), variance: plane(1), paths })
}

/// Refuses pixels that are not finite, of rows of `width`.
pub(super) fn checked<const N: usize>(pixels: &[[f32; N]], width: usize) -> Result<()> {
    match pixels.iter().position(|p| !p.iter().all(|v| v.is_finite())) {
        None => Ok(()),
        Some(i) => {
            Err(Error::NotFinite(format!("traced pixel ({}, {}) is {:?}", i % width, i / width, pixels[i])))
        }
    }
}

/// Mean and variance of the mean of pixel (`x`, `y`) of the view.
fn pixel<P: PhaseFunction + Copy>(
    config: &ImageConfig<P>,
    tracer: &Tracer<P>,
    key: u64,
    x: usize,
    y: usize,
) -> [f32; 2] {
    let View { x: left, y: top, width, .. } = config.view;
    let medium = config.medium;
    let samples = u64::from(config.samples);
    let first = (y * width + x) as u64 * samples;
    let (mut mean, mut deviation) = (0.0, 0.0);
    for i in 0..samples {
        let mut stream = Stream::new(key, first + i);
        let u = (left + x) as f64 + stream.uniform_f64();
        let v = (top + y) as f64 + stream.uniform_f64();
        let direct = tracer.direct(u, v);
        let scattered = tracer.scattered((u, v), direct, &mut stream, |_| ());
        let unabsorbed = |a: Arrival| (-medium.sigma_a() * a.length).exp() * a.light;
        let light = direct.map_or(0.0, |d| medium.transmittance(d.length) * d.light)
            + scattered.share * scattered.arrival.map_or(0.0, unabsorbed);
        // Welford's update: no cancellation between a sum of squares and a square of the sum.
        let change = light - mean;
        mean += change / (i + 1) as f64;
        deviation += change * (light - mean);
    }
    [mean as f32, (deviation / (samples * (samples - 1)) as f64) as f32]
}
