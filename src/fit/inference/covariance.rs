//! Standard errors from the Gauss-Newton matrix, and what the data leave undetermined.
//!
//! The matrix is scaled to unit diagonal (the diagonal before the linear terms were eliminated) and decomposed into
//! eigenvectors. A direction whose eigenvalue is below rounding moves no pixel: any parameter with a part in it is
//! undetermined. The variance of a linear function g·u is sum (g·v)²/lambda over the others. The eigenvectors are the right
//! singular vectors of the scaled Jacobian, the eigenvalues the squares of its singular values, so this is the covariance by
//! SVD; the sums being f64, the square loses nothing that f32 renders had.

use crate::fit::optimise::NormalEquations;
use crate::fit::parameters::{Id, Parameter, Parameters, Role};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use serde::{Deserialize, Serialize};

/// Eigenvalues of the scaled matrix below this are rounding: renders are f32, good to some 1e-6, and enter squared.
const LOST: f64 = 1e-10;
/// Share (squared) of a function in the lost directions above which it counts as undetermined.
const LEAK: f64 = 1e-6;
/// Standard error of a coordinate in units of its natural scale above which it is not known.
const MOST_ERROR: f64 = 0.5;
/// Error of the model, in units of the natural scale of a coordinate, under which the coordinate is known in any case.
const LEAST_MODEL_ERROR: f64 = 0.1;
/// Two-sided 95 % quantile of the normal distribution.
pub(crate) const Z95: f64 = 1.959_964;

/// What is known of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Status {
    /// Estimated.
    Free,
    /// Given.
    Fixed,
    /// Free, but the data do not decide it.
    Undetermined,
    /// Estimated from an image that contradicts the scene.
    Doubtful,
}

/// Covariance of the coordinates, and the status of each parameter.
#[derive(Debug, Clone)]
pub struct Covariance {
    scale: DVector<f64>,
    eigenvalues: DVector<f64>,
    eigenvectors: DMatrix<f64>,
    variance_scale: f64,
    /// Covariances of the coordinates that allow for more than white noise.
    wider: Vec<DMatrix<f64>>,
    known: Vec<Known>,
}

/// What is known of one coordinate.
#[derive(Debug, Clone, Copy)]
struct Known {
    status: Status,
    std_error: Option<f64>,
}

impl Known {
    const UNDETERMINED: Self = Self { status: Status::Undetermined, std_error: None };
}

/// Whether a coordinate with this `error` is known.
fn is_known(parameter: &Parameter, error: f64) -> bool {
    error <= MOST_ERROR * parameter.scale()
}

/// Error of its model from which on a coordinate is not known: half of the value, or, of sigma_a, 0.1/z if that is more.
fn most_model_error(parameter: &Parameter) -> f64 {
    if parameter.is_logarithmic() {
        MOST_ERROR
    } else {
        (MOST_ERROR * parameter.value()).max(LEAST_MODEL_ERROR * parameter.scale())
    }
}

