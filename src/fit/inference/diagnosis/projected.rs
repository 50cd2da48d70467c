//! Products of the columns of one scene with what was fitted projected out.

use super::frame::Frame;
use crate::fit::inference::displacement::Displacement;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Singular values below this share of the largest count as 0.
const SINGULAR: f64 = 1e-9;

/// Errors, causes and residual, orthogonalised against linear terms and derivatives.
pub(super) struct Projected {
    /// Products of errors, causes and residual, in this order.
    pub products: DMatrix<f64>,
    /// Squares of the same columns before.
    pub squares: DVector<f64>,
    /// Change of the coordinates by the unit of each column: what a fault of that size adds to an estimate.
    pub bias: DMatrix<f64>,
    /// Of each such column its parts in all columns of the frame.
    parts: DMatrix<f64>,
    /// The same of each derivative, with the linear terms projected out alone.
    derivatives: DMatrix<f64>,
    /// Inverse of the normal matrix of all coordinates.
    inverse: DMatrix<f64>,
}

impl Projected {
    pub(super) fn new(fit: &Displacement, frame: &Frame, gram: &DMatrix<f64>) -> Self {
        let [linear, derivatives, extra] = frame.ranges();
        let rest = extra.start..extra.end + 1;
        let block = |a: &Range<usize>, b: &Range<usize>| {
            gram.view((a.start, b.start), (a.len(), b.len())).into_owned()
        };
        // Linear terms first: what they take of derivatives and of the rest.
        let inverse = pseudo_inverse(block(&linear, &linear));
        let of = |columns: &Range<usize>| &inverse * block(&linear, columns);
        let (of_derivatives, of_rest) = (of(&derivatives), of(&rest));
        let without = |a: &Range<usize>, b: &Range<usize>, of_b: &DMatrix<f64>| {
            block(a, b) - block(&linear, a).transpose() * of_b
        };
        let coupling = without(&derivatives, &rest, &of_rest);
        let count = fit.parameters.count();
        let mut gradient = DMatrix::zeros(count, rest.len());
        for (row, values) in frame.rows().zip(coupling.row_iter()) {
            gradient.row_mut(row).copy_from(&values);
        }
        let of_coordinates = fit.covariance.inverse();
        let bias = &of_coordinates * &gradient;
        let steps =
            DMatrix::from_rows(&frame.rows().map(|row| bias.row(row).into_owned()).collect::<Vec<_>>());
        let steps = if derivatives.is_empty() { DMatrix::zeros(0, rest.len()) } else { steps };
        let products = without(&rest, &rest, &of_rest) - gradient.transpose() * &bias;
        let mut parts = DMatrix::zeros(frame.size(), rest.len());
        parts.view_mut((rest.start, 0), (rest.len(), rest.len())).fill_with_identity();
        parts.view_mut((derivatives.start, 0), steps.shape()).copy_from(&-&steps);
        let mut own = DMatrix::zeros(frame.size(), derivatives.len());
        own.view_mut((derivatives.start, 0), (derivatives.len(), derivatives.len())).fill_with_identity();
        own.view_mut((0, 0), of_derivatives.shape()).copy_from(&-&of_derivatives);
        let of_all = of_derivatives * steps - of_rest;
        parts.view_mut((0, 0), of_all.shape()).copy_from(&of_all);
        Self {
            products,
            squares: block(&rest, &rest).diagonal(),
            bias,
            parts,
            derivatives: own,
            inverse: of_coordinates,
        }
    }

    /// Number of errors and causes; the residual is the column after them.
    pub(super) fn count(&self) -> usize {
        self.squares.len() - 1
    }

    /// The projected column number `i` as a combination of the frame's columns.
    pub(super) fn column(&self, i: usize) -> DVector<f64> {
        self.parts.column(i).into_owned()
    }

    /// The combination of the projected columns as one of the frame's.
    fn combination(&self, parts: &DVector<f64>) -> DVector<f64> {
        &self.parts * parts
    }

    /// The derivatives without the linear terms, as combinations of the frame's columns.
    pub(super) fn derivatives(&self) -> impl Iterator<Item = DVector<f64>> + '_ {
        self.derivatives.column_iter().map(|parts| parts.into_owned())
    }

    /// What a gradient of the cost along each derivative adds to the coordinates.
    pub(super) fn bias_by(&self, frame: &Frame, along: &[f64]) -> DVector<f64> {
        let mut gradient = DVector::zeros(self.inverse.nrows());
        frame.rows().zip(along).for_each(|(row, value)| gradient[row] += value);
        &self.inverse * gradient
    }

    /// The residual.
    pub(super) fn residual(&self) -> DVector<f64> {
        self.column(self.count())
    }

    /// The residual with all errors and causes taken out.
    pub(super) fn pure_residual(&self) -> DVector<f64> {
        let n = self.count();
        let normal = self.products.view((0, 0), (n, n)).into_owned();
        let scale = self.squares.rows(0, n).map(|s| if s > 0.0 { 1.0 / s.sqrt() } else { 0.0 });
        let scaled = DMatrix::from_diagonal(&scale) * normal * DMatrix::from_diagonal(&scale);
        let right = self.products.view((0, n), (n, 1)).column(0).component_mul(&scale);
        let amplitudes = (pseudo_inverse(scaled) * right).component_mul(&scale);
        let mut parts = DVector::zeros(n + 1);
        parts.rows_mut(0, n).copy_from(&-amplitudes);
        parts[n] = 1.0;
        self.combination(&parts)
    }
}

/// The inverse of a positive matrix where it has one.
pub(super) fn pseudo_inverse(matrix: DMatrix<f64>) -> DMatrix<f64> {
    if matrix.is_empty() {
        return matrix;
    }
    let cut = SINGULAR * matrix.amax();
    let svd = matrix.svd(true, true);
    svd.pseudo_inverse(cut.max(f64::MIN_POSITIVE)).expect("both sets of singular vectors were asked for")
}
