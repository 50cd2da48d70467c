//! The noise of one scene, from its residual with all that was fitted, and all that may be wrong, taken out.

use super::anomalies::Anomalies;
use super::cause::Cause;
use super::finding::Finding;
use super::frame::Frame;
use super::projected::Projected;
use rayon::prelude::*;

/// Lags along either axis up to which noise may be correlated, px.
const REACH: i64 = 3;

/// What the residual is like from pixel to pixel, in units of the noise that the fit assumed.
#[derive(Debug)]
pub(in crate::fit::inference) struct Noise {
    /// Variance.
    pub variance: f64,
    /// Autocorrelation at each lag of half the plane; empty if the noise is white.
    correlation: Vec<Lag>,
    findings: Vec<Finding>,
}

/// Autocorrelation at one lag.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lag {
    /// Across and down, px.
    pub by: [i64; 2],
    pub correlation: f64,
    /// Number of pairs of pixels.
    pub pairs: f64,
}

impl Noise {
    /// That of the scene of `frame`, number `scene`.
    pub(super) fn new(frame: &Frame, projected: &Projected, scene: usize) -> Self {
        let residual = frame.combination(&projected.pure_residual());
        let freedom = (residual.len() as f64 - frame.size() as f64).max(1.0);
        let variance = residual.iter().map(|r| r * r).sum::<f64>() / freedom;
        let variance = variance.max(frame.rounding());
        let mut correlation = Grid::new(frame, &residual).correlation();
        let anomalies = Anomalies { frame, projected, residual: &residual, variance, scene };
        let findings = anomalies.findings(&correlation);
        if !findings.iter().any(|finding| finding.cause == Cause::CorrelatedNoise) {
            correlation.clear();
        }
        Self { variance, correlation, findings }
    }

    /// What is unlike white noise of the stated level.
    pub(super) fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// Whether neighbours share none of it.
    pub(super) fn is_white(&self) -> bool {
        self.correlation.is_empty()
    }

    /// Covariance of the products of the noise with two columns.
    pub(super) fn covariance(&self, frame: &Frame, a: &[f64], b: &[f64]) -> f64 {
        let own: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
        if self.is_white() {
            return self.variance * own;
        }
        let (a, b) = (Grid::new(frame, a), Grid::new(frame, b));
        let across = |lag: &Lag| lag.correlation * (a.products(&b, lag.by).0 + b.products(&a, lag.by).0);
        self.variance * (own + self.correlation.iter().map(across).sum::<f64>())
    }

    /// Variance of the mean of a block of `side`² pixels over that of white noise.
    pub(in crate::fit::inference) fn block_inflation(&self, side: usize) -> f64 {
        let m = side as f64;
        let overlap = |by: i64| (m - by.abs() as f64).max(0.0) / m;
        let across = |lag: &Lag| 2.0 * lag.correlation * lag.by.map(overlap).iter().product::<f64>();
        1.0 + self.correlation.iter().map(across).sum::<f64>()
    }
}

/// Values of the pixels that count, on the view.
struct Grid {
    values: Vec<f64>,
    counts: Vec<bool>,
    width: usize,
}

impl Grid {
    fn new(frame: &Frame, values: &[f64]) -> Self {
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
    fn products(&self, other: &Self, [across, down]: [i64; 2]) -> (f64, f64) {
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
    fn correlation(&self) -> Vec<Lag> {
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
