//! The relative rms error of a kernel: how far its light per radius lies from the traced one, ring by ring.
//!
//! With t the traced and m the kernel's light per radius, 2 pi r Psi averaged over each of the rings of equal width
//! between the axis and the largest radius,
//!
//! ```text
//! e² = sum (m - t)² / sum t²
//! ```
//!
//! A kernel without light has e = 1. The traced values are known to standard errors s only, which would add sum s² to
//! the sum above and to the sum below on average; both are subtracted.

use crate::trace::Estimate;

/// The error of a kernel over all rings, relative to the rms of the traced light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RmsError {
    /// e, with the noise of the tracing subtracted, and the standard error that this noise leaves.
    pub error: Estimate,
    /// sqrt(sum s² / sum t²): what a perfect kernel would show if the noise were not subtracted.
    pub noise: f64,
}

/// The relative rms error of a kernel's light per radius `kernel` against `traced`, ring by ring, of `paths` paths that
/// each end in one ring at most; `None` if the traced light is not above its noise. Of values that are independent of each
/// other, such as pixels, `paths` is `None`.
///
/// To first order d(e²) = 2 sum g dt / sum t², g = t - m - e² t. A path scores in one ring at most, so
/// cov(t_i, t_j) = -t_i t_j / n between rings; the squares of the noise add 2 sum s⁴ / (sum t²)².
///
/// # Panics
/// Unless there is a value of the kernel for each traced one.
pub fn rms_error(kernel: &[f64], traced: &[Estimate], paths: Option<u64>) -> Option<RmsError> {
    assert_eq!(kernel.len(), traced.len(), "one value of the kernel a ring");
    let n = paths.map_or(f64::INFINITY, |n| n as f64);
    let rings = || kernel.iter().zip(traced).map(|(&m, t)| (m, t.value, t.std_error * t.std_error));
    let noise: f64 = rings().map(|(_, _, s2)| s2).sum();
    let light = rings().map(|(_, t, _)| t * t).sum::<f64>() - noise;
    if light <= 0.0 {
        return None;
    }
    let square = (rings().map(|(m, t, _)| (m - t) * (m - t)).sum::<f64>() - noise).max(0.0) / light;

    let (mut squares, mut mean, mut fourth) = (0.0, 0.0, 0.0);
    for (m, t, s2) in rings() {
        let g = t - m - square * t;
        squares += g * g * (s2 + t * t / n);
        mean += g * t;
        fourth += s2 * s2;
    }
    let variance = (4.0 * (squares - mean * mean / n) + 2.0 * fourth).max(0.0) / (light * light);
    // One standard error of e² upwards; variance.sqrt() / (2 e) where e is not itself lost in the noise.
    let std_error = (square + variance.sqrt()).sqrt() - square.sqrt();
    Some(RmsError { error: Estimate { value: square.sqrt(), std_error }, noise: (noise / light).sqrt() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exact(values: [f64; 4]) -> Vec<Estimate> {
        values.map(|value| Estimate { value, std_error: 0.0 }).to_vec()
    }

    #[test]
    fn a_kernel_without_light_errs_by_all_and_one_of_half_the_light_by_half() {
        let traced = exact([3.0, 4.0, 1.0, 0.0]);
        let error = |kernel: [f64; 4]| rms_error(&kernel, &traced, Some(100)).unwrap().error.value;
        assert_eq!(error([0.0; 4]), 1.0);
        assert_eq!(error([1.5, 2.0, 0.5, 0.0]), 0.5);
        assert_eq!(error([3.0, 4.0, 1.0, 0.0]), 0.0);
        assert!(rms_error(&[1.0; 4], &exact([0.0; 4]), Some(100)).is_none());
    }
}
