//! A slice's transfer function made cheap: tables of which the fast path reads a few numbers a frequency.
//!
//! The baseband part of s̃ depends on |w| alone and is tabulated along it; the alias part is smooth over the whole
//! baseband and is interpolated from a few nodes.

use super::footprint::aliases;
use crate::chebyshev::Chebyshev;
use crate::spread::{Dual, SpreadKernel};
use std::f64::consts::PI;

/// Nodes a side at which the aliases are computed; between them they are interpolated.
const NODES: usize = 8;
/// Aliases summed one by one on each side of the baseband.
const REACH: i32 = 6;

/// Weights of the nodes along one axis at one frequency.
pub type Basis = [f32; NODES];

/// Value and derivatives in sigma_s, sigma_a, B, side by side for the fast path.
pub type Lanes = [f32; 4];

/// Side by side, in f32.
pub fn lanes(d: &Dual) -> Lanes {
    [d.value as f32, d.gradient[0] as f32, d.gradient[1] as f32, d.gradient[2] as f32]
}

/// The alias part of s̃ for one kernel, interpolated over 0 ≤ wx, wy ≤ pi.
///
/// The nearest singularity of the alias sum lies at 2 pi, three half-widths from the middle of the interval, so
/// Chebyshev interpolation converges like (3 + sqrt 8)^-n: 8 nodes leave 1e-6 of a part that is itself small.
pub struct AliasTable {
    /// Values at the nodes, [node of wx][node of wy].
    values: [[Lanes; NODES]; NODES],
}

impl AliasTable {
    /// Computes the nodes for `kernel` seen at `pitch` (length per pixel), in units of `scale`.
    pub fn new(kernel: &dyn SpreadKernel, pitch: f64, scale: f64) -> Self {
        let nodes = Chebyshev::new(NODES, 0.0, PI);
        // Symmetric in wx and wy: the upper half is computed and mirrored.
        let mut values = [[[0.0; 4]; NODES]; NODES];
        for (j, &wy) in nodes.x.iter().enumerate() {
            for (i, &wx) in nodes.x.iter().enumerate().take(j + 1) {
                values[j][i] = lanes(&(1.0 / scale * aliases(kernel, pitch, wx, wy, REACH)));
                values[i][j] = values[j][i];
            }
        }
        Self { values }
    }

    /// The table of images that have no aliases.
    pub fn none() -> Self {
        Self { values: [[[0.0; 4]; NODES]; NODES] }
    }

    /// The table along the line of constant wx whose basis values are `basis_x`.
    pub fn line(&self, basis_x: &Basis) -> AliasLine {
        let mut line = [[0.0; 4]; NODES];
        for (weight, values) in basis_x.iter().zip(&self.values) {
            for (sum, value) in line.iter_mut().zip(values) {
                accumulate(sum, *weight, value);
            }
        }
        AliasLine { line }
    }

    /// The values at the nodes, [node of wx][node of wy].
    #[cfg(feature = "gpu")]
    pub fn values(&self) -> &[[Lanes; NODES]; NODES] {
        &self.values
    }

    /// Basis values at the frequencies 2 pi i / `n`, i = 0..=n/2.
    pub fn basis(n: usize) -> Vec<Basis> {
        let nodes = Chebyshev::new(NODES, 0.0, PI);
        let at = |i: usize| {
            let weights = nodes.basis(2.0 * PI * i as f64 / n as f64);
            std::array::from_fn(|node| weights[node] as f32)
        };
        (0..=n / 2).map(at).collect()
    }
}

/// An [`AliasTable`] along one line.
pub struct AliasLine {
    line: [Lanes; NODES],
}

impl AliasLine {
    /// The alias part where the basis along y is `basis_y`.
    pub fn at(&self, basis_y: &Basis) -> Lanes {
        let mut sum = [0.0; 4];
        for (weight, value) in basis_y.iter().zip(&self.line) {
            accumulate(&mut sum, *weight, value);
        }
        sum
    }
}

fn accumulate(sum: &mut Lanes, weight: f32, value: &Lanes) {
    for (s, v) in sum.iter_mut().zip(value) {
        *s += weight * v;
    }
}

/// A function of |w| that varies as a kernel does, tabulated over 0 ≤ |w| ≤ sqrt(2) pi and interpolated by cubics through four
/// neighbours.
pub struct RadialTable {
    per_w: f64,
    /// The first entry lies one step before 0, where s, being even, equals the second after it.
    values: Vec<Lanes>,
}

/// Step of the table in units of 1 / width for thin media; a cubic's error there is 2e-7 of the scattered light.
const STEP: f64 = 0.04;
/// Fewest and most entries.
const ENTRIES: (f64, f64) = (256.0, 65536.0);

