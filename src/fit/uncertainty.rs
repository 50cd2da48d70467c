//! Standard errors from the Gauss-Newton matrix, and what the data leave undetermined.
//!
//! The matrix is scaled to unit diagonal (the diagonal before gain and veil were eliminated) and decomposed into
//! eigenvectors. A direction whose eigenvalue is below rounding moves no pixel: any parameter with a part in it is
//! undetermined. The variance of a linear function g·u is sum (g·v)²/lambda over the others. The eigenvectors are the right
//! singular vectors of the scaled Jacobian, the eigenvalues the squares of its singular values, so this is the covariance by
//! SVD; the sums being f64, the square loses nothing that f32 renders had.

use super::equations::NormalEquations;
use super::parameters::Parameters;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Eigenvalues of the scaled matrix below this are rounding: renders are f32, good to some 1e-6, and enter squared.
const LOST: f64 = 1e-10;
/// Share (squared) of a function in the lost directions above which it counts as undetermined.
const LEAK: f64 = 1e-6;
/// A logarithm, or sigma_a times z, with a standard error above this is not known.
const MOST_ERROR: f64 = 0.5;
/// Two-sided 95 % quantile of the normal distribution.
pub(super) const Z95: f64 = 1.959_964;

/// Whether a coordinate with this `error` is known.
fn is_known(i: usize, error: f64, median_z: f64) -> bool {
    error <= if Parameters::is_logarithmic(i) { MOST_ERROR } else { MOST_ERROR / median_z }
}

/// What is known of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Estimated.
    Free,
    /// Given.
    Fixed,
    /// Free, but the data do not decide it.
    Undetermined,
}

/// Covariance of the coordinates (ln sigma_s, sigma_a, ln B), and the status of each parameter.
#[derive(Debug, Clone)]
pub struct Uncertainty {
    scale: Vector3<f64>,
    eigenvalues: Vector3<f64>,
    eigenvectors: Matrix3<f64>,
    inflation: f64,
    status: [Status; 3],
    std_errors: [Option<f64>; 3],
}

impl Uncertainty {
    /// Every variance is multiplied by `inflation`.
    pub(super) fn new(
        equations: &NormalEquations,
        parameters: &Parameters,
        median_z: f64,
        inflation: f64,
    ) -> Self {
        // A parameter that moves nothing, such as a fixed one, gets a row of its own, whose eigenvalue is 0.
        let scale = equations.diagonal.map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
        let scaled = Matrix3::from_diagonal(&scale) * equations.matrix * Matrix3::from_diagonal(&scale);
        let eigen = SymmetricEigen::new(scaled);
        let mut this = Self {
            scale,
            eigenvalues: eigen.eigenvalues,
            eigenvectors: eigen.eigenvectors,
            inflation,
            status: [Status::Fixed; 3],
            std_errors: [None; 3],
        };
        for i in 0..3 {
            if parameters.is_fixed(i) {
                continue;
            }
            let unit = Vector3::from_fn(|j, _| f64::from(u8::from(i == j)));
            let error = if scale[i] > 0.0 { this.variance_of(&unit).map(f64::sqrt) } else { None };
            this.status[i] = if error.is_some_and(|e| is_known(i, e, median_z)) {
                Status::Free
            } else {
                Status::Undetermined
            };
            if this.status[i] == Status::Free {
                this.std_errors[i] = error;
            }
        }
        this
    }

    /// Takes as undetermined what the error of the best model leaves open: its error of each coordinate is `error`.
    pub(super) fn distrust(&mut self, error: impl Fn(usize) -> f64, median_z: f64) {
        for i in 0..3 {
            if self.status[i] == Status::Free && !is_known(i, error(i), median_z) {
                self.status[i] = Status::Undetermined;
                self.std_errors[i] = None;
            }
        }
    }

    /// Variance of the linear function `gradient`·u of the coordinates; `None` if the data do not decide it.
    pub fn variance_of(&self, gradient: &Vector3<f64>) -> Option<f64> {
        let g = gradient.component_mul(&self.scale);
        let whole = g.norm_squared();
        let mut variance = 0.0;
        for (value, vector) in self.eigenvalues.iter().zip(self.eigenvectors.column_iter()) {
            let along = g.dot(&vector).powi(2);
            if *value > LOST {
                variance += along / value;
            } else if along > LEAK * whole {
                return None;
            }
        }
        Some(variance * self.inflation)
    }

    /// The Gauss-Newton step from where the cost has `gradient`, but along what the data do not decide.
    pub(super) fn step(&self, gradient: &Vector3<f64>) -> Vector3<f64> {
        let g = gradient.component_mul(&self.scale);
        let decided =
            self.eigenvalues.iter().zip(self.eigenvectors.column_iter()).filter(|(value, _)| **value > LOST);
        let step: Vector3<f64> = decided.map(|(value, vector)| vector * (-vector.dot(&g) / value)).sum();
        step.component_mul(&self.scale)
    }

    /// Correlation of the errors of two coordinates; `None` unless both are estimated.
    pub fn correlation(&self, i: usize, j: usize) -> Option<f64> {
        let (a, b) = (self.std_errors[i]?, self.std_errors[j]?);
        let both = self.variance_of(&(Vector3::ith(i, 1.0) + Vector3::ith(j, 1.0)))?;
        Some(((both - a * a - b * b) / (2.0 * a * b)).clamp(-1.0, 1.0))
    }

    /// By what every variance is multiplied.
    pub(super) fn inflation(&self) -> f64 {
        self.inflation
    }

    /// Status of parameter `i`.
    pub fn status(&self, i: usize) -> Status {
        self.status[i]
    }

    /// Standard error of coordinate `i`, `None` if fixed or undetermined.
    pub fn std_error(&self, i: usize) -> Option<f64> {
        self.std_errors[i]
    }
}
