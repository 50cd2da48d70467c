//! Pixel-to-pixel weights of a spread kernel by quadrature of its density in real space.
//!
//! An object pixel and an observed pixel `(dx, dy)` pixels apart exchange
//! w(dx, dy) = ∫∫ psf(|u|) tri(ux - dx) tri(uy - dy) du, tri being the unit triangle, the correlation of two pixels.
//! On each unit cell of the plane tri is linear, so four moments of the density over every cell give all weights.

use crate::quadrature::nodes;
use crate::spread::SpreadKernel;

/// The four moments ∫∫ psf {1, u, v, uv} over the unit cell with its corner at (i, j), for 0 ≤ i, j < n.
pub(super) struct UnitCells {
    n: usize,
    moments: Vec<[f64; 4]>,
}

/// A density in units of pixels, tabulated if it is dear.
struct Density<'a> {
    kernel: &'a dyn SpreadKernel,
    pitch: f64,
    table: Vec<f64>,
}

/// Tabulated range of r / width, and nodes a unit of ln r. Cubic interpolation on this grid is good to 1e-7.
const TABLE: (f64, f64, f64) = (1e-4, 60.0, 40.0);

impl Density<'_> {
    fn new(kernel: &dyn SpreadKernel, pitch: f64) -> Density<'_> {
        let (first, last, per_unit) = TABLE;
        let count = ((last / first).ln() * per_unit).ceil() as usize + 3;
        let r = |i: usize| kernel.width() * first * (i as f64 / per_unit).exp();
        let table = (0..count).map(|i| r(i) * kernel.psf(r(i))).collect();
        Density { kernel, pitch, table }
    }

    /// psf at `r` pixels, per pixel area.
    fn at(&self, r: f64) -> f64 {
        let (first, _, per_unit) = TABLE;
        let r = r * self.pitch;
        let position = (r / (self.kernel.width() * first)).ln() * per_unit;
        let value = if position < 1.0 {
            self.kernel.psf(r)
        } else if position as usize + 2 >= self.table.len() {
            0.0
        } else {
            let i = position as usize;
            let t = position - i as f64;
            let p = &self.table[i - 1..i + 3];
            // Cubic through four neighbours (Lagrange).
            let cubic = -p[0] * t * (t - 1.0) * (t - 2.0) / 6.0
                + p[1] * (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0
                - p[2] * (t + 1.0) * t * (t - 2.0) / 2.0
                + p[3] * (t + 1.0) * t * (t - 1.0) / 6.0;
            cubic / r
        };
        value * self.pitch * self.pitch
    }
}

impl UnitCells {
    /// Moments for offsets below `n` - 1 pixels of `kernel` at `pitch` (length per pixel).
    pub(super) fn new(kernel: &dyn SpreadKernel, pitch: f64, n: usize) -> Self {
        let mut moments = vec![[0.0; 4]; n * n];
        if kernel.scattered() > 0.0 {
            let density = Density::new(kernel, pitch);
            let width_px = kernel.width() / pitch;
            for j in 0..n {
                for i in 0..=j {
                    let m = if j == 0 {
                        corner_cell(&density, width_px)
                    } else {
                        plain_cell(&density, width_px, i as f64, j as f64)
                    };
                    moments[j * n + i] = m;
                    moments[i * n + j] = [m[0], m[2], m[1], m[3]];
                }
            }
        }
        Self { n, moments }
    }

    /// Weight between pixels `dx`, `dy` apart.
    pub(super) fn weight(&self, dx: usize, dy: usize) -> f64 {
        // The triangle rises over cell d - 1 as u and falls over cell d as 1 - u; cell -1 is cell 0 mirrored.
        let along = |d: usize| if d == 0 { [(0, false), (0, false)] } else { [(d - 1, true), (d, false)] };
        let mut sum = 0.0;
        for (i, x_rises) in along(dx) {
            for (j, y_rises) in along(dy) {
                let [one, u, v, uv] = self.moments[j * self.n + i];
                sum += match (x_rises, y_rises) {
                    (true, true) => uv,
                    (true, false) => u - uv,
                    (false, true) => v - uv,
                    (false, false) => one - u - v + uv,
                };
            }
        }
        sum
    }
}

/// Moments over a cell away from the origin, on panels finer than the kernel.
fn plain_cell(density: &Density, width_px: f64, i: f64, j: f64) -> [f64; 4] {
    let panels = (0.5 / width_px).ceil().clamp(1.0, 64.0) as usize;
    let line = nodes(0.0, 1.0, panels);
    let mut m = [0.0; 4];
    for &(v, weight_v) in &line {
        for &(u, weight_u) in &line {
            let p = weight_u * weight_v * density.at((i + u).hypot(j + v));
            m = [m[0] + p, m[1] + p * u, m[2] + p * v, m[3] + p * u * v];
        }
    }
    m
}

/// Moments over the cell that touches the origin, where the density grows like 1/r: two triangles, each mapped by
/// u = t, v = t s (Duffy), whose Jacobian t takes the singularity away; panels shrink towards the origin.
fn corner_cell(density: &Density, width_px: f64) -> [f64; 4] {
    let mut m = [0.0; 4];
    let finest = (1e-3 * width_px.min(1.0)).max(1e-6);
    let mut right = 1.0;
    while right > finest {
        let left = if right < 2.0 * finest { 0.0 } else { 0.5 * right };
        for (t, weight_t) in nodes(left, right, 1) {
            for (s, weight_s) in nodes(0.0, 1.0, 1) {
                let p = weight_t * weight_s * t * density.at(t * 1.0_f64.hypot(s));
                // The triangle v < u and its mirror image.
                let (u, v) = (t, t * s);
                m = [m[0] + 2.0 * p, m[1] + p * (u + v), m[2] + p * (u + v), m[3] + 2.0 * p * u * v];
            }
        }
        right = left;
    }
    m
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::Medium;
    use crate::spread::Model;

    #[test]
    fn weights_of_all_offsets_add_up_to_the_scattered_light() {
        let medium = Medium::gaussian(1.0, 0.1, 0.004).unwrap();
        for model in [Model::SingleScatter, Model::Gaussian, Model::NarrowBeam, Model::SmallAngle] {
            for width_px in [0.02, 0.3, 1.0, 4.0] {
                let kernel = model.kernel(&medium, 1.5).unwrap();
                let n = (14.0 * width_px) as usize + 4;
                let cells = UnitCells::new(&*kernel, kernel.width() / width_px, n);
                let fold = |d: usize| if d == 0 { 1.0 } else { 2.0 };
                let offsets = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (x, y)));
                let sum: f64 = offsets.map(|(x, y)| fold(x) * fold(y) * cells.weight(x, y)).sum();
                let error = sum / kernel.scattered() - 1.0;
                assert!(error.abs() < 1e-6, "{model} {width_px} px: {error:.1e}");
            }
        }
    }
}
