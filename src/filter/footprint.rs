//! The pixel's footprint in the frequency domain.
//!
//! With s(w) = M(w/pitch) - T and w in rad/px, the weights between pixels have the transform
//! `s̃(wx, wy) = sum_{m,n} s(|w + 2 pi (m, n)|) sinc²((wx + 2 pi m)/2) sinc²((wy + 2 pi n)/2)`, sinc x = sin x / x:
//! sampling a kernel averaged over two pixels. s falls only like 1/w, so the aliases count: without them a kernel
//! of one pixel's width biases sigma_s by 10 %.

use crate::spread::{Dual, SpreadKernel};
use std::f64::consts::PI;

/// sinc²((w + 2 pi m)/2).
pub fn sinc2(w: f64, m: i32) -> f64 {
    let x = 0.5 * w + PI * f64::from(m);
    if x.abs() < 1e-8 {
        1.0
    } else {
        let s = (0.5 * w).sin() / x;
        s * s
    }
}

/// s(|w|) and its derivatives for a kernel seen at `pitch` (length per pixel).
fn at(kernel: &dyn SpreadKernel, pitch: f64, wx: f64, wy: f64) -> Dual {
    kernel.scattered_transfer(wx.hypot(wy) / pitch)
}

fn add(sum: &mut Dual, weight: f64, term: Dual) {
    sum.value += weight * term.value;
    for (s, t) in sum.gradient.iter_mut().zip(term.gradient) {
        *s += weight * t;
    }
}

/// The aliases (m, n) ≠ (0, 0) of s̃ at (`wx`, `wy`) rad/px, those up to `reach` one by one.
///
/// The squared sincs of all aliases add up to 1. What is left for those beyond `reach` is given to s in rings that
/// grow by a factor q: weights that fall like 1/m² leave 1 - 1/q of the rest to the first ring, and so on; s at
/// 2q/(1+q) times its near edge stands for a ring, which is exact where s is constant and where it falls like 1/w.
pub fn aliases(kernel: &dyn SpreadKernel, pitch: f64, wx: f64, wy: f64, reach: i32) -> Dual {
    let mut sum = Dual::default();
    let mut left = 1.0 - sinc2(wx, 0) * sinc2(wy, 0);
    for n in -reach..=reach {
        for m in -reach..=reach {
            let weight = sinc2(wx, m) * sinc2(wy, n);
            if (m, n) != (0, 0) && weight > 0.0 {
                let (ax, ay) = (wx + 2.0 * PI * f64::from(m), wy + 2.0 * PI * f64::from(n));
                add(&mut sum, weight, at(kernel, pitch, ax, ay));
                left -= weight;
            }
        }
    }
    let mut edge = 2.0 * PI * (f64::from(reach) + 0.5);
    for _ in 0..RINGS {
        let share = (1.0 - 1.0 / RING_GROWTH) * left;
        add(&mut sum, share, at(kernel, pitch, edge * 2.0 * RING_GROWTH / (1.0 + RING_GROWTH), 0.0));
        left -= share;
        edge *= RING_GROWTH;
    }
    add(&mut sum, left, at(kernel, pitch, edge, 0.0));
    sum
}

/// Rings of aliases beyond those summed one by one, and the ratio of their edges: seven octaves in thirds.
const RINGS: usize = 21;
const RING_GROWTH: f64 = 1.259_921;

/// s̃ at (`wx`, `wy`) rad/px without its aliases: s sinc² sinc².
pub fn baseband(kernel: &dyn SpreadKernel, pitch: f64, wx: f64, wy: f64) -> Dual {
    let mut sum = Dual::default();
    add(&mut sum, sinc2(wx, 0) * sinc2(wy, 0), at(kernel, pitch, wx, wy));
    sum
}

/// Nodes a side at which the aliases are computed; between them they are interpolated.
const NODES: usize = 8;
/// Aliases summed one by one on each side of the baseband.
const REACH: i32 = 6;

/// The alias part of s̃ for one kernel, interpolated over 0 ≤ wx, wy ≤ pi.
///
/// The nearest singularity of the alias sum lies at 2 pi, three half-widths from the middle of the interval, so
/// Chebyshev interpolation converges like (3 + sqrt 8)^-n: 8 nodes leave 1e-6 of a part that is itself small.
pub struct AliasTable {
    /// Chebyshev-node values, [component][node of wy][node of wx].
    values: [[[f64; NODES]; NODES]; 4],
}

