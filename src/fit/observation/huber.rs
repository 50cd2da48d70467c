//! Least squares in which a few pixels may be far off: fireflies, hot pixels, dust.
//!
//! Beyond [`KNEE`] standard deviations a residual counts by its magnitude and no longer by its square (Huber 1964). That is the least-squares
//! problem in which the variance of such a pixel is larger by |r| over the knee, solved again from round to round.

use super::Observed;
use crate::image::Image;

/// Standard deviations at which the loss turns from a square to a line: 95 % of the information of normal noise is kept.
const KNEE: f64 = 1.345;
/// The median of the magnitude of a normal number, in standard deviations.
const MEDIAN: f64 = 0.6745;

impl Observed<'_> {
    /// Standard deviation of the residual of `fitted`, of which fewer than half may be far off.
    pub(super) fn robust_noise(&self, fitted: &Image) -> f64 {
        let observed = self.observation.observed;
        let mut residuals: Vec<f64> = self
            .counted()
            .iter()
            .map(|p| f64::from(observed.data[p.index as usize] - fitted.data[p.index as usize]).abs())
            .collect();
        let middle = residuals.len() / 2;
        *residuals.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN
    }

    /// Widens the `variance` of pixels that are far off `fitted`.
    pub(super) fn doubt_outliers(&self, variance: &mut Image, fitted: &Image) {
        let observed = &self.observation.observed.data;
        for ((variance, observed), fitted) in variance.data.iter_mut().zip(observed).zip(&fitted.data) {
            let far = f64::from(observed - fitted).abs() / (KNEE * f64::from(*variance).sqrt());
            if far > 1.0 {
                *variance = (f64::from(*variance) * far) as f32;
            }
        }
    }
}
