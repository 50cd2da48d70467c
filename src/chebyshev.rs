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

    /// Where `x` lies on [-1, 1], from the first node to the last; 0 if there is only one.
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

    /// Derivatives of the [`basis`](Self::basis) in `x`; they add up to 0.
    pub fn basis_slope(&self, x: f64) -> Vec<f64> {
        let others = |i: usize| (0..self.x.len()).filter(move |&j| j != i);
        let factor = |i: usize, j: usize| (x - self.x[j]) / (self.x[i] - self.x[j]);
        let without =
            |i: usize, j: usize| others(i).filter(|&k| k != j).map(|k| factor(i, k)).product::<f64>();
        let slope = |i: usize| others(i).map(|j| without(i, j) / (self.x[i] - self.x[j])).sum();
        (0..self.x.len()).map(slope).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_the_basis_is_its_derivative() {
        let nodes = Chebyshev::new(7, -0.5, 2.0);
        // At a node, between nodes, and at an end; a polynomial of degree 6 has differences exact to step².
        for x in [nodes.x[2], 0.3, 2.0] {
            let step = 1e-5;
            let (up, down) = (nodes.basis(x + step), nodes.basis(x - step));
            for (i, slope) in nodes.basis_slope(x).into_iter().enumerate() {
                let difference = (up[i] - down[i]) / (2.0 * step);
                assert!((slope - difference).abs() < 1e-6, "{x} {i}: {slope} {difference}");
            }
        }
    }
}
