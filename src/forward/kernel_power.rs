//! What a noisy clear image leaves in a render: the power of the kernel.
//!
//! White noise of variance v in the object has, in the render and its derivatives, the products v · <K_i, K_j> a pixel, where K is
//! the kernel and its derivatives are those of the render. By Parseval these are integrals of the transfer functions over the
//! frequencies of an image, |w_x|, |w_y| ≤ π rad/px:
//!
//! <K_i, K_j> = (2π)^-2 ∫ M_i(w) M_j(w) d²w,  M(w) = T + S(w) B(w),
//!
//! with the direct light T, the scattered S, and B the two pixel boxes that it passes where radiance is constant over a pixel.
//! Aliases are left out: B, or a kernel wider than a pixel, leaves little of them. So is the distance at which neighbours lie in depth.

use crate::error::Result;
use crate::image::Sampling;
use crate::medium::Medium;
use crate::quadrature::nodes;
use crate::spread::{Dual, Model};
use nalgebra::DMatrix;
use std::f64::consts::{FRAC_PI_4, PI};

/// Ends of the panels of w, rad/px: kernels are up to hundreds of pixels wide.
const PANELS: [f64; 6] = [0.0, 0.01, 0.04, 0.16, 0.6, PI];

/// Products of the kernel and its derivatives in the medium, in the order of [`Quantity::MEDIUM`](super::Quantity::MEDIUM), at the path
/// length `z` and the pixel pitch `pitch` (length), of the mean over a block of `side`² pixels.
///
/// # Errors
/// As [`Model::kernel`].
pub(crate) fn kernel_power(
    model: Model,
    medium: &Medium,
    (z, pitch): (f64, f64),
    sampling: Sampling,
    side: usize,
) -> Result<DMatrix<f64>> {
    let kernel = model.kernel(medium, z)?;
    let direct = kernel.direct();
    let mut power = DMatrix::zeros(4, 4);
    for (w, step) in radii() {
        let scattered = kernel.scattered_transfer(w / pitch);
        let [all, once, twice] = ring(w, sampling, side as f64).map(|share| share * step * w / (PI * PI));
        let columns = |dual: &Dual| [dual.value, dual.gradient[0], dual.gradient[1], dual.gradient[2]];
        let (t, s) = (columns(&direct), columns(&scattered));
        for i in 0..4 {
            for j in 0..4 {
                power[(i, j)] += all * t[i] * t[j] + once * (t[i] * s[j] + s[i] * t[j]) + twice * s[i] * s[j];
            }
        }
    }
    Ok(power)
}

/// Radii of frequencies and their steps, rad/px. Beyond π only the corners of the square are left, which begin there like a square root: the
/// angle at which the side is met is the better variable.
fn radii() -> Vec<(f64, f64)> {
    let inner = PANELS.windows(2).flat_map(|ends| nodes(ends[0], ends[1], 1));
    let corner =
        |(angle, step): (f64, f64)| (PI / angle.cos(), step * PI * angle.sin() / angle.cos().powi(2));
    inner.chain(nodes(0.0, FRAC_PI_4, 1).into_iter().map(corner)).collect()
}

/// Integrals of 1, of B and of B² over a quarter of the ring of radius `w`, where it lies in the square of frequencies.
fn ring(w: f64, sampling: Sampling, side: f64) -> [f64; 3] {
    // By symmetry twice an eighth, which the side of the square cuts off.
    let first = if w > PI { (PI / w).acos() } else { 0.0 };
    let mut sums = [0.0; 3];
    for (angle, step) in nodes(first.min(FRAC_PI_4), FRAC_PI_4, 1) {
        let boxed = match sampling {
            Sampling::Bandlimited => 1.0,
            Sampling::Pixel => {
                [w * angle.cos(), w * angle.sin()].map(|v| sinc(0.5 * v).powi(2)).iter().product()
            }
        };
        let block: f64 =
            [w * angle.cos(), w * angle.sin()].map(|v| dirichlet(v, side).powi(2)).iter().product();
        let parts = [1.0, boxed, boxed * boxed];
        sums.iter_mut().zip(parts).for_each(|(sum, part)| *sum += 2.0 * step * block * part);
    }
    sums
}

/// The transfer function of the mean over `side` pixels.
fn dirichlet(w: f64, side: f64) -> f64 {
    let below = (0.5 * w).sin();
    if below.abs() < 1e-6 { 1.0 } else { (0.5 * side * w).sin() / (side * below) }
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn power(model: Model, sampling: Sampling, sigma_s: f64) -> DMatrix<f64> {
        let medium = Medium::gaussian(sigma_s, 0.1, 0.005).unwrap();
        kernel_power(model, &medium, (2.0, 0.02), sampling, 1).unwrap()
    }

    #[test]
    fn direct_light_alone_keeps_its_square() {
        let power = power(Model::BeerLambert, Sampling::Pixel, 0.8);
        let t = (-0.9_f64 * 2.0).exp();
        assert!((power[(0, 0)] / (t * t) - 1.0).abs() < 1e-9, "{}", power[(0, 0)]);
        assert!((power[(0, 1)] / (-2.0 * t * t) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn noise_that_is_not_spread_averages_out_over_blocks() {
        let medium = Medium::gaussian(0.8, 0.1, 0.005).unwrap();
        let block = |side| {
            kernel_power(Model::BeerLambert, &medium, (2.0, 0.02), Sampling::Pixel, side).unwrap()[(0, 0)]
        };
        for side in [2, 4, 8, 16] {
            let ratio = block(side) / block(1) * (side * side) as f64;
            assert!((ratio - 1.0).abs() < 0.02, "{side}: {ratio}");
        }
    }

    #[test]
    fn derivatives_are_those_of_the_power() {
        let step = 1e-4;
        for sampling in Sampling::ALL {
            let at = |change: f64| power(Model::SmallAngle, sampling, 0.8 + change)[(0, 0)];
            let slope = (at(step) - at(-step)) / (2.0 * step);
            let stated = 2.0 * power(Model::SmallAngle, sampling, 0.8)[(0, 1)];
            assert!((slope / stated - 1.0).abs() < 1e-5, "{slope} {stated}");
        }
    }
}
