//! The tables behind `wide-angle`: numbers at Chebyshev nodes of tau, sigma_a z and the width of the phase function, one table for each
//! family of phase functions.
//!
//! A file is one line that says how it was made, and then the nodes' numbers, f32, little endian, in the order of
//! [`Layout::places`].

use super::layout::Layout;
use crate::chebyshev::Chebyshev;
use crate::error::{Error, Result};
use crate::spread::Dual;

/// First words of a table's line.
const KIND: &str = "narrowbeam wide-angle table 1;";

/// The interpolated quantities, with derivatives in tau, sigma_a z and the phase-function parameter.
pub(super) struct Interpolated {
    /// ln(W/phi).
    pub total: Dual,
    /// ln(V/W) over the planar width of the phase function.
    pub slope: Dual,
    pub light_roots: Vec<Dual>,
    pub slope_roots: Vec<Dual>,
}

/// A table.
#[derive(Debug, Clone)]
pub struct Table {
    layout: &'static Layout,
    axes: [Chebyshev; 3],
    /// [`Layout::numbers`] of every node.
    values: Vec<f32>,
}

impl Table {
    /// The first line of a table that was made as `how` says.
    pub fn line(how: &str) -> String {
        format!("{KIND} {how}\n")
    }

    /// How the table in `bytes` was made, and the numbers that are there.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn split(bytes: &[u8]) -> std::result::Result<(&str, Vec<f32>), String> {
        let end = bytes.iter().position(|&b| b == b'\n').ok_or("no first line")?;
        let line = std::str::from_utf8(&bytes[..=end]).map_err(|_| "its first line is no text")?;
        if !line.starts_with(KIND) {
            return Err(format!("its first line does not begin with '{KIND}'"));
        }
        let numbers: Vec<f32> =
            bytes[end + 1..].chunks_exact(4).map(|c| f32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect();
        Ok((line, numbers))
    }

    /// The table of this `layout` in the bytes of a file.
    ///
    /// # Errors
    /// [`Error::BadTable`] if they are no complete table.
    pub fn parse(layout: &'static Layout, bytes: &[u8]) -> Result<Self> {
        let (_, values) = Self::split(bytes).map_err(Error::BadTable)?;
        let (found, wanted) = (values.len(), layout.counts.iter().product::<usize>() * layout.numbers());
        if found != wanted {
            return Err(Error::BadTable(format!("{found} numbers of {wanted}")));
        }
        Ok(Self { layout, axes: layout.axes(), values })
    }

    /// The layout.
    pub fn layout(&self) -> &'static Layout {
        self.layout
    }

    /// The numbers for one medium.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] outside the table.
    pub(super) fn at(&self, tau: f64, absorption: f64, parameter: f64) -> Result<Interpolated> {
        let layout = self.layout;
        layout.check(tau, absorption, parameter)?;

        // Coordinates, and their derivatives in tau, sigma_a z and the phase-function parameter.
        let (width, in_parameter) = layout.place(parameter);
        let x = [tau.max(Layout::TAU.0).sqrt(), (2.0 * absorption).ln_1p(), width];
        let in_tau = if tau > Layout::TAU.0 { 0.5 / tau.sqrt() } else { 0.0 };
        let dx = [in_tau, 2.0 / (1.0 + 2.0 * absorption), in_parameter];
        let basis: [Vec<f64>; 3] = std::array::from_fn(|i| self.axes[i].basis(x[i]));
        let slope: [Vec<f64>; 3] =
            std::array::from_fn(|i| self.axes[i].basis_slope(x[i]).into_iter().map(|s| s * dx[i]).collect());
        let numbers = layout.numbers();
        let mut sums = vec![vec![0.0_f64; numbers]; 4];
        let mut nodes = self.values.chunks_exact(numbers);
        for t in 0..layout.counts[0] {
            for a in 0..layout.counts[1] {
                for d in 0..layout.counts[2] {
                    let node = nodes.next().expect("as many nodes as the counts say");
                    let weights = [
                        basis[0][t] * basis[1][a] * basis[2][d],
                        slope[0][t] * basis[1][a] * basis[2][d],
                        basis[0][t] * slope[1][a] * basis[2][d],
                        basis[0][t] * basis[1][a] * slope[2][d],
                    ];
                    for (sum, weight) in sums.iter_mut().zip(weights) {
                        sum.iter_mut().zip(node).for_each(|(s, &v)| *s += weight * f64::from(v));
                    }
                }
            }
        }
        let dual = |i: usize| Dual { value: sums[0][i], gradient: [sums[1][i], sums[2][i], sums[3][i]] };
        let (first, gaussians) = (2, layout.gaussians);
        Ok(Interpolated {
            total: dual(0) * layout.total_scale(parameter),
            slope: dual(1),
            light_roots: (first..first + gaussians).map(dual).collect(),
            slope_roots: (first + gaussians..first + 2 * gaussians).map(dual).collect(),
        })
    }
}
