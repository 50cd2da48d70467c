//! Normal equations of least squares in (ln sigma_s, sigma_a, ln B), summed in f64.
//!
//! Where gain or veil are free their share is taken out of the Gauss-Newton matrix by the Schur complement (variable
//! projection in Kaufman's form, 1975); what belongs to them is kept for their errors.

use super::observed::Counted;
use crate::filter::cpu::Rendering;
use crate::image::Image;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix6, Vector2, Vector3, Vector6};
use rayon::prelude::*;

/// The values of gain and veil that fit best, and what is needed for their errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linear {
    pub gain: f64,
    pub veil: f64,
    pub chi2: f64,
    /// Inverse of the normal matrix of (gain, veil), rows of given ones 0.
    pub inverse: Matrix2<f64>,
    /// Change of (gain, veil) with the coordinates.
    pub coupling: Matrix2x3<f64>,
}

/// Cost ½ chi², its gradient and Gauss-Newton matrix in the solver's coordinates.
#[derive(Debug, Clone, Default)]
pub(crate) struct NormalEquations {
    pub cost: f64,
    /// Pixels, and the observation's sum of squares over noise²: what a change of cost is measured against.
    pub pixels: usize,
    pub signal: f64,
    pub gradient: Vector3<f64>,
    /// With gain and veil eliminated.
    pub matrix: Matrix3<f64>,
    /// Diagonal before they were: the scale against which a direction counts as lost.
    pub diagonal: Vector3<f64>,
    pub(super) linear: Vec<Linear>,
}

/// A decrease of chi² by this times its expectation a pixel moves the estimate by a hundredth of a standard error.
const SETTLED: f64 = 1e-4;
/// Renders are f32: their pixels are rounded by this share, root mean square.
const ROUNDING: f64 = 3e-8;

impl NormalEquations {
    /// The decrease of the cost that no longer matters, or that rounding hides: the sum of r²/2 over pixels with errors e
    /// is off by that of r e, about |r| |e| / √pixels, and by that of e².
    pub(super) fn negligible(&self) -> f64 {
        let (pixels, rounding) = (self.pixels as f64, ROUNDING * self.signal.sqrt());
        let mean_cost = self.cost.max(0.0) / pixels;
        SETTLED * mean_cost + rounding * (2.0 * mean_cost).sqrt() + rounding * rounding
    }

    pub(super) fn add(&mut self, other: NormalEquations) {
        self.cost += other.cost;
        self.pixels += other.pixels;
        self.signal += other.signal;
        self.gradient += other.gradient;
        self.matrix += other.matrix;
        self.diagonal += other.diagonal;
        self.linear.extend(other.linear);
    }

    pub(super) fn is_finite(&self) -> bool {
        self.cost.is_finite() && self.gradient.iter().chain(self.matrix.iter()).all(|v| v.is_finite())
    }
}

/// Sums over the pixels that count, each with its weight, of the products of six images: a render m, its derivatives in
/// sigma_s, sigma_a and B, the residual r = gain · m + veil - y at a reference exposure, and 1. All that a fit asks of a scene
/// follows from them. Near the best exposure r is small, so nothing cancels.
#[derive(Debug, Clone)]
pub struct Products {
    /// Gain and veil at which the residual was formed.
    pub reference: Vector2<f64>,
    /// Every image times every other.
    pub sums: Matrix6<f64>,
}

/// Places in [`Products::sums`].
pub(super) const RENDER: usize = 0;
pub(super) const ONE: usize = 5;

/// Pixels summed together; the chunks are added in order, so that the result does not depend on the threads.
const CHUNK: usize = 8192;

/// The six images at one pixel.
#[inline]
fn six(
    &Counted { index, value, .. }: &Counted,
    image: &Image,
    gradient: Option<&[Image; 3]>,
    reference: Vector2<f64>,
) -> [f64; 6] {
    let i = index as usize;
    let m = f64::from(image.data[i]);
    let [s, a, b] = gradient.map_or([0.0; 3], |g| [0, 1, 2].map(|c| f64::from(g[c].data[i])));
    [m, s, a, b, reference[0] * m + reference[1] - f64::from(value), 1.0]
}

impl Products {
    /// The sums over `pixels` of `image` and its derivatives, which count as 0 if missing.
    pub(super) fn over(
        pixels: &[Counted],
        image: &Image,
        gradient: Option<&[Image; 3]>,
        reference: Vector2<f64>,
    ) -> Self {
        let chunk = |pixels: &[Counted]| {
            let mut sums = [[0.0; 6]; 6];
            for pixel in pixels {
                let all = six(pixel, image, gradient, reference);
                let weighted = all.map(|v| v * f64::from(pixel.weight));
                for (row, left) in sums.iter_mut().zip(weighted) {
                    row.iter_mut().zip(all).for_each(|(sum, right)| *sum += left * right);
                }
            }
            Matrix6::from_fn(|i, j| sums[i][j])
        };
        let chunks: Vec<_> = pixels.par_chunks(CHUNK).map(chunk).collect();
        Self { reference, sums: chunks.into_iter().sum() }
    }

    /// The same sums of the products of one of two renders with the other.
    pub(super) fn between(pixels: &[Counted], renders: [&Rendering; 2], reference: Vector2<f64>) -> Self {
        let chunk = |pixels: &[Counted]| {
            let mut sums = Matrix6::zeros();
            for pixel in pixels {
                let [a, b] =
                    renders.map(|r| Vector6::from(six(pixel, &r.image, r.gradient.as_ref(), reference)));
                sums += a * b.transpose() * f64::from(pixel.weight);
            }
            0.5 * (sums + sums.transpose())
        };
        let chunks: Vec<_> = pixels.par_chunks(CHUNK).map(chunk).collect();
        Self { reference, sums: chunks.into_iter().sum() }
    }

    /// The product of two combinations of the six images.
    pub(super) fn of(&self, a: &Vector6<f64>, b: &Vector6<f64>) -> f64 {
        a.dot(&(self.sums * b))
    }

    /// The observation y as a combination of the six images.
    pub(super) fn observation(&self) -> Vector6<f64> {
        Vector6::new(self.reference[0], 0.0, 0.0, 0.0, -1.0, self.reference[1])
    }

    /// The residual at another `exposure` as a combination of the six images.
    pub(super) fn residual(&self, exposure: &Vector2<f64>) -> Vector6<f64> {
        let change = exposure - self.reference;
        Vector6::new(change[0], 0.0, 0.0, 0.0, 1.0, change[1])
    }
}
