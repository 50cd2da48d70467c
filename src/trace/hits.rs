//! Hits: an image of a scene as the paths that make it, which can be replayed for neighbouring media.
//!
//! Every pixel has paths of its own, followed to the real surface, with its edges and slopes, as in
//! [`trace_image`](super::trace_image). Of each path that meets light, n, L, its deflections and the radiance that it meets
//! are recorded. The image in another medium, with its derivatives, is the weighted sum of the replayed paths
//! ([`likelihood`](super::likelihood)). The direct light is exact.
//!
//! If all pixels shared one set of path shapes, their errors would be the same and would not average out over pixels. With
//! separate paths the errors of pixels are independent. Sharing saves the sampling of the paths but not the search for the
//! surface, and is less accurate even at equal time (docs/wide-angle.md, tests/it/traced_shapes.rs).

use super::config::ImageConfig;
use super::image::checked;
use super::likelihood::{EffectiveSampleSize, Information, Likelihood, Replay};
use super::rng::Stream;
use super::scene::Tracer;
use crate::error::{Result, in_range};
use crate::image::{Image, View};
use crate::medium::Medium;
use crate::memory::{Reservation, product, reserve};
use rayon::prelude::*;
use std::ops::Range;

/// Parts of the paths of every pixel that are independent of each other.
pub const BATCHES: usize = 8;

/// Distance from the middle of a pixel, px, of the two points along each side at which the direct light is evaluated:
/// Gauss-Legendre, exact where T is a cubic across a pixel.
const DIRECT: [f64; 2] = [-0.288_675_134_594_812_9, 0.288_675_134_594_812_9];

/// One scattered path that meets light.
#[derive(Debug, Clone, Copy)]
struct Hit<M> {
    scatterings: u32,
    length: f32,
    /// What it adds to its pixel, over all its paths, in the medium that it was traced in.
    light: f32,
    memory: M,
}

/// Direct light of a pixel.
#[derive(Debug, Clone, Copy, Default)]
struct Direct {
    light: f64,
    lengths: [f64; 4],
}

/// The paths of an image.
pub struct Hits<P: Likelihood> {
    medium: Medium<P>,
    view: View,
    paths: u64,
    direct: Vec<Direct>,
    hits: Vec<Hit<P::Memory>>,
    /// Where the hits of each pixel's batches begin, batch by batch; one more for the end.
    starts: Vec<usize>,
    _memory: Reservation,
}

/// A row of the image.
struct Row<M> {
    hits: Vec<Hit<M>>,
    /// How many of them belong to each batch of each pixel.
    counts: Vec<usize>,
}

impl<P: Likelihood> Hits<P> {
    /// Traces `config.samples` paths per pixel, rounded up to a multiple of [`BATCHES`]; `progress` receives the number of
    /// paths of each finished row, from any thread.
    ///
    /// # Errors
    /// Those of [`trace_image`](super::trace_image), [`Error::OutOfRange`](crate::Error::OutOfRange) unless sigma_s is above 0, and
    /// [`Error::Memory`](crate::Error::Memory).
    pub fn trace(config: &ImageConfig<P>, progress: &(dyn Fn(u64) + Sync)) -> Result<Self> {
        config.check()?;
        let (sigma_s, sigma_a) = (config.medium.sigma_s(), config.medium.sigma_a());
        in_range(
            "sigma_s",
            sigma_s,
            sigma_s > 0.0,
            "above 0: without scattering there are no paths to replay",
        )?;
        let view = config.view;
        let tracer = Tracer::new(config);
        let (record, key) = (config.medium.phase().recorder(), Stream::key(config.seed));
        let each = u64::from(config.samples).div_ceil(BATCHES as u64);
        let samples = each * BATCHES as u64;
        let paths = samples * view.pixels() as u64;
        // Rows of hits, which grow to twice their length, and all of them together.
        let bytes = product(&[paths as usize, 2 * size_of::<Hit<P::Memory>>()]);
        let _memory =
            reserve(|| format!("{paths} traced paths of {}x{} px", view.width, view.height), bytes)?;
        let row = |y: usize| -> Row<P::Memory> {
            let (mut hits, mut counts) = (Vec::new(), Vec::new());
            for x in 0..view.width {
                let first = (y * view.width + x) as u64 * samples;
                for batch in 0..BATCHES as u64 {
                    let before = hits.len();
                    for i in batch * each..(batch + 1) * each {
                        let mut stream = Stream::new(key, first + i);
                        let u = (view.x + x) as f64 + stream.uniform_f64();
                        let v = (view.y + y) as f64 + stream.uniform_f64();
                        let direct = tracer.direct(u, v);
                        let (mut scatterings, mut memory) = (0, P::Memory::default());
                        let glimpse = tracer.scattered((u, v), direct, &mut stream, |angle| {
                            scatterings += 1;
                            record(angle, &mut memory);
                        });
                        let Some(arrival) = glimpse.arrival.filter(|a| a.light != 0.0 && scatterings > 0)
                        else {
                            continue;
                        };
                        let unabsorbed = (-sigma_a * arrival.length).exp();
                        let light = (glimpse.share * unabsorbed * arrival.light / samples as f64) as f32;
                        hits.push(Hit { scatterings, length: arrival.length as f32, light, memory });
                    }
                    counts.push(hits.len() - before);
                }
            }
            progress(view.width as u64 * samples);
            Row { hits, counts }
        };
        let rows: Vec<Row<P::Memory>> = (0..view.height).into_par_iter().map(row).collect();
        let mut starts = vec![0];
        for count in rows.iter().flat_map(|row| &row.counts) {
            starts.push(starts[starts.len() - 1] + count);
        }
        let hits = rows.into_iter().flat_map(|row| row.hits).collect();
        let direct = |i: usize| direct(&tracer, view.x + i % view.width, view.y + i / view.width);
        let direct = (0..view.pixels()).into_par_iter().map(direct).collect();
        Ok(Self { medium: config.medium, view, paths, direct, hits, starts, _memory })
    }

