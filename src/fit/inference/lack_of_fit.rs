//! Whether what a fit leaves over is noise.
//!
//! Noise averages out over blocks of pixels; what a wrong model leaves does not. For white noise of any distribution that is
//! symmetric, and of any variance that varies slowly, Q = (sum r)² / sum r² over the m pixels r of a block has mean 1, and for
//! normal noise the variance 2 (m - 1) / (m + 2). So the noise need not be known; variances that are given are divided out. Noise that
//! neighbours share raises the mean by what its correlation says.

use crate::fit::observation::Observed;
use crate::image::Image;

/// Sides of the blocks, px.
const BLOCKS_PX: [usize; 4] = [2, 4, 8, 16];
/// Fewer blocks than this say nothing.
const FEWEST: usize = 4;
/// Standard deviations by which the mean of Q exceeds 1 where the residual is said to be more than noise.
pub(crate) const LACKING: f64 = 5.0;

/// Root mean square residual over that of the observation below which renders are no more exact than that.
const RENDERED: f64 = 1e-4;

/// By how many standard deviations the mean of Q over all blocks exceeds 1, for the side of blocks where that is most.
/// `inflation` is the mean of Q that the correlation of the noise leaves in a block of a side.
pub(super) fn lack_of_fit(observed: &Observed, render: &Image, inflation: impl Fn(usize) -> f64) -> f64 {
    let image = observed.observation.observed;
    let mut residuals = vec![None; image.data.len()];
    let (mut residual, mut signal) = (0.0, 0.0);
    for pixel in observed.counted() {
        let i = pixel.index as usize;
        let (y, m) = (f64::from(image.data[i]), f64::from(render.data[i]));
        residuals[i] = Some(f64::from(pixel.weight).sqrt() * (y - m));
        residual += (y - m).powi(2);
        signal += y * y;
    }
    if residual < RENDERED * RENDERED * signal {
        return 0.0;
    }
    BLOCKS_PX.iter().filter_map(|&side| excess(&residuals, image, side, inflation(side))).fold(0.0, f64::max)
}

/// The same for blocks of one side of the `residuals` of `image`, whose pixels do not all count.
fn excess(residuals: &[Option<f64>], image: &Image, side: usize, mean: f64) -> Option<f64> {
    let (mut sum, mut blocks) = (0.0, 0);
    for y in (0..image.height + 1 - side.min(image.height + 1)).step_by(side) {
        for x in (0..image.width + 1 - side.min(image.width + 1)).step_by(side) {
            let pixels = (0..side * side).map(|k| (y + k / side) * image.width + x + k % side);
            if let Some(q) = quotient(residuals, pixels) {
                (sum, blocks) = (sum + q, blocks + 1);
            }
        }
    }
    let (m, n) = ((side * side) as f64, blocks as f64);
    (blocks >= FEWEST).then(|| (sum / mean - n) / (n * 2.0 * (m - 1.0) / (m + 2.0)).sqrt())
}

/// Q of one block; `None` if some pixel of it does not count, or all are met exactly.
fn quotient(residuals: &[Option<f64>], mut pixels: impl Iterator<Item = usize>) -> Option<f64> {
    let (sum, squares) = pixels.try_fold((0.0, 0.0), |(sum, squares), i| {
        let r = residuals[i]?;
        Some((sum + r, squares + r * r))
    })?;
    (squares > 0.0).then(|| sum * sum / squares)
}
