//! The scattered kernel as a sum of Gaussians of fixed widths, with weights that depend on depth.

use super::depths::Depths;
use nalgebra::{DMatrix, DVector};
use narrowbeam::error::Result;
use narrowbeam::filter::Optics;
use std::f64::consts::PI;

/// Gaussians, widest first.
#[derive(Debug, Clone)]
pub struct GaussianMixture {
    /// Standard deviations along an axis, px.
    pub sigmas: Vec<f64>,
    /// For each the number of halvings of the image on which it is done.
    pub levels: Vec<usize>,
    /// Highest frequency of the fit, rad/px: aliases count, and more for a kernel narrower than a pixel.
    highest: f64,
}

/// The widest Gaussian over the width z sqrt(B) of the widest kernel, and the narrowest over that or a pixel: narrower
/// ones cannot be told from a point, which is there besides.
const WIDEST: f64 = 2.4;
const NARROWEST: f64 = 0.2;
/// Standard deviation in px of its own image above which a Gaussian may be done on a coarser one: what the half-band
/// filter lets through in its transition is then damped to 1e-4.
const COARSE: f64 = 2.7;

impl GaussianMixture {
    /// The mixture for kernels up to `width_px`, each Gaussian `ratio` times as wide as the next.
    pub fn new(width_px: f64, ratio: f64, coarse: bool) -> Self {
        let widest = WIDEST * width_px;
        let finest = width_px.min(1.0);
        let count = ((widest / (NARROWEST * finest)).ln() / ratio.ln()).floor().max(0.0) as usize + 1;
        let sigmas: Vec<f64> = (0..count).map(|i| widest * ratio.powi(-(i as i32))).collect();
        let level = |&sigma: &f64| if coarse { (sigma / COARSE).log2().floor().max(0.0) as usize } else { 0 };
        Self { levels: sigmas.iter().map(level).collect(), sigmas, highest: HIGHEST / finest }
    }

    /// Coefficients in depth of every Gaussian's weight, then of that of the light which stays in its pixel: least
    /// squares over frequencies on a logarithmic scale, which is how images are: of each octave as much.
    pub fn weights(&self, depths: &Depths, pitch: f64, optics: &Optics) -> Result<Vec<Vec<f64>>> {
        let (first, last) = (0.05 / self.sigmas[0], self.highest);
        let w = |i: usize| first * (last / first).powf(i as f64 / (FREQUENCIES - 1) as f64);
        let columns = self.sigmas.len() + 1;
        let value = |w: f64, j: usize| self.sigmas.get(j).map_or(1.0, |s| (-0.5 * (s * w).powi(2)).exp());
        // The last row asks for the right sum.
        let design = DMatrix::from_fn(FREQUENCIES + 1, columns, |i, j| {
            if i < FREQUENCIES { value(w(i), j) } else { SUM_WEIGHT }
        });
        let mut normal = design.transpose() * &design;
        let ridge = RIDGE * FREQUENCIES as f64;
        (0..columns).for_each(|j| normal[(j, j)] += ridge);
        let solver = normal.cholesky().expect("the ridge makes it positive");
        let mut at_nodes = Vec::new();
        for z in depths.path_lengths() {
            let kernel = optics.kernel(z)?;
            let wanted = DVector::from_fn(FREQUENCIES + 1, |i, _| match i {
                FREQUENCIES => SUM_WEIGHT * kernel.scattered(),
                _ => kernel.scattered_transfer(w(i) / pitch).value,
            });
            let mut found = solver.solve(&(design.transpose() * wanted));
            // What the ridge still keeps from the sum.
            found *= kernel.scattered() / found.sum();
            at_nodes.push(found);
        }
        let to_powers = depths.to_powers();
        let coefficients = |j: usize| {
            let values: Vec<f64> = at_nodes.iter().map(|found| found[j]).collect();
            depths.coefficients(&to_powers, &values)
        };
        Ok((0..columns).map(coefficients).collect())
    }
}

/// Frequencies of the fit, the highest (rad over the kernel's width or a pixel), weight of the sum, and damping.
const FREQUENCIES: usize = 240;
const HIGHEST: f64 = 25.0;
const SUM_WEIGHT: f64 = 100.0;
const RIDGE: f64 = 1e-9;

/// Weights at offsets 0, 1, … between pixels of a Gaussian of standard deviation `sigma` px; they add up to 1 over both sides.
pub fn taps(sigma: f64) -> Vec<f64> {
    let radius = (REACH * sigma + 1.0).ceil() as usize;
    // Second differences of the twice integrated Gaussian: both pixels' areas.
    let twice = |x: f64| {
        let t = x / sigma;
        0.5 * x * libm::erf(t / 2.0_f64.sqrt()) + sigma * (-0.5 * t * t).exp() / (2.0 * PI).sqrt()
    };
    let tap = |d: usize| twice(d as f64 + 1.0) - 2.0 * twice(d as f64) + twice(d as f64 - 1.0);
    normalised((0..=radius).map(tap).collect())
}

/// The same for samples of an image of half the rate, `level` times.
pub fn coarse_taps(sigma: f64, level: usize) -> Vec<f64> {
    // Two pixels' areas have the variance 1/6.
    let variance = (sigma * sigma + 1.0 / 6.0) * 0.25_f64.powi(level as i32);
    let radius = (REACH * variance.sqrt()).ceil() as usize;
    normalised((0..=radius).map(|d| (-0.5 * (d * d) as f64 / variance).exp()).collect())
}

/// Standard deviations to which Gaussians are summed.
const REACH: f64 = 4.0;

/// A filter of even length that halves the rate: flat up to a quarter of it, zero from three quarters on to some 80 dB
/// (a sinc under a Kaiser window); its taps add up to 1.
pub fn half_band(count: usize) -> Vec<f64> {
    let middle = 0.5 * (count - 1) as f64;
    let tap = |k: usize| {
        let x = k as f64 - middle;
        let window = bessel_i0(KAISER * (1.0 - (x / (0.5 * count as f64)).powi(2)).sqrt());
        (0.5 * PI * x).sin() / (PI * x) * window
    };
    let taps: Vec<f64> = (0..count).map(tap).collect();
    let sum: f64 = taps.iter().sum();
    taps.iter().map(|t| t / sum).collect()
}

/// Parameter of the Kaiser window.
const KAISER: f64 = 6.5;

/// The modified Bessel function by its series.
fn bessel_i0(x: f64) -> f64 {
    let term = |(term, k): (f64, f64)| Some((term * (0.5 * x / k).powi(2), k + 1.0));
    std::iter::successors(Some((1.0, 1.0)), |&t| term(t)).take(40).map(|(t, _)| t).sum()
}

fn normalised(mut taps: Vec<f64>) -> Vec<f64> {
    let sum = 2.0 * taps.iter().sum::<f64>() - taps[0];
    taps.iter_mut().for_each(|t| *t /= sum);
    taps
}
