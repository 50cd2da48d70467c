//! Weights of a spread kernel between pixels, in real space.

use super::unit_cells::UnitCells;
use crate::image::Sampling;
use crate::quadrature::nodes;
use crate::spread::SpreadKernel;
use nalgebra::DMatrix;
use std::f64::consts::PI;

/// Weights between pixels by their distance along both axes.
pub(super) enum PixelWeights {
    /// Of pixels over which radiance is constant, by the density of the kernel.
    Pixel(UnitCells),
    /// Of band-limited images, between the middles of pixels: [row, column].
    Bandlimited(DMatrix<f64>),
}

impl PixelWeights {
    /// For offsets below `n` - 1 pixels of `kernel` at `pitch` (length per pixel).
    pub(super) fn new(kernel: &dyn SpreadKernel, pitch: f64, n: usize, sampling: Sampling) -> Self {
        match sampling {
            Sampling::Pixel => Self::Pixel(UnitCells::new(kernel, pitch, n)),
            Sampling::Bandlimited => Self::Bandlimited(bandlimited(kernel, pitch, n)),
        }
    }

    /// Weight between pixels `dx`, `dy` apart.
    pub(super) fn at(&self, dx: usize, dy: usize) -> f64 {
        match self {
            Self::Pixel(cells) => cells.weight(dx, dy),
            Self::Bandlimited(weights) => weights[(dy, dx)],
        }
    }
}

/// The kernel without what lies beyond half a cycle a pixel: (1/pi²) ∫∫ s(|w|) cos(wx dx) cos(wy dy) dwx dwy over 0 to pi.
fn bandlimited(kernel: &dyn SpreadKernel, pitch: f64, n: usize) -> DMatrix<f64> {
    // Panels of half a period of the fastest cosine, finer towards 0, where wide kernels fall.
    let mut frequencies = Vec::new();
    let step = PI / n as f64;
    let mut edge = step;
    while edge > 1e-3 / (kernel.width() / pitch).max(1.0) && edge > 1e-6 {
        frequencies.extend(nodes(0.5 * edge, edge, 1));
        edge *= 0.5;
    }
    frequencies.extend(nodes(0.0, edge, 1));
    frequencies.extend(nodes(step, PI, n - 1));
    let waves = DMatrix::from_fn(n, frequencies.len(), |d, i| {
        let (w, weight) = frequencies[i];
        weight * (w * d as f64).cos() / PI
    });
    let transfer = DMatrix::from_fn(frequencies.len(), frequencies.len(), |i, j| {
        kernel.scattered_transfer(frequencies[i].0.hypot(frequencies[j].0) / pitch).value
    });
    &waves * transfer * waves.transpose()
}
