//! What the tests look at, pixel by pixel, in one pass over the columns.

use super::frame::Frame;
use super::projected::Projected;
use nalgebra::DMatrix;

/// Values at each pixel that counts, in units of the noise.
pub(super) struct Fields {
    /// The residual.
    pub residual: Vec<f64>,
    /// The same with all errors and causes taken out.
    pub pure: Vec<f64>,
    /// The derivatives, without the linear terms.
    pub slopes: Vec<Vec<f64>>,
}

impl Fields {
    pub(super) fn new(frame: &Frame, projected: &Projected) -> Self {
        let first = [projected.residual(), projected.pure_residual()];
        let parts: Vec<_> = first.into_iter().chain(projected.derivatives()).collect();
        let mut all = frame.combinations(&DMatrix::from_columns(&parts)).into_iter();
        let mut next = || all.next().expect("a field for each combination");
        let (residual, pure) = (next(), next());
        Self { residual, pure, slopes: all.collect() }
    }

    /// What residuals `value` of the pixels add to the gradient along each derivative.
    pub(super) fn gradient(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let along = |slope: &Vec<f64>| slope.iter().enumerate().map(|(i, s)| s * value(i)).sum();
        self.slopes.iter().map(along).collect()
    }
}
