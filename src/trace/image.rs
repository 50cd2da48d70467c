//! Traced images: what a camera sees of an object through the medium, with the variance of every pixel.
//!
//! Each sample starts at a uniformly random position in its pixel. The direct light, exp(-sigma_t z) of the radiance
//! that the ray meets after a path z, is added without noise. The scattered light comes from one path whose first
//! scattering is forced to lie before the object (weight 1 - exp(-sigma_s z)) and which then goes on by chance until
//! it meets the object, where it picks up exp(-sigma_a L) of the radiance, or is lost. Rays that see no object
//! scatter too. The radiance is constant over a pixel of the object image.
//!
//! An object of several layers is met where the nearest of them is. A path that passes an edge of one and gets behind
//! it may meet the next.

use super::OPAQUE;
use super::meeting::Meeting;
use super::path::{Path, free_path};
use super::rng::Stream;
use super::surface::Surface;
use crate::error::{Error, Result, in_range};
use crate::geometry::{Field, Geometry};
use crate::image::{Border, Image, View};
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use glam::DVec3;
use rayon::prelude::*;

/// What to trace. A colour object is traced a channel at a time, each with its own medium.
#[derive(Debug, Clone, Copy)]
pub struct ImageConfig<'a> {
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
    pub medium: Medium,
    /// Paths a pixel, at least 2.
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

impl ImageConfig<'_> {
    fn check(&self) -> Result<()> {
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

/// Traces an image, rows in parallel; `progress` is told the number of paths of each finished row, from any thread.
///
/// # Errors
/// [`Error::OutOfRange`] for sizes that do not fit, less than 2 samples, or what [`Geometry::check`] refuses;
/// [`Error::NothingToFit`] if no pixel shows an object; [`Error::NotFinite`] if a pixel comes out so.
pub fn trace_image<P: PhaseFunction>(
    config: &ImageConfig,
    phase: &P,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<TracedImage> {
    config.check()?;
    let View { width, height, .. } = config.view;
    let tracer = Tracer::new(config, phase);
    let row = |y: usize| -> Vec<[f32; 2]> {
        let pixels = (0..width).map(|x| tracer.pixel(x, y)).collect();
        progress(width as u64 * u64::from(config.samples));
        pixels
    };
    let pixels: Vec<[f32; 2]> = (0..height).into_par_iter().flat_map_iter(row).collect();
    if let Some(i) = pixels.iter().position(|p| !(p[0].is_finite() && p[1].is_finite())) {
        return Err(Error::NotFinite(format!(
            "traced pixel ({}, {}) is {:?}",
            i % width,
            i / width,
            pixels[i]
        )));
    }
    let plane = |c: usize| Image { width, height, data: pixels.iter().map(|p| p[c]).collect() };
    let paths = config.view.pixels() as u64 * u64::from(config.samples);
    Ok(TracedImage { mean: plane(0), variance: plane(1), paths })
}

/// One layer of the object.
struct Layer<'a> {
    surface: Surface,
    radiance: &'a Image,
}

impl Layer<'_> {
    fn light(&self, pixel: usize) -> f64 {
        f64::from(self.radiance.data[pixel])
    }
}

/// A scene made ready for paths. Their z begins at the nearest point of the medium's surface, so that f32
/// resolves the medium however far away the camera is.
struct Tracer<'a, P> {
    config: &'a ImageConfig<'a>,
    phase: &'a P,
    object: Layer<'a>,
    /// The further layers in which there is anything.
    behind: Vec<Layer<'a>>,
    front: Surface,
    origin: DVec3,
    /// Depth beyond which no object lies.
    beyond: f64,
    key: u64,
}

impl<'a, P: PhaseFunction> Tracer<'a, P> {
    fn new(config: &'a ImageConfig<'a>, phase: &'a P) -> Self {
        let ImageConfig { geometry, radiance, behind, border, .. } = *config;
        let pixels =
            || (0..geometry.width * geometry.height).map(|i| (i % geometry.width, i / geometry.width));
        let layer = |depth, radiance| Layer { surface: Surface::layer(geometry, depth, border), radiance };
        let object = layer(&geometry.depth, radiance);
        let behind: Vec<_> = (geometry.behind.iter().zip(behind))
            .filter(|(depth, _)| pixels().any(|(x, y)| depth.distance(x, y).is_some()))
            .map(|(depth, radiance)| layer(depth, radiance))
            .collect();
        let front = Surface::front(geometry, border);
        let origin = DVec3::Z * front.depths().0;
        let farthest = |layer: &Layer| layer.surface.depths().1;
        let beyond = behind.iter().map(farthest).fold(farthest(&object), f64::max);
        Self { config, phase, object, behind, front, origin, beyond, key: Stream::key(config.seed) }
    }

