//! Normal equations of least squares over all parameters, summed in f64.
//!
//! What enters the image linearly and is free is taken out of the Gauss-Newton matrix by the Schur complement (variable
//! projection in Kaufman's form, 1975); what belongs to it is kept for its errors.

use crate::fit::observation::{Linear, Observed};
use crate::fit::parameters::{Id, Parameters};
use crate::forward::Products;
use nalgebra::{DMatrix, DVector};

/// What enters one scene linearly, at its best, and what is needed for its errors.
#[derive(Debug, Clone)]
pub(crate) struct Eliminated {
    pub linear: Linear,
    pub chi2: f64,
    /// Covariance of the linear terms at given parameters; NaN if they are not separately identifiable.
    pub covariance: DMatrix<f64>,
    /// Change of the linear terms with the coordinates.
    pub coupling: DMatrix<f64>,
}

/// Cost ½ chi², its gradient and Gauss-Newton matrix in the solver's coordinates.
#[derive(Debug, Clone)]
pub(crate) struct NormalEquations {
    pub cost: f64,
    /// Pixels, and the observation's sum of squares over noise²: what a change of cost is measured against.
    pub pixels: usize,
    pub signal: f64,
    pub gradient: DVector<f64>,
    /// With the linear terms eliminated.
    pub matrix: DMatrix<f64>,
    /// Diagonal before they were: the scale against which a direction counts as lost.
    pub diagonal: DVector<f64>,
    pub scenes: Vec<Eliminated>,
}

/// A decrease of chi² by this times its expectation a pixel moves the estimate by a hundredth of a standard error.
const SETTLED: f64 = 1e-4;
/// Renders are f32: their pixels are rounded by this share, root mean square.
const ROUNDING: f64 = 3e-8;

impl NormalEquations {
    /// Equations without data, of `count` parameters.
    pub(crate) fn empty(count: usize) -> Self {
        Self {
            cost: 0.0,
            pixels: 0,
            signal: 0.0,
            gradient: DVector::zeros(count),
            matrix: DMatrix::zeros(count, count),
            diagonal: DVector::zeros(count),
            scenes: Vec::new(),
        }
    }

    /// Adds scene number `scene`, `observed`, from the `products` of what was rendered at `parameters`.
    pub(crate) fn add(
        &mut self,
        scene: usize,
        observed: &Observed,
        products: &Products,
        parameters: &Parameters,
    ) {
        let linear = observed.linear(products);
        let residual = products.residual(linear.exposure);
        let square = products.of(&residual, &residual);
        let (chain, rows) = (parameters.chain(), rows(scene, products, parameters));
        let slopes = DVector::from_iterator(rows.len(), rows.iter().map(|id| chain[id.row()]));
        let scale = slopes * linear.exposure.gain;
        let w = observed.precision();
        // The residual is already orthogonal to free linear terms, so the gradient needs no correction.
        let gradient = products.with_derivatives(&residual).component_mul(&scale) * w;
        let scaling = DMatrix::from_diagonal(&scale);
        let direct = &scaling * products.of_derivatives() * &scaling * w;

        let columns = linear
            .terms
            .iter()
            .map(|term| products.with_derivatives(&term.column(products)).component_mul(&scale).transpose());
        let terms = linear.terms.len();
        let mut across = DMatrix::zeros(terms, rows.len());
        across.row_iter_mut().zip(columns).for_each(|(mut row, column)| row.copy_from(&column));
        let projection =
            if linear.is_identifiable() { linear.inverse.clone() } else { DMatrix::zeros(terms, terms) };
        let coupling = -(&projection * &across);
        let matrix = &direct + across.transpose() * &coupling * w;

        let y = products.observation();
        self.cost += 0.5 * square * w;
        self.pixels += observed.count();
        self.signal += products.of(&y, &y) * w;
        let mut spread = DMatrix::zeros(terms, self.gradient.len());
        for (i, id) in rows.iter().enumerate() {
            self.gradient[id.row()] += gradient[i];
            self.diagonal[id.row()] += direct[(i, i)];
            spread.column_mut(id.row()).copy_from(&coupling.column(i));
            for (j, other) in rows.iter().enumerate() {
                self.matrix[(id.row(), other.row())] += matrix[(i, j)];
            }
        }
        let covariance = &linear.inverse / w;
        self.scenes.push(Eliminated { linear, chi2: square * w, covariance, coupling: spread });
    }

    /// The decrease of the cost that no longer matters, or that rounding hides: the sum of r²/2 over pixels with errors e
    /// is off by that of r e, about |r| |e| / √pixels, and by that of e².
    pub(crate) fn negligible(&self) -> f64 {
        let (pixels, rounding) = (self.pixels as f64, ROUNDING * self.signal.sqrt());
        let mean_cost = self.cost.max(0.0) / pixels;
        SETTLED * mean_cost + rounding * (2.0 * mean_cost).sqrt() + rounding * rounding
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.cost.is_finite() && self.gradient.iter().chain(self.matrix.iter()).all(|v| v.is_finite())
    }
}

/// The parameter behind each derivative of `products`.
fn rows(scene: usize, products: &Products, parameters: &Parameters) -> Vec<Id> {
    let moving = |&quantity| parameters.moving(quantity, scene);
    products.derivatives().iter().map(|q| moving(q).expect("a derivative is that of a parameter")).collect()
}
