//! What enters an observation linearly: gain and veil, which take the values that fit a render best.
//!
//! Eliminating them at every step is variable projection (Golub and Pereyra 1973).

use super::Observation;
use crate::forward::{Exposure, Products};
use crate::scene::Gain;
use nalgebra::{DMatrix, DVector};

/// A number that enters the image linearly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LinearTerm {
    /// Light with this [monomial](crate::imaging::monomials) of the place.
    Veil(usize),
    /// Factor on the object's light.
    Gain,
}

/// What remains of a column when those before it are projected out, relative to its square, below which it is flat to
/// rounding.
const FLAT: f64 = 1e-10;

impl LinearTerm {
    /// Those of `observation` that are free, the veil first: what is left of the render beside it must not be flat.
    pub(crate) fn free(observation: &Observation) -> Vec<Self> {
        let veil = (0..observation.veil.free_terms()).map(Self::Veil);
        let gain = (observation.gain == Gain::Free).then_some(Self::Gain);
        veil.chain(gain).collect()
    }

    /// The image that it multiplies, as a combination of the columns of `products`.
    pub(crate) fn column(self, products: &Products) -> DVector<f64> {
        match self {
            Self::Veil(term) => products.veil(term),
            Self::Gain => products.render(),
        }
    }

    fn of(self, exposure: &mut Exposure) -> &mut f64 {
        match self {
            Self::Veil(term) => &mut exposure.veil.0[term],
            Self::Gain => &mut exposure.gain,
        }
    }
}

/// The free linear terms at their best.
#[derive(Debug, Clone)]
pub(crate) struct Linear {
    pub terms: Vec<LinearTerm>,
    pub exposure: Exposure,
    /// Inverse of the terms' normal matrix; NaN if they are not separately identifiable in a flat image.
    pub inverse: DMatrix<f64>,
}

impl Linear {
    /// The free terms of `observation` that fit a render best, by linear least squares from what is `given`.
    pub(crate) fn solve(observation: &Observation, products: &Products, given: Exposure) -> Self {
        let terms = LinearTerm::free(observation);
        let columns: Vec<_> = terms.iter().map(|term| term.column(products)).collect();
        let residual = products.residual(given);
        let normal = DMatrix::from_fn(terms.len(), terms.len(), |i, j| products.of(&columns[i], &columns[j]));
        // Terms that are not separable from those before them keep what is given.
        let separable = (0..=terms.len()).rev().find_map(|n| Some((n, inverse(&normal, n)?)));
        let (n, part) = separable.expect("no terms have an inverse");
        let right = DVector::from_fn(n, |i, _| products.of(&columns[i], &residual));
        let mut exposure = given;
        for (term, change) in terms.iter().zip(&(&part * right)) {
            *term.of(&mut exposure) -= change;
        }
        let whole = n == terms.len();
        let inverse = if whole { part } else { DMatrix::repeat(terms.len(), terms.len(), f64::NAN) };
        Self { terms, exposure, inverse }
    }

    /// Whether the terms are separately identifiable.
    pub(crate) fn is_identifiable(&self) -> bool {
        self.inverse.iter().all(|v| v.is_finite())
    }
}

/// The inverse of the first `n` rows and columns of a normal matrix; `None` if one of the columns is flat beside those before
/// it.
fn inverse(normal: &DMatrix<f64>, n: usize) -> Option<DMatrix<f64>> {
    if n == 0 {
        return Some(DMatrix::zeros(0, 0));
    }
    let cholesky = normal.view((0, 0), (n, n)).into_owned().cholesky()?;
    let left = cholesky.l_dirty().diagonal();
    let is_flat = |i: usize| left[i] * left[i] <= FLAT * normal[(i, i)];
    (!(0..n).any(is_flat)).then(|| cholesky.inverse())
}
