//! The noise of one scene, from its residual with all that was fitted, and all that may be wrong, taken out.

use super::anomalies::Anomalies;
use super::cause::Cause;
use super::fields::Fields;
use super::finding::Finding;
use super::frame::Frame;
use super::grid::{Grid, Lag};
use super::projected::Projected;

/// What the residual is like from pixel to pixel, in units of the noise that the fit assumed.
#[derive(Debug)]
pub(in crate::fit::inference) struct Noise {
    /// Variance.
    pub variance: f64,
    /// Autocorrelation at each lag of half the plane; empty if the noise is white.
    correlation: Vec<Lag>,
    findings: Vec<Finding>,
}

impl Noise {
    /// That of the scene of `frame`, number `scene`.
    pub(super) fn new(frame: &Frame, projected: &Projected, fields: &Fields, scene: usize) -> Self {
        let residual = &fields.pure;
        let freedom = (residual.len() as f64 - frame.size() as f64).max(1.0);
        let variance = residual.iter().map(|r| r * r).sum::<f64>() / freedom;
        let variance = variance.max(frame.rounding());
        let mut correlation = Grid::new(frame, residual).correlation();
        let anomalies = Anomalies { frame, projected, fields, variance, scene };
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
