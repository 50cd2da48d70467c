//! Any kernel as a mixture of Gaussians of fixed widths.
//!
//! Every kernel here is a mixture of Gaussians, or nearly so. With *fixed* widths sigma_j, in px, its scattered transfer
//! function is s(k) = sum_j a_j exp(-(sigma_j w)²/2), w = k·pitch, and all that depends on the medium are the numbers a_j.
//! They follow from s by linear least squares over a fixed grid of w, so a matrix made once gives them and their
//! derivatives. An image through the medium is then linear in a few images that do not depend on it: the object
//! blurred by each Gaussian.
//!
//! How dense the widths must lie follows from the kernels' bandwidth in ln w: the Mellin transform of a Gaussian falls
//! like exp(-pi omega/4), and widths that grow by the ratio q resolve omega up to pi/ln q.

use crate::image::Sampling;
use crate::spread::Dual;
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// Ratio of neighbouring widths: with √2 a fit of 512² px by a Gaussian kernel is half a standard error off, with this a
/// tenth.
const RATIO: f64 = 1.3;
/// A Gaussian of at most this width, px, reaches no farther than the next pixel: its light there is c·sigma, c = (2 pi)^-½,
/// of each axis, to exp(-1/(2 sigma²)) = 4e-6. So its image is quadratic in sigma, and three such widths stand for all.
const NARROW: f64 = 0.2;
/// Least width of the mixture, px; what is narrower stays in its pixel.
const LEAST: f64 = 0.01;
/// Frequencies of the grid from the lowest to the highest, rad/px: the first in units of 1 / the largest width.
const GRID: (f64, f64, usize) = (0.2, 2000.0, 220);
/// How much the frequency 0 counts, the mean of all light.
const MEAN_WEIGHT: f64 = 4.0;
/// Singular values below this share of the largest are left out, lest rounding errors of the images be amplified.
const LEAST_SINGULAR: f64 = 1e-5;

/// Widths, and the map from a transfer function to their weights.
pub struct GaussianMixture {
    widths: Vec<f64>,
    /// Frequencies at which a kernel is looked at, rad/px.
    grid: Vec<f64>,
    /// From values on the grid to the weights of [`widths`](Self::widths).
    weights: DMatrix<f64>,
    /// From values on the grid to the errors of the mixture there, as they count.
    errors: DMatrix<f64>,
}

/// Aliases fall like 1/|w|, summed over a ring.
fn importance(w: f64) -> f64 {
    if w == 0.0 { MEAN_WEIGHT } else { (PI / w).min(1.0) }
}

impl GaussianMixture {
    /// The mixture up to the width `widest` px, for images of this sampling.
    pub fn new(widest: f64, sampling: Sampling) -> Self {
        let wide = (0..).map(|i| NARROW * RATIO.powi(i)).take_while(|&s| s < widest * RATIO);
        let mut widths = vec![0.0, 0.5 * NARROW];
        widths.extend(wide);
        let narrow = (1..).map(|i| NARROW / RATIO.powi(i)).take_while(|&s| s > LEAST);
        let mixture: Vec<f64> = widths[2..].iter().copied().chain(narrow).chain([0.0]).collect();

        let (low, high, steps) = (GRID.0 / widths[widths.len() - 1], GRID.1, GRID.2);
        let frequency = |i: usize| low * (high / low).powf(i as f64 / (steps - 1) as f64);
        let grid: Vec<f64> = std::iter::once(0.0).chain((0..steps).map(frequency)).collect();
        let gaussians = DMatrix::from_fn(grid.len(), mixture.len(), |i, j| {
            importance(grid[i]) * (-0.5 * (grid[i] * mixture[j]).powi(2)).exp()
        });
        let counted =
            DMatrix::from_fn(grid.len(), grid.len(), |i, j| if i == j { importance(grid[i]) } else { 0.0 });
        let svd = gaussians.clone().svd(true, true);
        let cut = LEAST_SINGULAR * svd.singular_values.max();
        let fit = svd.pseudo_inverse(cut).expect("both sets of singular vectors were asked for") * &counted;
        let shown =
            DMatrix::from_fn(widths.len(), mixture.len(), |i, j| shown(&widths, i, mixture[j], sampling));
        Self { weights: shown * &fit, errors: gaussians * fit - counted, widths, grid }
    }

    /// The widths whose images are needed, px, increasing from 0.
    pub fn widths(&self) -> &[f64] {
        &self.widths
    }

    /// Values and derivatives of a scattered transfer function of k (rad/length), seen at `pitch` (length per pixel), on
    /// the grid.
    fn sampled(&self, transfer: &dyn Fn(f64) -> Dual, pitch: f64) -> DMatrix<f64> {
        let mut samples = DMatrix::zeros(self.grid.len(), 4);
        for (mut row, w) in samples.row_iter_mut().zip(&self.grid) {
            let Dual { value, gradient: [s, a, b] } = transfer(w / pitch);
            row.copy_from_slice(&[value, s, a, b]);
        }
        samples
    }

    /// Weight of each width's image in the light scattered with the transfer function `transfer`.
    pub fn weights(&self, transfer: &dyn Fn(f64) -> Dual, pitch: f64) -> Vec<Dual> {
        let weights = &self.weights * self.sampled(transfer, pitch);
        let dual = |i: usize| Dual {
            value: weights[(i, 0)],
            gradient: [weights[(i, 1)], weights[(i, 2)], weights[(i, 3)]],
        };
        (0..self.widths.len()).map(dual).collect()
    }

    /// Largest error of the mixture's transfer function, relative to the scattered light.
    pub fn error(&self, transfer: &dyn Fn(f64) -> Dual, pitch: f64) -> f64 {
        let samples = self.sampled(transfer, pitch);
        (&self.errors * samples.column(0)).amax() / samples[(0, 0)].max(f64::MIN_POSITIVE)
    }
}

/// Share that the image of width `widths[i]` has in that of a Gaussian of `width`.
fn shown(widths: &[f64], i: usize, width: f64, sampling: Sampling) -> f64 {
    if width >= NARROW {
        return f64::from(u8::from(widths[i] == width));
    }
    if i > 2 {
        return 0.0;
    }
    // Between band-limited images exp(-(sigma w)²/2) is smooth in sigma²: 2e-4 off at the highest frequency of an axis.
    let variable = |width: f64| match sampling {
        Sampling::Pixel => width,
        Sampling::Bandlimited => width * width,
    };
    let (x, at) = (variable(width), |n: usize| variable(widths[n]));
    (0..3).filter(|&n| n != i).map(|n| (x - at(n)) / (at(i) - at(n))).product()
}
