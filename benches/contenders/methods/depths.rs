//! Polynomials in depth.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Coefficients that the shaders take at most, and have room for.
const MOST_TERMS: usize = 6;
pub const ROOM: usize = 8;

/// A range of path lengths with nodes for a polynomial.
#[derive(Debug, Clone)]
pub struct Depths {
    /// Path length in the middle.
    pub middle: f64,
    /// Half the range.
    pub half_range: f64,
    /// Places of the nodes, -1 to 1.
    nodes: Vec<f64>,
}

impl Depths {
    /// `count` nodes from `near` to `far`, one if they are the same.
    pub fn new(near: f64, far: f64, count: usize) -> Self {
        let count = if far > near { count.min(MOST_TERMS) } else { 1 };
        let node = |i: usize| -(PI * (i as f64 + 0.5) / count as f64).cos();
        let nodes = if count == 1 { vec![0.0] } else { (0..count).map(node).collect() };
        Self { middle: 0.5 * (near + far), half_range: 0.5 * (far - near), nodes }
    }

    /// The largest path length.
    pub fn far(&self) -> f64 {
        self.middle + self.half_range
    }

    /// Number of nodes, and of coefficients.
    pub fn terms(&self) -> usize {
        self.nodes.len()
    }

    /// Path lengths of the nodes.
    pub fn path_lengths(&self) -> impl Iterator<Item = f64> + '_ {
        self.nodes.iter().map(|place| self.middle + self.half_range * place)
    }

    /// Where `z` lies, -1 to 1.
    pub fn place(&self, z: f64) -> f64 {
        if self.half_range > 0.0 { (z - self.middle) / self.half_range } else { 0.0 }
    }

    /// The matrix that turns values at the nodes into coefficients of the powers of the place.
    pub fn to_powers(&self) -> DMatrix<f64> {
        let n = self.terms();
        let powers = DMatrix::from_fn(n, n, |i, k| self.nodes[i].powi(k as i32));
        powers.try_inverse().expect("the nodes are distinct")
    }

    /// Coefficients of the polynomial with these values at the nodes.
    pub fn coefficients(&self, to_powers: &DMatrix<f64>, values: &[f64]) -> Vec<f64> {
        (to_powers * DVector::from_column_slice(values)).as_slice().to_vec()
    }
}

/// Coefficients as the shaders read them.
pub fn padded(coefficients: &[f64]) -> [f32; ROOM] {
    std::array::from_fn(|k| coefficients.get(k).map_or(0.0, |&c| c as f32))
}
