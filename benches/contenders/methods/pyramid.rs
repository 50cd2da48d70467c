//! A sum of Gaussians in separable passes, each on the image itself or on one of a lower rate.

use super::depths::{Depths, padded};
use super::mixture::{GaussianMixture, coarse_taps, half_band, taps};
use super::stages::{BLUR, Blur, DOUBLE, Double, HALVE, Halve, SHARP, Sharp};
use super::{NODES, Scene, Work};
use narrowbeam::error::Result;
use narrowbeam::filter::Optics;
use narrowbeam::gpu::{Gpu, Recording};
use wgpu::Buffer;

/// Numbers beyond the image at each end of a coarser one: the filter's reach.
const MARGIN: usize = 4;
/// Taps of the half-band filter.
const TAPS: usize = 16;

/// The object on the device: itself, and at lower rates its products with the powers of the place in depth.
pub struct Pyramid<'a> {
    gpu: &'a Gpu,
    scene: &'a Scene,
    mixture: &'a GaussianMixture,
    depths: Depths,
    half_band: Buffer,
    levels: Vec<Level>,
    /// Working space.
    spare: Buffer,
}

struct Level {
    /// Side, px.
    n: usize,
    /// Radiance and places on the first level, products on all others.
    input: Buffer,
    image: Buffer,
}

impl<'a> Pyramid<'a> {
    pub fn new(gpu: &'a Gpu, scene: &'a Scene, mixture: &'a GaussianMixture) -> Result<Self> {
        let depths = scene.depths(NODES);
        let (light, places): (Vec<f32>, Vec<f32>) = scene.sources(&depths).map(|[l, p]| (l, p)).unzip();
        let filter: Vec<f32> = half_band(TAPS).iter().map(|&h| h as f32).collect();
        let level = |(i, n): (usize, usize)| {
            let input = match i {
                0 => gpu.upload("light and places", &[&light[..], &places].concat())?,
                _ => gpu.empty::<f32>("products", depths.terms() * n * n)?,
            };
            Ok(Level { n, input, image: gpu.empty::<f32>("image", n * n)? })
        };
        let levels = sides(scene.n, mixture).into_iter().enumerate().map(level).collect::<Result<_>>()?;
        let spare = scene.n * scene.n.max(depths.terms() * (scene.n / 2 + 2 * MARGIN + 1));
        let half_band = gpu.upload("half-band filter", &filter)?;
        let spare = gpu.empty::<f32>("working space", spare)?;
        let pyramid = Self { gpu, scene, mixture, levels, half_band, spare, depths };
        pyramid.halve()?;
        Ok(pyramid)
    }

    /// Fills all levels but the first.
    fn halve(&self) -> Result<()> {
        let mut recording = self.gpu.record();
        let (stage, planes) = (self.gpu.stage(&HALVE), self.depths.terms());
        for (i, pair) in self.levels.windows(2).enumerate() {
            let [fine, coarse] = [&pair[0], &pair[1]];
            let mut pass = |rows: usize, powers: u32, input: &Buffer, output: &Buffer| {
                let parameters = Halve {
                    n: fine.n as u32,
                    rows: rows as u32,
                    result: coarse.n as u32,
                    margin: MARGIN as u32,
                    planes: planes as u32,
                    powers,
                    padding: [0; 2],
                };
                let buffers = [input, &self.half_band, output];
                recording.dispatch(&stage, &parameters, &buffers, planes * rows * coarse.n);
            };
            pass(fine.n, u32::from(i == 0), &fine.input, &self.spare);
            pass(coarse.n, 0, &self.spare, &coarse.input);
        }
        self.gpu.submit(recording)
    }

    /// The image: from the coarsest level on, the level's Gaussians and what came from below.
    pub fn render(&self, optics: &Optics) -> Result<Vec<f32>> {
        let weights = self.mixture.weights(&self.depths, self.scene.pitch(), optics)?;
        let mut recording = self.gpu.record();
        for (l, level) in self.levels.iter().enumerate().rev() {
            match self.levels.get(l + 1) {
                Some(coarse) => self.double(&mut recording, coarse, level),
                None => recording.clear(&level.image),
            }
            if l == 0 {
                self.sharp(&mut recording, &weights[self.mixture.sigmas.len()], optics);
            }
            let mine = (0..self.mixture.sigmas.len()).filter(|&j| self.mixture.levels[j] == l);
            for j in mine {
                self.blur(&mut recording, level, l, self.mixture.sigmas[j], &weights[j])?;
            }
        }
        self.gpu.submit(recording)?;
        self.gpu.read(&self.levels[0].image, self.scene.n * self.scene.n)
    }

