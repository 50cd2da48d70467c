//! Normal equations of least squares in (ln sigma_s, sigma_a, ln B), summed in f64.
//!
//! Where gain or veil are free their share is taken out of the Gauss-Newton matrix by the Schur complement (variable
//! projection in Kaufman's form, 1975); what belongs to them is kept for their errors.

use crate::image::Image;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};

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
/// Renders are f32: what is below (1e-7)² of the signal is rounding.
const ROUNDING: f64 = 1e-14;

impl NormalEquations {
    /// The decrease of the cost that no longer matters.
    pub(super) fn negligible(&self) -> f64 {
        SETTLED * self.cost / self.pixels as f64 + ROUNDING * self.signal
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

/// Pixels summed together; the chunks are added in order, so that the result does not depend on the threads.
pub(super) const CHUNK: usize = 8192;

/// Sums over pixels of products of residual r, observation y, derivatives j and the linear terms (image, 1).
#[derive(Default)]
pub(super) struct Sums {
    pub rr: f64,
    pub yy: f64,
    pub jr: Vector3<f64>,
    pub jj: Matrix3<f64>,
    pub lj: Matrix2x3<f64>,
}

impl Sums {
    pub(super) fn over(
        pixels: &[(u32, f32)],
        image: &Image,
        gradient: &[Image; 3],
        (exposure, scale): (Vector2<f64>, Vector3<f64>),
    ) -> Self {
        let mut sums = Self::default();
        for &(i, y) in pixels {
            let (i, y) = (i as usize, f64::from(y));
            let m = f64::from(image.data[i]);
            let r = exposure[0] * m + exposure[1] - y;
            let j = Vector3::from_fn(|c, _| f64::from(gradient[c].data[i])).component_mul(&scale);
            sums.rr += r * r;
            sums.yy += y * y;
            sums.jr += j * r;
            sums.jj += j * j.transpose();
            sums.lj += Vector2::new(m, 1.0) * j.transpose();
        }
        sums
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            rr: self.rr + other.rr,
            yy: self.yy + other.yy,
            jr: self.jr + other.jr,
            jj: self.jj + other.jj,
            lj: self.lj + other.lj,
        }
    }
}