    /// Mean and variance of the mean of pixel (`x`, `y`) of the view.
    fn pixel(&self, x: usize, y: usize) -> [f32; 2] {
        let View { x: left, y: top, width, .. } = self.config.view;
        let samples = u64::from(self.config.samples);
        let first = (y * width + x) as u64 * samples;
        let (mut mean, mut deviation) = (0.0, 0.0);
        for i in 0..samples {
            let mut stream = Stream::new(self.key, first + i);
            let u = (left + x) as f64 + stream.uniform_f64();
            let v = (top + y) as f64 + stream.uniform_f64();
            // Welford's update: no cancellation between a sum of squares and a square of the sum.
            let light = self.sample(u, v, &mut stream);
            let change = light - mean;
            mean += change / (i + 1) as f64;
            deviation += change * (light - mean);
        }
        [mean as f32, (deviation / (samples * (samples - 1)) as f64) as f32]
    }

    /// Light through image position (`u`, `v`) px of the object image.
    fn sample(&self, u: f64, v: f64, stream: &mut Stream) -> f64 {
        let Geometry { camera, width, height, .. } = *self.config.geometry;
        let medium = self.config.medium;
        let Some((surface, _)) = self.front.at(u, v) else { return 0.0 };
        let (start, direction) = camera.ray(u, v, (width, height));
        let start = start + direction * ((surface - start.z) / direction.z);
        let mut path = Path::new((start - self.origin).as_vec3(), direction.as_vec3());
        let Some((depth, light)) = self.seen(u, v) else {
            return self.follow(&mut path, stream);
        };
        let z = ((depth - surface) / direction.z).max(0.0);
        let direct = medium.transmittance(z) * light;
        // Share of the light that is scattered before the object; the first free path is drawn from that share.
        let share = -(-medium.tau(z)).exp_m1();
        if share == 0.0 {
            return direct;
        }
        let distance = -(-share * stream.uniform_f64()).ln_1p() / medium.sigma_s();
        path.advance(distance.min(z) as f32);
        path.scatter(self.phase, stream);
        direct + share * self.follow(&mut path, stream)
    }

    /// Depth and radiance of the nearest layer at image position (`u`, `v`) px. Where a layer repeats the one in front
    /// of it, the latter counts.
    fn seen(&self, u: f64, v: f64) -> Option<(f64, f64)> {
        let there = |layer: &Layer| {
            let (depth, pixel) = layer.surface.at(u, v)?;
            Some((depth, layer.light(pixel)))
        };
        [&self.object].into_iter().chain(&self.behind).filter_map(there).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Where the segment from `p` in direction `d` first meets a layer within `length`, and which.
    #[inline]
    fn meet(&self, p: DVec3, d: DVec3, length: f64) -> Option<(Meeting, &Layer<'a>)> {
        let mut first = self.object.surface.meet(p, d, length).map(|meeting| (meeting, &self.object));
        for layer in &self.behind {
            if let Some(meeting) = layer.surface.meet(p, d, length)
                && first.is_none_or(|(nearest, _)| meeting.distance < nearest.distance)
            {
                first = Some((meeting, layer));
            }
        }
        first
    }

    /// Light that a path picks up from where it is: none if it is lost.
    fn follow(&self, path: &mut Path, stream: &mut Stream) -> f64 {
        let sigma_s = self.config.medium.sigma_s() as f32;
        let sigma_a = self.config.medium.sigma_a();
        if sigma_s == 0.0 {
            return 0.0;
        }
        loop {
            let step = free_path(sigma_s, stream);
            let (p, d) = (path.position.as_dvec3() + self.origin, path.direction.as_dvec3());
            if let Some((Meeting { distance, pixel }, layer)) = self.meet(p, d, f64::from(step)) {
                let Some(pixel) = pixel else { return 0.0 };
                if self.front.is_left(p, d, distance) {
                    return 0.0;
                }
                let length = f64::from(path.length) + distance;
                return (-sigma_a * length).exp() * layer.light(pixel);
            }
            path.advance(step);
            let gone = f64::from(path.position.z) + self.origin.z > self.beyond;
            if gone || sigma_a as f32 * path.length > OPAQUE || self.front.is_left(p, d, f64::from(step)) {
                return 0.0;
            }
            path.scatter(self.phase, stream);
        }
    }
}
