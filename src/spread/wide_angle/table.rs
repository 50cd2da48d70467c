//! The table behind `wide-angle`: numbers at Chebyshev nodes of tau, sigma_a z and the spread angle.
//!
//! A file is one line that says how it was made, and then the nodes' numbers, f32, little endian, in the order of
//! [`Table::places`].

use crate::chebyshev::Chebyshev;
use crate::error::{Error, Result, in_range};
use crate::spread::Dual;

/// Gaussians of the mixture.
pub const RUNGS: usize = 28;
/// Width of the narrowest in units of z sqrt(B): a thousandth of the light scattered once falls within it.
const NARROWEST: f64 = 1e-3;
/// Ratio of neighbouring widths: the ripple of such a ladder is 3e-5 of a smooth mixture (see `filter::ladder`).
const RATIO: f64 = 1.6;

/// Numbers of a node: two logarithms, and the roots of the shares of light and slope.
pub const NUMBERS: usize = 2 + 2 * RUNGS;

/// tau at the ends of the table; below, where all light is scattered once, the shape no longer changes.
pub const TAU: (f64, f64) = (1e-6, 12.0);
/// sigma_a z at the ends of the table.
pub const ABSORPTION: (f64, f64) = (0.0, 10.0);
/// Spread angles at the ends of the table, degrees; below, where angles are small, the shape no longer changes in units
/// of z sqrt(B).
pub const SPREAD_ANGLE_DEG: (f64, f64) = (0.5, 60.0);
/// Nodes of tau, sigma_a z and the spread angle.
const COUNTS: [usize; 3] = [11, 8, 11];

/// First words of a table's line.
const KIND: &str = "narrowbeam wide-angle table 1;";

/// Width of rung `j` in units of z sqrt(B).
pub fn rung(j: usize) -> f64 {
    NARROWEST * RATIO.powi(j as i32)
}

/// What ln(W/phi), which falls like D² from 0, is divided by before it is tabulated at the spread angle `angle` D: lest
/// noise of thick, wide-angle, absorbing media spread to narrow ones. The constant keeps noise of narrow ones there.
pub fn bending(angle: f64) -> f64 {
    angle * angle + 0.07
}

/// A medium at which the table has numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// sigma_s z.
    pub tau: f64,
    /// sigma_a z.
    pub absorption: f64,
    /// sqrt(4B), rad.
    pub spread_angle: f64,
}

/// What is interpolated, with derivatives in tau, sigma_a z and B.
pub(super) struct Interpolated {
    /// ln(W/phi).
    pub total: Dual,
    /// ln(V/W).
    pub slope: Dual,
    pub light_roots: [Dual; RUNGS],
    pub slope_roots: [Dual; RUNGS],
}

/// The table.
#[derive(Debug, Clone)]
pub struct Table {
    axes: [Chebyshev; 3],
    values: Vec<[f32; NUMBERS]>,
}

/// The axes in the coordinates of the interpolation.
fn axes() -> [Chebyshev; 3] {
    let ends = [
        (TAU.0.sqrt(), TAU.1.sqrt()),
        ((2.0 * ABSORPTION.0).ln_1p(), (2.0 * ABSORPTION.1).ln_1p()),
        (SPREAD_ANGLE_DEG.0.to_radians(), SPREAD_ANGLE_DEG.1.to_radians()),
    ];
    std::array::from_fn(|i| Chebyshev::new(COUNTS[i], ends[i].0, ends[i].1))
}

impl Table {
    /// The media of all nodes, in the order of the file.
    pub fn places() -> Vec<Place> {
        let [tau, absorption, angle] = axes();
        let mut places = Vec::new();
        for t in &tau.x {
            for a in &absorption.x {
                places.extend(angle.x.iter().map(|&spread_angle| Place {
                    tau: t * t,
                    absorption: 0.5 * a.exp_m1(),
                    spread_angle,
                }));
            }
        }
        places
    }

    /// The line of a table made so.
    pub fn line(how: &str) -> String {
        format!("{KIND} {how}\n")
    }

    /// How the table in `bytes` was made, and the nodes that are there.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn split(bytes: &[u8]) -> std::result::Result<(&str, Vec<[f32; NUMBERS]>), String> {
        let end = bytes.iter().position(|&b| b == b'\n').ok_or("no first line")?;
        let line = std::str::from_utf8(&bytes[..=end]).map_err(|_| "its first line is no text")?;
        if !line.starts_with(KIND) {
            return Err(format!("its first line does not begin with '{KIND}'"));
        }
        let numbers: Vec<f32> =
            bytes[end + 1..].chunks_exact(4).map(|c| f32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect();
        Ok((line, numbers.as_chunks().0.to_vec()))
    }

    /// The table in the bytes of a file.
    ///
    /// # Errors
    /// [`Error::Usage`] if they are no complete table.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let (_, values) = Self::split(bytes).map_err(|what| Error::Usage(format!("no table: {what}")))?;
        let count: usize = COUNTS.iter().product();
        if values.len() != count {
            return Err(Error::Usage(format!("no table: {} nodes of {count}", values.len())));
        }
        Ok(Self { axes: axes(), values })
    }

    /// The numbers for one medium.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] outside the table.
    pub(super) fn at(&self, tau: f64, absorption: f64, b: f64) -> Result<Interpolated> {
        let spread_angle = (4.0 * b).sqrt();
        let within = |v: f64, high: f64| v >= 0.0 && v <= high * (1.0 + 1e-12);
        let degrees = spread_angle.to_degrees();
        let up_to =
            |what: &str, end: f64, value: f64, allowed| in_range(what, value, within(value, end), allowed);
        up_to(
            "sigma_s z",
            TAU.1,
            tau,
            "between 0 and 12, where the table of model wide-angle ends (--model traced has no end)",
        )?;
        up_to(
            "sigma_a z",
            ABSORPTION.1,
            absorption,
            "between 0 and 10, where the table of model wide-angle ends (--model traced has no end)",
        )?;
        let angle =
            "at most 60 degrees, where the table of model wide-angle ends (--model traced has no end)";
        up_to("spread angle", SPREAD_ANGLE_DEG.1, degrees, angle)?;

        // Coordinates, and their derivatives in tau, sigma_a z and B.
        let narrowest = SPREAD_ANGLE_DEG.0.to_radians();
        let x = [tau.max(TAU.0).sqrt(), (2.0 * absorption).ln_1p(), spread_angle.max(narrowest)];
        let in_tau = if tau > TAU.0 { 0.5 / tau.sqrt() } else { 0.0 };
        let in_b = if spread_angle > narrowest { 2.0 / spread_angle } else { 0.0 };
        let dx = [in_tau, 2.0 / (1.0 + 2.0 * absorption), in_b];
        let basis: [Vec<f64>; 3] = std::array::from_fn(|i| self.axes[i].basis(x[i]));
        let slope: [Vec<f64>; 3] =
            std::array::from_fn(|i| self.axes[i].basis_slope(x[i]).into_iter().map(|s| s * dx[i]).collect());
        let mut sums = [[0.0_f64; NUMBERS]; 4];
        let mut nodes = self.values.iter();
        for t in 0..COUNTS[0] {
            for a in 0..COUNTS[1] {
                for d in 0..COUNTS[2] {
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
        Ok(Interpolated {
            total: dual(0) * Dual { value: bending(spread_angle), gradient: [0.0, 0.0, 4.0] },
            slope: dual(1),
            light_roots: std::array::from_fn(|j| dual(2 + j)),
            slope_roots: std::array::from_fn(|j| dual(2 + RUNGS + j)),
        })
    }
}