impl Covariance {
    /// At `parameters`, every variance multiplied by `variance_scale`.
    pub(crate) fn new(equations: &NormalEquations, parameters: &Parameters, variance_scale: f64) -> Self {
        // A parameter that moves nothing, such as a fixed one, gets a row of its own, whose eigenvalue is 0.
        let scale = equations.diagonal.map(|d| if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_diagonal(&scale) * &equations.matrix * DMatrix::from_diagonal(&scale);
        let eigen = SymmetricEigen::new(scaled);
        let mut this = Self {
            scale,
            eigenvalues: eigen.eigenvalues,
            eigenvectors: eigen.eigenvectors,
            variance_scale,
            wider: Vec::new(),
            known: Vec::new(),
        };
        this.known = parameters.iter().map(|(id, p)| this.known_of(id, p, parameters)).collect();
        this
    }

    fn known_of(&self, id: Id, parameter: &Parameter, parameters: &Parameters) -> Known {
        if parameter.descriptor().role != Role::Free {
            return Known { status: Status::Fixed, std_error: None };
        }
        let moves = self.scale[id.row()] > 0.0;
        let error = if moves { self.variance_of(&parameters.along(id)).map(f64::sqrt) } else { None };
        match error.filter(|&e| is_known(parameter, e)) {
            Some(error) => Known { status: Status::Free, std_error: Some(error) },
            None => Known::UNDETERMINED,
        }
    }

    /// Widens every variance to what these covariances of the coordinates say, where that is more.
    pub(crate) fn widen(&mut self, wider: Vec<DMatrix<f64>>, parameters: &Parameters) {
        if !wider.is_empty() {
            self.wider = wider;
            self.known = parameters.iter().map(|(id, p)| self.known_of(id, p, parameters)).collect();
        }
    }

    /// Marks as undetermined what the error of the best model leaves open: its error of the linear function of the
    /// coordinates that is given.
    pub(crate) fn mark_undetermined(
        &mut self,
        parameters: &Parameters,
        error: impl Fn(&DVector<f64>) -> f64,
    ) {
        for (id, parameter) in parameters.iter() {
            let known = &mut self.known[id.row()];
            let error = error(&parameters.along(id));
            if known.status == Status::Free && error > most_model_error(parameter) {
                *known = Known::UNDETERMINED;
            }
        }
    }

    /// Variance of the linear function `gradient`·u of the coordinates; `None` if the data do not decide it.
    pub fn variance_of(&self, gradient: &DVector<f64>) -> Option<f64> {
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
        let wider = self.wider.iter().map(|matrix| gradient.dot(&(matrix * gradient)));
        Some(wider.fold(variance * self.variance_scale, f64::max))
    }

    /// The inverse of the Gauss-Newton matrix, but along what the data do not decide.
    pub(crate) fn inverse(&self) -> DMatrix<f64> {
        let n = self.scale.len();
        let mut inverse = DMatrix::zeros(n, n);
        let decided =
            self.eigenvalues.iter().zip(self.eigenvectors.column_iter()).filter(|(value, _)| **value > LOST);
        decided.for_each(|(value, vector)| inverse += vector * vector.transpose() / *value);
        DMatrix::from_diagonal(&self.scale) * inverse * DMatrix::from_diagonal(&self.scale)
    }

    /// The Gauss-Newton step from where the cost has `gradient`, but along what the data do not decide.
    pub(crate) fn step(&self, gradient: &DVector<f64>) -> DVector<f64> {
        let g = gradient.component_mul(&self.scale);
        let decided =
            self.eigenvalues.iter().zip(self.eigenvectors.column_iter()).filter(|(value, _)| **value > LOST);
        let mut step = DVector::zeros(g.len());
        decided.for_each(|(value, vector)| step += vector * (-vector.dot(&g) / value));
        step.component_mul(&self.scale)
    }

    /// Correlation of the errors of two coordinates; `None` unless both are estimated.
    pub fn correlation(&self, i: Id, j: Id) -> Option<f64> {
        let (a, b) = (self.std_error(i)?, self.std_error(j)?);
        let mut sum = DVector::zeros(self.scale.len());
        (sum[i.row()], sum[j.row()]) = (1.0, 1.0);
        let both = self.variance_of(&sum)?;
        Some(((both - a * a - b * b) / (2.0 * a * b)).clamp(-1.0, 1.0))
    }

    /// By what every variance is multiplied.
    pub(crate) fn variance_scale(&self) -> f64 {
        self.variance_scale
    }

    /// Status of a parameter.
    pub fn status(&self, id: Id) -> Status {
        self.known[id.row()].status
    }

    /// Standard error of a coordinate, `None` if fixed or undetermined.
    pub fn std_error(&self, id: Id) -> Option<f64> {
        self.known[id.row()].std_error
    }

    /// Whether some free parameter is undetermined.
    pub fn leaves_open(&self) -> bool {
        self.known.iter().any(|known| known.status == Status::Undetermined)
    }
}
