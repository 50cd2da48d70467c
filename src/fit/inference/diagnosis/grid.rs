//! Values of the pixels that count as an image, and how neighbours go together.

use super::frame::Frame;
use rayon::prelude::*;

/// Lags along either axis up to which noise may be correlated, px.
pub(super) const REACH: i64 = 3;

/// Autocorrelation at one lag.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lag {
    /// Across and down, px.
    pub by: [i64; 2],
    pub correlation: f64,
    /// Number of pairs of pixels.
    pub pairs: f64,
}

/// Values of the pixels that count, on the view.
pub(super) struct Grid {
    values: Vec<f64>,
    counts: Vec<bool>,
    width: usize,
}

impl Grid {
    pub(super) fn new(frame: &Frame, values: &[f64]) -> Self {
        let observed = frame.observed();
        let image = observed.observation.observed;
        let (mut grid, mut counts) = (vec![0.0; image.data.len()], vec![false; image.data.len()]);
        for (pixel, value) in observed.counted().iter().zip(values) {
            let i = pixel.index as usize;
            (grid[i], counts[i]) = (*value, true);
        }
        Self { values: grid, counts, width: image.width }
    }

    /// Sum of the products of these pixels with those of `other` that lie at a lag from them, and their number.
    pub(super) fn products(&self, other: &Self, [across, down]: [i64; 2]) -> (f64, f64) {
        let (width, height) = (self.width as i64, (self.values.len() / self.width) as i64);
        let row = |y: i64| {
            let (mut sum, mut number) = (0.0, 0.0);
            for x in (-across).max(0)..width - across.max(0) {
                let (a, b) = ((y * width + x) as usize, ((y + down) * width + x + across) as usize);
                if self.counts[a] && self.counts[b] {
                    sum += self.values[a] * other.values[b];
                    number += 1.0;
                }
            }
            (sum, number)
        };
        let rows: Vec<(f64, f64)> = (0..(height - down).max(0)).into_par_iter().map(row).collect();
        rows.into_iter().fold((0.0, 0.0), |(sum, number), (s, n)| (sum + s, number + n))
    }

    /// Autocorrelation at each lag of half the plane.
    pub(super) fn correlation(&self) -> Vec<Lag> {
        let (square, all) = self.products(self, [0, 0]);
        let lags = (0..=REACH).flat_map(|y| (-REACH..=REACH).map(move |x| [x, y]));
        let half = lags.filter(|[x, y]| *y > 0 || *x > 0);
        let at = |by: [i64; 2]| {
            let (sum, pairs) = self.products(self, by);
            let known = pairs > 0.0 && square > 0.0;
            Lag { by, pairs, correlation: if known { sum / pairs / (square / all) } else { 0.0 } }
        };
        half.map(at).collect()
    }
}
