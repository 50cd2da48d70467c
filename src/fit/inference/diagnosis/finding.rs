//! A fault that the residual speaks of.

use super::cause::Cause;
use nalgebra::DVector;

/// A fault that the residual speaks of.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Finding {
    /// The cause, the most significant of those that explain the same part of the residual.
    pub cause: Cause,
    /// Others that explain it nearly as well.
    pub alternatives: Vec<Cause>,
    /// Number of the scene.
    pub scene: usize,
    /// Its size, in the [unit](Cause::unit) of the cause.
    pub amplitude: f64,
    /// Standard error of that.
    pub std_error: f64,
    /// Drop of chi² if it were fitted along.
    pub delta_chi2: f64,
    /// The same as a quantile of the normal distribution, by the noise that was found.
    pub significance: f64,
    /// What it has added to the coordinates, to first order.
    pub bias: DVector<f64>,
}