    fn blur(
        &self,
        recording: &mut Recording,
        level: &Level,
        l: usize,
        sigma: f64,
        weights: &[f64],
    ) -> Result<()> {
        let taps = level_taps(sigma, l, level.n);
        let buffer = self.gpu.upload("taps", &taps.iter().map(|&t| t as f32).collect::<Vec<_>>())?;
        let stage = self.gpu.stage(&BLUR);
        let mut pass = |terms: usize, powers: bool, adds: bool, input: &Buffer, output: &Buffer| {
            let parameters = Blur {
                n: level.n as u32,
                rows: level.n as u32,
                radius: (taps.len() - 1) as u32,
                terms: terms as u32,
                powers: u32::from(powers),
                adds: u32::from(adds),
                padding: [0; 2],
                coefficients: padded(weights),
            };
            let groups = level.n.div_ceil(OUTPUTS) * level.n.div_ceil(ROWS);
            recording.dispatch_groups(&stage, &parameters, &[input, &buffer, output], groups);
        };
        pass(weights.len(), l == 0, false, &level.input, &self.spare);
        pass(0, false, true, &self.spare, &level.image);
        Ok(())
    }

    fn double(&self, recording: &mut Recording, coarse: &Level, fine: &Level) {
        let stage = self.gpu.stage(&DOUBLE);
        let mut pass = |rows: usize, input: &Buffer, output: &Buffer| {
            let parameters = Double {
                n: coarse.n as u32,
                rows: rows as u32,
                result: fine.n as u32,
                margin: MARGIN as u32,
            };
            recording.dispatch(&stage, &parameters, &[input, &self.half_band, output], rows * fine.n);
        };
        pass(coarse.n, &coarse.image, &self.spare);
        pass(fine.n, &self.spare, &fine.image);
    }

    /// Adds what stays in its pixel.
    fn sharp(&self, recording: &mut Recording, weights: &[f64], optics: &Optics) {
        let pixels = self.scene.n * self.scene.n;
        let parameters = Sharp {
            pixels: pixels as u32,
            terms: weights.len() as u32,
            middle: self.depths.middle as f32,
            half_range: self.depths.half_range as f32,
            sigma_t: optics.medium.sigma_t() as f32,
            padding: [0; 3],
            coefficients: padded(weights),
        };
        let Level { input, image, .. } = &self.levels[0];
        recording.dispatch(&self.gpu.stage(&SHARP), &parameters, &[input, image], pixels);
    }
}

/// Outputs along a row and rows that a workgroup of the stage `blur` takes.
const OUTPUTS: usize = 32;
const ROWS: usize = 8;

/// Sides of the levels, px.
fn sides(n: usize, mixture: &GaussianMixture) -> Vec<usize> {
    let coarsest = mixture.levels.iter().max().copied().unwrap_or(0);
    let coarser = |n: &usize| Some(n.div_ceil(2) + 2 * MARGIN);
    std::iter::successors(Some(n), coarser).take(coarsest + 1).collect()
}

/// Taps on a level, no more than its side has.
fn level_taps(sigma: f64, level: usize, side: usize) -> Vec<f64> {
    let mut taps = if level == 0 { taps(sigma) } else { coarse_taps(sigma, level) };
    taps.truncate(side);
    taps
}

/// A first pass reads its light (8 bytes, or 4 for each coefficient) with a halo and weighs it, a second one adds to what is
/// there; each output takes a product a tap. Resampling takes 16 or 8 taps a pass.
pub fn work(scene: &Scene, mixture: &GaussianMixture) -> [Work; 2] {
    let terms = scene.depths(NODES).terms() as f64;
    let sides = sides(scene.n, mixture);
    let (mut prepare, mut render) = (Work::default(), Work::default());
    let pixels = (scene.n * scene.n) as f64;
    prepare.bytes += 8.0 * pixels;
    render += Work::dispatch(pixels, 2.0 * terms + 5.0, 16.0);
    for pair in sides.windows(2) {
        let [fine, coarse] = [pair[0] as f64, pair[1] as f64];
        prepare += Work::dispatch(terms * fine * coarse, 32.0, 4.0 + 8.0);
        prepare += Work::dispatch(terms * coarse * coarse, 32.0, 4.0 + 8.0);
        render += Work::dispatch(fine * coarse, 16.0, 4.0 + 4.0);
        render += Work::dispatch(fine * fine, 17.0, 4.0 + 4.0);
    }
    for (&sigma, &l) in mixture.sigmas.iter().zip(&mixture.levels) {
        let side = sides[l] as f64;
        let radius = (level_taps(sigma, l, sides[l]).len() - 1) as f64;
        let halo = 1.0 + 2.0 * radius / OUTPUTS as f64;
        let light = if l == 0 { 8.0 } else { 4.0 * terms };
        let taps = 2.0 * (2.0 * radius + 1.0);
        render += Work::dispatch(side * side, taps + 2.0 * terms * halo, light * halo + 4.0);
        render += Work::dispatch(side * side, taps + 1.0, 4.0 * halo + 8.0);
    }
    [prepare, render]
}