impl RadialTable {
    /// The table of `f`, which varies with w (rad/px) as does `kernel` seen at `pitch` (length per pixel).
    pub fn new(kernel: &dyn SpreadKernel, pitch: f64, f: impl Fn(f64) -> Dual) -> Self {
        let end = 2.0_f64.sqrt() * PI;
        // exp(tau F) is narrower than F by the root of tau.
        let step = STEP / (1.0 + 0.2 * kernel.medium().tau(kernel.path_length())).sqrt();
        let count = (end * kernel.width() / pitch / step).clamp(ENTRIES.0, ENTRIES.1).ceil();
        let per_w = count / end;
        let entry = |i: i64| lanes(&f(i.abs() as f64 / per_w));
        Self { per_w, values: (-1..=count as i64 + 2).map(entry).collect() }
    }

    /// Entries per rad/px.
    #[cfg(feature = "gpu")]
    pub fn per_w(&self) -> f64 {
        self.per_w
    }

    /// The entries, the first of which lies one step before 0.
    #[cfg(feature = "gpu")]
    pub fn values(&self) -> &[Lanes] {
        &self.values
    }

    /// f at |w| = `w` rad/px.
    pub fn at(&self, w: f64) -> Lanes {
        let position = w * self.per_w;
        let i = position as usize;
        let t = (position - i as f64) as f32;
        let weights = [
            -t * (t - 1.0) * (t - 2.0) / 6.0,
            (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0,
            -(t + 1.0) * t * (t - 2.0) / 2.0,
            (t + 1.0) * t * (t - 1.0) / 6.0,
        ];
        let mut sum = [0.0; 4];
        for (weight, value) in weights.iter().zip(&self.values[i..i + 4]) {
            accumulate(&mut sum, *weight, value);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Medium;
    use crate::spread::Model;

    #[test]
    fn interpolated_aliases_equal_a_long_sum_of_them() {
        let medium = Medium::gaussian(1.0, 0.1, 0.004).unwrap();
        for width_px in [0.03, 0.3, 1.0, 4.0, 30.0] {
            let kernel = Model::SmallAngle.kernel(&medium, 1.5).unwrap();
            let pitch = kernel.width() / width_px;
            let table = AliasTable::new(&*kernel, pitch, 1.0);
            let basis = AliasTable::basis(14);
            let mut worst: f64 = 0.0;
            for (i, bx) in basis.iter().enumerate() {
                let line = table.line(bx);
                for (j, by) in basis.iter().enumerate() {
                    let (wx, wy) = (2.0 * PI * i as f64 / 14.0, 2.0 * PI * j as f64 / 14.0);
                    let long = aliases(&*kernel, pitch, wx, wy, 150).value;
                    worst = worst.max((f64::from(line.at(by)[0]) - long).abs() / kernel.scattered());
                }
            }
            println!("kernel width {width_px} px: aliases off by {worst:.1e} of the scattered light");
            // The reach leaves 7 % of the weights to the rings, which stand for a smooth sum to a few permille
            // (second order in the rings' width and in 1/reach); wider kernels have no light out there.
            assert!(worst < if width_px < 0.1 { 2e-4 } else { 2e-5 }, "{width_px}: {worst}");
        }
    }

    #[test]
    fn the_radial_table_equals_the_transfer_function() {
        for tau in [0.1, 1.0, 8.0] {
            for model in [Model::SingleScatter, Model::Gaussian, Model::NarrowBeamPrinted, Model::SmallAngle]
            {
                for width_px in [0.03, 1.0, 40.0, 300.0] {
                    let medium = Medium::gaussian(tau / 1.5, 0.1, 0.004).unwrap();
                    let kernel = model.kernel(&medium, 1.5).unwrap();
                    let pitch = kernel.width() / width_px;
                    let table = RadialTable::new(&*kernel, pitch, |w| kernel.scattered_transfer(w / pitch));
                    for i in 0..2000 {
                        let w = 4.44 * (f64::from(i) / 2000.0).powi(3);
                        let exact = kernel.scattered_transfer(w / pitch);
                        let found = table.at(w);
                        let whole = kernel.scattered_transfer(0.0);
                        // Cubic interpolation at this step, and f32; derivatives in B have no value at 0 to be
                        // relative to: B d/dB is of the order of the scattered light.
                        let off = (f64::from(found[0]) - exact.value).abs() / whole.value;
                        let off_b = (f64::from(found[3]) - exact.gradient[2]).abs() * 0.004 / whole.value;
                        assert!(off < 2e-6 && off_b < 1e-5, "{model} {tau} {width_px} {w}: {off} {off_b}");
                    }
                }
            }
        }
    }
}
