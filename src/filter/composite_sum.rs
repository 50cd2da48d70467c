//! The definition of the composite filter: occluders, slopes and further layers summed pixel by pixel in real space, in
//! f64, with every pixel's own path length.
//!
//! From far to near, all light behind an occluder is gathered at it; what falls on the occluder's opaque pixels ends there,
//! and what passes is a layer of sources at the occluder's own depth. At the occluder k (or the camera)
//!
//! `light_k(x) = sum_j [ W_jk(x - j) + B_jk(x - j)·g_j ] L_j`
//!
//! over all sources j between it and the next occluder, and all that passed the next occluder; g is the slope of the depth
//! in length per pixel. The weights are those of a lattice of pixels. With t = T + s̃, the pixel transfer function
//! ([`footprint`](super::footprint)), and N the kernel's [`mean_slope`](crate::spread::SpreadKernel::mean_slope):
//!
//! | weight | transform at w rad/px |
//! | --- | --- |
//! | W_jk | t_j / t_k, and t_j at the camera |
//! | B_jk | N_j i w/w² sinc² sinc² / t_k; along an axis 0 at its highest frequency, where a derivative has no sign |
//!
//! A further layer's pixel is a source if nothing lies before it, or an opaque pixel between it and what does.

use super::fft2::{Fft2, fast_size};
use super::footprint::{pixel_factor, transfer};
use super::{Optics, Target};
use crate::error::{Error, Result, in_range};
use crate::geometry::Camera;
use crate::image::{Border, Sampling};
use crate::relief::Relief;
use crate::spread::SpreadKernel;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Largest side of an image that is summed, px.
pub const LARGEST: usize = 64;
/// Aliases summed one by one on each side.
const REACH: i32 = 6;
/// Share of a kernel's light that may fall beyond the lattice.
const OUTSIDE: f64 = 1e-8;

/// The image through the medium over the target's view, row-major. Outside the object image there is nothing.
///
/// # Errors
/// [`Error::OutOfRange`] for an image larger than [`LARGEST`]; [`Error::NotBuilt`] for a perspective view or another
/// border than zero; as [`Optics::kernel`] otherwise.
pub fn render(target: &Target, optics: &Optics) -> Result<Vec<f64>> {
    let Camera::Orthographic { pixel_pitch } = target.geometry.camera else {
        return Err(Error::NotBuilt("the composite sum of a perspective view".into()));
    };
    if target.border != Border::Zero {
        return Err(Error::NotBuilt("the composite sum of a clamped or mirrored border".into()));
    }
    let side = target.radiance.width.max(target.radiance.height);
    in_range("image side, px", side as f64, side <= LARGEST, "at most 64")?;

    let free = Relief { slopes: vec![None], occluders: Vec::new() };
    let relief = target.relief.unwrap_or(&free);
    let sources = sources(target, relief);
    let lattice = Lattice::new(target, pixel_pitch, &sources, optics)?;
    let mut passed: Vec<Source> = Vec::new();
    for (i, occluder) in relief.occluders.iter().enumerate().rev() {
        let behind = sources.iter().filter(|s| s.occluders == i + 1).chain(&passed);
        let light = lattice.gather(behind, Some(occluder.z), optics)?;
        let at_occluder = |(place, light): (usize, f64)| {
            let (x, y) = (place % lattice.width, place / lattice.width);
            let inside = x < target.radiance.width && y < target.radiance.height;
            let open = !inside || !occluder.opaque[y * target.radiance.width + x];
            open.then_some(Source { x, y, z: occluder.z, light, slope: [0.0; 2], occluders: i })
        };
        passed = light.into_iter().enumerate().filter_map(at_occluder).collect();
    }
    let light = lattice.gather(sources.iter().filter(|s| s.occluders == 0).chain(&passed), None, optics)?;
    let view = target.view;
    let seen = |i: usize| light[(view.y + i / view.width) * lattice.width + view.x + i % view.width];
    Ok((0..view.pixels()).map(seen).collect())
}

/// Light that sets out from a pixel.
struct Source {
    x: usize,
    y: usize,
    /// Path length.
    z: f64,
    light: f64,
    /// Slope of the depth along x and y, length per pixel.
    slope: [f64; 2],
    /// Occluders before it.
    occluders: usize,
}

/// The object's and its further layers' pixels.
fn sources(target: &Target, relief: &Relief) -> Vec<Source> {
    let geometry = target.geometry;
    let mut found = Vec::new();
    for i in 0..geometry.width * geometry.height {
        let (x, y) = (i % geometry.width, i / geometry.width);
        let layers = std::iter::once((&geometry.depth, target.radiance))
            .chain(geometry.behind.iter().zip(target.behind))
            .zip(&relief.slopes);
        // Occluders before the last source at this pixel.
        let mut before = None;
        for ((distance, radiance), slopes) in layers {
            let Some(d) = distance.distance(x, y) else { continue };
            let z = d - geometry.surface.at(x, y);
            let occluders = relief.occluders.iter().filter(|s| s.depth < d).count();
            let between = |nearer| relief.occluders.iter().take(occluders).skip(nearer);
            let free = before.is_none_or(|nearer| between(nearer).any(|s| s.opaque[i]));
            if z > 0.0 && free {
                let slope = slopes.as_ref().map_or([0.0; 2], |s| s[i].map(f64::from));
                found.push(Source { x, y, z, light: f64::from(radiance.data[i]), slope, occluders });
                before = Some(occluders);
            }
        }
    }
    found
}