    /// The medium that the paths were traced in.
    pub fn medium(&self) -> &Medium<P> {
        &self.medium
    }

    /// Paths traced.
    pub fn paths(&self) -> u64 {
        self.paths
    }

    /// The image in `medium` and its derivatives in sigma_s, sigma_a and the phase-function parameter, from the paths of some `batches`.
    ///
    /// # Errors
    /// [`Error::NotFinite`](crate::Error::NotFinite) if a pixel is not finite.
    pub fn image(&self, medium: &Medium<P>, batches: Range<usize>) -> Result<[Image; 4]> {
        let replay = Replay::new(&self.medium, medium);
        let part = BATCHES as f64 / batches.len() as f64;
        let pixel = |i: usize| -> [f32; 4] {
            let of = |batch: usize| self.starts[i * BATCHES + batch];
            let mut sums = [0.0; 4];
            for hit in &self.hits[of(batches.start)..of(batches.end)] {
                let weight = replay.weight(hit.scatterings, hit.length, hit.memory.as_ref());
                let light = f64::from(hit.light) * weight.ratio;
                sums[0] += light;
                sums[1..].iter_mut().zip(weight.slopes).for_each(|(sum, slope)| *sum += light * slope);
            }
            let direct = self.direct[i].through(medium.sigma_t());
            std::array::from_fn(|c| (part * sums[c] + direct[c]) as f32)
        };
        let pixels: Vec<[f32; 4]> = (0..self.view.pixels()).into_par_iter().map(pixel).collect();
        checked(&pixels, self.view.width)?;
        let View { width, height, .. } = self.view;
        Ok(std::array::from_fn(|c| Image { width, height, data: pixels.iter().map(|p| p[c]).collect() }))
    }

    /// How well the paths serve `medium`, see [`EffectiveSampleSize::relative`].
    pub fn relative_sample_size(&self, medium: &Medium<P>) -> f64 {
        let replay = Replay::new(&self.medium, medium);
        let mut effective = EffectiveSampleSize::default();
        for hit in &self.hits {
            let ratio = replay.weight(hit.scatterings, hit.length, hit.memory.as_ref()).ratio;
            effective.add(f64::from(hit.light), ratio);
        }
        effective.relative()
    }

    /// The information of the paths about the medium.
    pub fn information(&self) -> Information {
        let replay = Replay::new(&self.medium, &self.medium);
        let mut information = Information::default();
        for hit in &self.hits {
            let weight = replay.weight(hit.scatterings, hit.length, hit.memory.as_ref());
            information.add(f64::from(hit.light), weight.slopes);
        }
        information
    }
}

/// Direct light of pixel (`x`, `y`) of the object image.
fn direct<P: Likelihood>(tracer: &Tracer<P>, x: usize, y: usize) -> Direct {
    let mut direct = Direct::default();
    for (i, length) in direct.lengths.iter_mut().enumerate() {
        let at = |c: usize, step: f64| c as f64 + 0.5 + step;
        if let Some(seen) = tracer.direct(at(x, DIRECT[i % 2]), at(y, DIRECT[i / 2])) {
            (direct.light, *length) = (seen.light, seen.length);
        }
    }
    direct
}

impl Direct {
    /// What arrives through a medium of extinction `sigma_t`, and its derivatives.
    fn through(&self, sigma_t: f64) -> [f64; 4] {
        let (mut value, mut slope) = (0.0, 0.0);
        for length in self.lengths {
            let light = 0.25 * self.light * (-sigma_t * length).exp();
            value += light;
            slope -= length * light;
        }
        [value, slope, slope, 0.0]
    }
}
