//! What is unlike white noise of the stated level in a residual that no fault of the image explains.

use super::SIGNIFICANT;
use super::cause::Cause;
use super::fields::Fields;
use super::finding::Finding;
use super::frame::Frame;
use super::grid::{Lag, REACH};
use super::projected::Projected;
use crate::fit::observation::NoiseTerm;
use nalgebra::DVector;

/// Excess of variance over what was stated that matters.
const EXCESS: f64 = 0.1;
/// Robust standard deviations beyond which a pixel is an outlier: by chance one of 500 million is.
const FAR: f64 = 6.0;
/// Share of a normal distribution within one standard deviation.
const ONE_SIGMA: f64 = 0.682_689;
/// Pixels of exactly the highest value, and their share, from which on that is a ceiling.
const CEILING: (usize, f64) = (8, 5e-4);
/// Squares of residuals over their variance count as no more than this where their relation to brightness is sought, lest
/// outliers decide.
const MOST_SQUARE: f64 = 9.0;
/// Correlation at the farthest lags above which a residual is no noise.
const FAR_CORRELATION: f64 = 0.05;
/// Change of the variance with the brightness, per standard deviation of the latter, that matters.
const LEAST_TREND: f64 = 0.1;

/// A residual in units of the assumed noise, and its variance.
pub(super) struct Anomalies<'x> {
    pub frame: &'x Frame<'x>,
    pub projected: &'x Projected,
    pub fields: &'x Fields,
    pub variance: f64,
    pub scene: usize,
}

impl Anomalies<'_> {
    /// All that is significant.
    pub(super) fn findings(&self, correlation: &[Lag]) -> Vec<Finding> {
        // Of a level and a variance that are both wrong the more significant is told.
        let of_noise = [self.level(), self.brightness()].into_iter().flatten();
        let of_noise = of_noise.max_by(|a, b| a.significance.total_cmp(&b.significance));
        let all = [self.outliers(), self.ceiling(), of_noise, self.correlated(correlation)];
        all.into_iter().flatten().filter(|finding| finding.significance > SIGNIFICANT).collect()
    }

    /// Amplitude, its standard error, drop of chi² and significance of a cause that moves no estimate by itself.
    fn found(&self, cause: Cause, [amplitude, std_error, delta_chi2, significance]: [f64; 4]) -> Finding {
        let bias = DVector::zeros(self.projected.bias.nrows());
        let (alternatives, scene) = (Vec::new(), self.scene);
        Finding { cause, alternatives, scene, amplitude, std_error, delta_chi2, significance, bias }
    }

    /// Pixels farther off than noise is.
    fn outliers(&self) -> Option<Finding> {
        let mut magnitudes: Vec<f64> = self.fields.pure.iter().map(|r| r.abs()).collect();
        let last = magnitudes.len().checked_sub(1)?;
        let middle = ((magnitudes.len() as f64 * ONE_SIGMA) as usize).min(last);
        let (_, sigma, _) = magnitudes.select_nth_unstable_by(middle, f64::total_cmp);
        let limit = FAR * *sigma;
        let far = |r: &f64| limit > 0.0 && r.abs() > limit;
        let count = self.fields.pure.iter().filter(|r| far(r)).count() as f64;
        let square: f64 = self.fields.pure.iter().filter(|r| far(r)).map(|r| r * r).sum();
        let alone = |i: usize| if far(&self.fields.pure[i]) { self.fields.pure[i] } else { 0.0 };
        let bias = self.projected.bias_by(self.frame, &self.fields.gradient(alone));
        let found = self.found(Cause::Outliers, [count, count.sqrt(), square, square.sqrt()]);
        (count > 0.0).then_some(Finding { bias, ..found })
    }

    /// Many pixels of exactly the highest value.
    fn ceiling(&self) -> Option<Finding> {
        let pixels = self.frame.observed().counted();
        let highest = pixels.iter().map(|p| p.value).fold(f32::NEG_INFINITY, f32::max);
        let count = pixels.iter().filter(|p| p.value >= highest).count();
        let (fewest, share) = CEILING;
        let is_ceiling = count >= fewest && count as f64 >= share * pixels.len() as f64 && highest > 0.0;
        let n = count as f64;
        let at_ceiling = pixels.iter().zip(&self.fields.residual).filter(|(p, _)| p.value >= highest);
        let square: f64 = at_ceiling.map(|(_, r)| r * r).sum();
        // Of a continuous distribution no two values are the same.
        is_ceiling
            .then(|| self.found(Cause::Saturation, [n, n.sqrt(), square.max(n), SIGNIFICANT + n.sqrt()]))
    }

    /// A noise that is larger than was stated.
    fn level(&self) -> Option<Finding> {
        self.frame.observed().observation.noise?;
        let n = self.fields.pure.len() as f64;
        let (excess, error) = (self.variance - 1.0, (2.0 / n).sqrt());
        let ratio = self.variance.sqrt();
        let numbers = [ratio, 0.5 * error * ratio, excess * n, excess / error];
        (excess > EXCESS).then(|| self.found(Cause::NoiseModel, numbers))
    }

    /// A variance that follows the brightness, where one number is assumed.
    fn brightness(&self) -> Option<Finding> {
        let given = self.frame.observed().observation.noise;
        if self.frame.observed().weights_are_fitted()
            || matches!(given, Some(NoiseTerm::Variance(_) | NoiseTerm::Sensor { .. }))
            || self.variance <= 0.0
        {
            return None;
        }
        let pixels = self.frame.observed().counted();
        let n = pixels.len() as f64;
        let light: Vec<f64> =
            pixels.iter().map(|p| f64::from(self.frame.light().data[p.index as usize])).collect();
        let square: Vec<f64> =
            self.fields.pure.iter().map(|r| (r * r / self.variance).min(MOST_SQUARE)).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
        let (mean_light, mean_square) = (mean(&light), mean(&square));
        let (mut both, mut lights, mut squares) = (0.0, 0.0, 0.0);
        for (l, s) in light.iter().zip(&square) {
            let (l, s) = (l - mean_light, s - mean_square);
            (both, lights, squares) = (both + l * s, lights + l * l, squares + s * s);
        }
        if lights <= 0.0 || squares <= 0.0 {
            return None;
        }
        let trend = both / lights * (lights / n).sqrt();
        let error = (squares / n / n).sqrt();
        let z = trend.abs() / error;
        (trend.abs() > LEAST_TREND).then(|| self.found(Cause::NoiseModel, [trend, error, z * z, z]))
    }

    /// Noise that neighbours share. What reaches as far as is looked at is no noise, but what the fit leaves of the image.
    fn correlated(&self, correlation: &[Lag]) -> Option<Finding> {
        let error = 1.0 / (self.fields.pure.len() as f64).sqrt();
        let far = correlation.iter().filter(|lag| lag.by.iter().any(|by| by.abs() == REACH));
        if far.into_iter().any(|lag| lag.correlation.abs() > FAR_CORRELATION + SIGNIFICANT * error) {
            return None;
        }
        let square: f64 = correlation.iter().map(|lag| lag.pairs * lag.correlation.powi(2)).sum();
        let freedom = correlation.len() as f64;
        // A sum of squares of standard normal numbers, as a normal one (Wilson and Hilferty 1931).
        let spread = 2.0 / (9.0 * freedom);
        let z = ((square / freedom).cbrt() - (1.0 - spread)) / spread.sqrt();
        let largest =
            correlation.iter().map(|lag| lag.correlation).max_by(|a, b| a.abs().total_cmp(&b.abs()))?;
        Some(self.found(Cause::CorrelatedNoise, [largest, error, square, z]))
    }
}