/// A torus of pixels, so large that what goes round it does not count; the object image lies in its corner.
struct Lattice {
    width: usize,
    height: usize,
    pitch: f64,
    sampling: Sampling,
}

/// Weights of a source's light and of its light times its slope along x and y, each row-major over all offsets.
type Weights = [Vec<f64>; 3];

impl Lattice {
    fn new(target: &Target, pitch: f64, sources: &[Source], optics: &Optics) -> Result<Self> {
        let farthest = sources.iter().map(|s| s.z).fold(f64::MIN_POSITIVE, f64::max);
        let reach = (optics.kernel(farthest)?.support(OUTSIDE) / pitch).ceil() as usize;
        let size = |n: usize| fast_size(n + reach.max(n));
        Ok(Self {
            width: size(target.radiance.width),
            height: size(target.radiance.height),
            pitch,
            sampling: target.sampling,
        })
    }

    /// Light of `sources` on every pixel at the path length `occluder`, or at the camera.
    fn gather<'s>(
        &self,
        sources: impl Iterator<Item = &'s Source>,
        occluder: Option<f64>,
        optics: &Optics,
    ) -> Result<Vec<f64>> {
        let mut groups: BTreeMap<u64, Vec<&Source>> = BTreeMap::new();
        for source in sources {
            groups.entry(source.z.to_bits()).or_default().push(source);
        }
        let own = match occluder {
            Some(z) => self.transfer(&*optics.kernel(z)?),
            None => self.frequencies(|_, _| 1.0),
        };
        let mut light = vec![0.0; self.width * self.height];
        for (z, sources) in groups {
            let weights = self.weights(&*optics.kernel(f64::from_bits(z))?, &own);
            light.par_chunks_mut(self.width).enumerate().for_each(|(y, row)| {
                for s in &sources {
                    let from = (y + self.height - s.y) % self.height * self.width;
                    let amounts = [s.light, s.slope[0] * s.light, s.slope[1] * s.light];
                    for (weights, amount) in weights.iter().zip(amounts).filter(|(_, amount)| *amount != 0.0)
                    {
                        let weights = &weights[from..from + self.width];
                        let (left, right) = row.split_at_mut(s.x);
                        let offsets = weights.iter().zip(right.iter_mut().chain(left));
                        offsets.for_each(|(weight, light)| *light += weight * amount);
                    }
                }
            });
        }
        Ok(light)
    }

    /// Weights of light from the depth of `kernel` to where the pixel transfer function is `own`.
    fn weights(&self, kernel: &dyn SpreadKernel, own: &[f64]) -> Weights {
        let light = self.transfer(kernel);
        let slope = self.frequencies(|wx, wy| {
            let w = wx.hypot(wy);
            let pixels = pixel_factor(wx, wy, self.sampling);
            if w > 0.0 { pixels * kernel.mean_slope(w / self.pitch, 0.0).value / (w * w) } else { 0.0 }
        });
        let derivative = |i: usize, n: usize| match 2 * i {
            twice if twice < n => along(i, n),
            twice if twice > n => -along(n - i, n),
            _ => 0.0,
        };
        let spectrum = |f: &dyn Fn(usize) -> Complex<f64>| {
            let quotients = (0..own.len()).map(|i| f(i) / own[i]);
            Fft2::<f64>::new(self.width, self.height).inverse(quotients.collect())
        };
        [
            spectrum(&|i| light[i].into()),
            spectrum(&|i| Complex::new(0.0, slope[i] * derivative(i / self.height, self.width))),
            spectrum(&|i| Complex::new(0.0, slope[i] * derivative(i % self.height, self.height))),
        ]
    }

    /// Pixel transfer function T + s̃.
    fn transfer(&self, kernel: &dyn SpreadKernel) -> Vec<f64> {
        let direct = kernel.direct().value;
        self.frequencies(|wx, wy| direct + transfer(kernel, self.pitch, [wx, wy], self.sampling, REACH).value)
    }

    /// A function of |wx| and |wy| (rad/px) at all frequencies of half a spectrum, those along y contiguous.
    fn frequencies(&self, f: impl Fn(f64, f64) -> f64 + Sync) -> Vec<f64> {
        let column = |kx: usize| {
            let wx = along(kx, self.width);
            let half: Vec<f64> = (0..=self.height / 2).map(|ky| f(wx, along(ky, self.height))).collect();
            (0..self.height).map(move |ky| half[ky.min(self.height - ky)])
        };
        (0..=self.width / 2).into_par_iter().flat_map_iter(column).collect()
    }
}

/// Frequency `i` of `n` up to the highest, rad/px.
fn along(i: usize, n: usize) -> f64 {
    2.0 * PI * i as f64 / n as f64
}
