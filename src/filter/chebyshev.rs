//! Polynomial interpolation on Chebyshev nodes.

use std::f64::consts::PI;

/// Chebyshev points of the second kind on an interval, with the barycentric Lagrange basis on them
/// (Berrut and Trefethen 2004).
#[derive(Debug, Clone)]
pub struct Chebyshev {
    /// The nodes, increasing.
    pub x: Vec<f64>,
}

impl Chebyshev {
    /// `n` ≥ 1 nodes on [`a`, `b`]; a single one lies in the middle.
    pub fn new(n: usize, a: f64, b: f64) -> Self {
        let node = |i: usize| {
            let c = if n == 1 { 0.0 } else { -(PI * i as f64 / (n - 1) as f64).cos() };
            0.5 * (a + b) + 0.5 * (b - a) * c
        };
        Self { x: (0..n).map(node).collect() }
    }

    /// Where `x` lies on [-1, 1], from the first node to the last; 0 if there is but one.
    pub fn place(&self, x: f64) -> f64 {
        let (first, last) = (self.x[0], self.x[self.x.len() - 1]);
        if first == last { 0.0 } else { (2.0 * x - first - last) / (last - first) }
    }

    /// Weight of each node's value in the interpolant at `x`; they add up to 1.
    pub fn basis(&self, x: f64) -> Vec<f64> {
        let last = self.x.len() - 1;
        if let Some(hit) = self.x.iter().position(|&node| node == x) {
            return (0..=last).map(|i| f64::from(u8::from(i == hit))).collect();
        }
        let weight = |i: usize| {
            let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            let end = if last > 0 && (i == 0 || i == last) { 0.5 } else { 1.0 };
            sign * end / (x - self.x[i])
        };
        let raw: Vec<f64> = (0..=last).map(weight).collect();
        let sum: f64 = raw.iter().sum();
        raw.into_iter().map(|w| w / sum).collect()
    }
}