impl AliasTable {
    /// Computes the nodes for `kernel` seen at `pitch` (length per pixel).
    pub fn new(kernel: &dyn SpreadKernel, pitch: f64) -> Self {
        let nodes = Chebyshev::new(NODES, 0.0, PI);
        let mut values = [[[0.0; NODES]; NODES]; 4];
        for j in 0..NODES {
            for i in 0..=j {
                let a = aliases(kernel, pitch, nodes.x[i], nodes.x[j], REACH);
                for (c, v) in [a.value, a.gradient[0], a.gradient[1], a.gradient[2]].into_iter().enumerate() {
                    values[c][j][i] = v;
                    values[c][i][j] = v;
                }
            }
        }
        Self { values }
    }

    /// The table along one line of constant wy, whose basis values are `basis_y`.
    pub fn row(&self, basis_y: &[f64; NODES]) -> AliasRow {
        let mut row = [[0.0; NODES]; 4];
        for (out, table) in row.iter_mut().zip(&self.values) {
            for (weight, line) in basis_y.iter().zip(table) {
                for (o, v) in out.iter_mut().zip(line) {
                    *o += weight * v;
                }
            }
        }
        AliasRow { row }
    }

    /// Basis values at the frequencies 2 pi i / `n`, i = 0..=n/2.
    pub fn basis(n: usize) -> Vec<[f64; NODES]> {
        let nodes = Chebyshev::new(NODES, 0.0, PI);
        (0..=n / 2)
            .map(|i| {
                let weights = nodes.basis(2.0 * PI * i as f64 / n as f64);
                weights.try_into().expect("as many weights as nodes")
            })
            .collect()
    }
}

/// An [`AliasTable`] along one line.
pub struct AliasRow {
    row: [[f64; NODES]; 4],
}

impl AliasRow {
    /// Value and derivatives where the basis along x is `basis_x`.
    pub fn at(&self, basis_x: &[f64; NODES]) -> [f64; 4] {
        std::array::from_fn(|c| self.row[c].iter().zip(basis_x).map(|(v, b)| v * b).sum())
    }
}

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

    /// Weight of each node's value in the interpolant at `x`; they add up to 1.
    pub fn basis(&self, x: f64) -> Vec<f64> {
        let last = self.x.len() - 1;
        if let Some(hit) = self.x.iter().position(|&node| node == x) {
            return (0..=last).map(|i| f64::from(u8::from(i == hit))).collect();
        }
        let weight = |i: usize| {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            let end = if last > 0 && (i == 0 || i == last) { 0.5 } else { 1.0 };
            sign * end / (x - self.x[i])
        };
        let raw: Vec<f64> = (0..=last).map(weight).collect();
        let sum: f64 = raw.iter().sum();
        raw.into_iter().map(|w| w / sum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Medium;
    use crate::phase::Gaussian;
    use crate::spread::Model;

    #[test]
    fn squared_sincs_of_all_aliases_add_up_to_one() {
        for w in [0.3, 2.0, PI] {
            let sum: f64 = (-4000..=4000).map(|m| sinc2(w, m)).sum();
            // The tail beyond reach n is at most 2 / (pi² n).
            assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        }
    }

    #[test]
    fn interpolated_aliases_equal_a_long_sum_of_them() {
        let medium = Medium::new(1.0, 0.1).unwrap();
        let phase = Gaussian::new(0.004).unwrap();
        for width_px in [0.03, 0.3, 1.0, 4.0, 30.0] {
            let kernel = Model::SmallAngle.kernel(&medium, &phase, 1.5).unwrap();
            let pitch = kernel.width() / width_px;
            let table = AliasTable::new(&*kernel, pitch);
            let basis = AliasTable::basis(14);
            let mut worst: f64 = 0.0;
            for (j, by) in basis.iter().enumerate() {
                let row = table.row(by);
                for (i, bx) in basis.iter().enumerate() {
                    let (wx, wy) = (2.0 * PI * i as f64 / 14.0, 2.0 * PI * j as f64 / 14.0);
                    let long = aliases(&*kernel, pitch, wx, wy, 150).value;
                    worst = worst.max((row.at(bx)[0] - long).abs() / kernel.scattered());
                }
            }
            println!("kernel width {width_px} px: aliases off by {worst:.1e} of the scattered light");
            // The reach leaves 7 % of the weights to the rings, which stand for a smooth sum to a few permille
            // (second order in the rings' width and in 1/reach); wider kernels have no light out there.
            assert!(worst < if width_px < 0.1 { 2e-4 } else { 2e-5 }, "{width_px}: {worst}");
        }
    }
}
