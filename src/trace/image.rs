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

use super::rng::Stream;
use super::scene::{Arrival, Tracer};
use crate::error::{Error, Result, in_range};
use crate::geometry::{Field, Geometry};
use crate::image::{Border, Image, View};
use crate::medium::Medium;
use crate::phase::{Phase, PhaseFunction};
use rayon::prelude::*;

/// What to trace. A colour object is traced a channel at a time, each with its own medium.
#[derive(Debug, Clone, Copy)]
pub struct ImageConfig<'a, P = Phase> {
    /// Camera, object distance, medium surface.
    pub geometry: &'a Geometry,
    /// Clear radiance of the object, the size of `geometry`.
    pub radiance: &'a Image,
    /// Clear radiance of each of the geometry's further layers.
    pub behind: &'a [Image],
    /// What lies outside the object image, for every layer.
    pub border: Border,
    /// The part of the object image to trace.
    pub view: View,
    /// The medium between surface and object.
    pub medium: Medium<P>,
    /// Paths per pixel, at least 2.
    pub samples: u32,
    /// Seed of the random numbers. Channels and scenes that are to be independent need different ones.
    pub seed: u64,
}

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

impl<P> ImageConfig<'_, P> {
    pub(super) fn check(&self) -> Result<()> {
        let (g, size) = (self.geometry, (self.geometry.width, self.geometry.height));
        let same = |name: &str, image: &Image| {
            let ok = (image.width, image.height) == size;
            in_range(
                &format!("width of the {name}, px"),
                image.width as f64,
                ok,
                "the size of the object image",
            )
        };
        let count = self.behind.len() as f64;
        let each = self.behind.len() == g.behind.len();
        in_range("radiance images of further layers", count, each, "one for each of the geometry's")?;
        for image in [self.radiance].into_iter().chain(self.behind) {
            same("radiance image", image)?;
        }
        let distances = g.behind.iter().map(|field| ("depth map of a further layer", field));
        for (name, field) in
            [("depth map", &g.depth), ("surface map", &g.surface)].into_iter().chain(distances)
        {
            if let Field::Map(map) = field {
                same(name, map)?;
            }
        }
        let inside = self.view.fits(size.0, size.1);
        in_range("width of the view, px", self.view.width as f64, inside, "inside the object image")?;
        let enough = "at least 2: the variance is estimated from their differences";
        in_range("samples", f64::from(self.samples), self.samples >= 2, enough)?;
        g.check()
    }
}

/// Traces an image, rows in parallel; `progress` receives the number of paths of each finished row, from any thread.
///
/// # Errors
/// [`Error::OutOfRange`] for sizes that do not match, fewer than 2 samples, or what [`Geometry::check`] refuses;
/// [`Error::NothingToFit`] if no pixel shows an object; [`Error::NotFinite`] if a pixel is not finite.
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
