//! The Gaussian phase function p(theta) ∝ exp(-theta²/(4B)).
//!
//! On the sphere it is normalised exactly, for any width. In the small-angle limit it is
//! p(s) = (1/B) exp(-s²/(4B)) on the plane of slopes (Shinya et al., eq. 9), with Phat(q) = exp(-B q²) (their
//! eq. 10) and F(q) = sqrt(pi) erf(x)/(2x), x = sqrt(B) q. For narrow ones g ≈ 1 - 2B.

use super::{Family, PhaseFunction};
use crate::error::{Result, in_range};
use crate::quadrature::integrate;
use libm::{erf, erfc};
use std::f64::consts::PI;

/// Gaussian phase function of width B, rad².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaussian {
    b: f64,
    peak: f64,
}

/// Largest B, rad²: scattering is isotropic to a percent, and the sampler still accepts one draw in eighty.
const WIDEST: f64 = 100.0;

/// Below this x, F(x) and its derivative are summed as series: the closed forms cancel.
const SERIES_BELOW: f64 = 0.1;

/// F(x) = sqrt(pi) erf(x) / (2x): the mean of exp(-t²) over 0 < t < x.
pub fn mean_gaussian(x: f64) -> f64 {
    if x < SERIES_BELOW {
        let y = x * x;
        1.0 - y / 3.0 + y * y / 10.0 - y * y * y / 42.0 + y.powi(4) / 216.0 - y.powi(5) / 1320.0
    } else {
        0.5 * PI.sqrt() * erf(x) / x
    }
}

/// x dF/dx = exp(-x²) - F(x), without the cancellation near 0.
pub fn mean_gaussian_slope(x: f64) -> f64 {
    if x < SERIES_BELOW {
        let y = x * x;
        -2.0 * y / 3.0 + 2.0 * y * y / 5.0 - y * y * y / 7.0 + y.powi(4) / 27.0 - y.powi(5) / 132.0
    } else {
        (-x * x).exp() - mean_gaussian(x)
    }
}

/// Width B = D²/4 of the Gaussian phase function whose spread angle sqrt(4B) is `spread_angle` D, radians.
pub fn b_of_spread_angle(spread_angle: f64) -> f64 {
    0.25 * spread_angle * spread_angle
}

impl Gaussian {
    /// The Gaussian phase function of width `b`, rad².
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless `b` is above 0 and at most 100 rad².
    pub fn new(b: f64) -> Result<Self> {
        let b = in_range("b", b, b > 0.0 && b <= WIDEST, "above 0 and at most 100 (rad²)")?;
        // The integrand is smooth on the scale of its own width; beyond ten widths it holds exp(-100).
        let end = PI.min(20.0 * b.sqrt());
        let norm = integrate(0.0, end, 8, |theta| (-theta * theta / (4.0 * b)).exp() * theta.sin());
        Ok(Self { b, peak: 2.0 / norm })
    }

    /// Width B, rad².
    pub fn b(&self) -> f64 {
        self.b
    }

    /// Mean square of the deflection on the sphere, rad². With p(theta) = N exp(-theta²/4B), d ln N/dB is minus this by 4B².
    pub fn mean_square_angle(&self) -> f64 {
        let end = PI.min(20.0 * self.b.sqrt());
        let moment = |theta: f64| theta * theta * (-theta * theta / (4.0 * self.b)).exp() * theta.sin();
        0.5 * self.peak * integrate(0.0, end, 8, moment)
    }

    /// sqrt(4B): rms of a single deflection for small B, radians.
    pub fn spread_angle(&self) -> f64 {
        (4.0 * self.b).sqrt()
    }
}

impl PhaseFunction for Gaussian {
    fn family(&self) -> Family {
        Family::Gaussian
    }

    fn parameter(&self) -> f64 {
        self.b
    }

    fn eval(&self, cos_theta: f64) -> f64 {
        let theta = cos_theta.clamp(-1.0, 1.0).acos();
        self.peak * (-theta * theta / (4.0 * self.b)).exp()
    }

    /// Rayleigh-distributed angles, density ∝ theta exp(-theta²/4B), thinned by sin(theta)/theta: exact on the
    /// sphere. The point in the unit disc that gives the azimuth also gives the radius (Marsaglia's polar method).
    #[inline]
    fn sample(&self, uniform: &mut impl FnMut() -> f32) -> [f32; 4] {
        let four_b = 4.0 * self.b as f32;
        loop {
            let (x, y) = (2.0 * uniform() - 1.0, 2.0 * uniform() - 1.0);
            let s = x * x + y * y;
            if s >= 1.0 || s == 0.0 {
                continue;
            }
            let theta = (-four_b * s.ln()).sqrt();
            if theta >= std::f32::consts::PI {
                continue;
            }
            let (sin, cos) = theta.sin_cos();
            if uniform() * theta <= sin {
                let inv = 1.0 / s.sqrt();
                return [sin, cos, x * inv, y * inv];
            }
        }
    }

    fn mean_cosine(&self) -> f64 {
        let end = PI.min(20.0 * self.b.sqrt());
        0.5 * self.peak
            * integrate(0.0, end, 8, |theta| {
                (-theta * theta / (4.0 * self.b)).exp() * theta.sin() * theta.cos()
            })
    }

    fn planar_transform(&self, q: f64) -> f64 {
        (-self.b * q * q).exp()
    }

    fn planar_transform_derivative(&self, q: f64) -> f64 {
        -q * q * self.planar_transform(q)
    }

    fn mean_planar_transform(&self, q: f64) -> f64 {
        mean_gaussian(self.b.sqrt() * q)
    }

    fn mean_planar_transform_derivative(&self, q: f64) -> f64 {
        mean_gaussian_slope(self.b.sqrt() * q) / (2.0 * self.b)
    }

    fn planar_width(&self) -> f64 {
        self.b.sqrt()
    }

    fn planar_width_derivative(&self) -> f64 {
        0.5 / self.b.sqrt()
    }

    fn planar_second_moment(&self) -> Option<f64> {
        Some(4.0 * self.b)
    }

    fn single_scatter_psf(&self, r: f64, z: f64) -> f64 {
        let width = z * self.b.sqrt();
        erfc(r / (2.0 * width)) / (4.0 * PI.sqrt() * width * r)
    }

    fn single_scatter_encircled(&self, r: f64, z: f64) -> f64 {
        encircled_erfc(r / (2.0 * z * self.b.sqrt()))
    }
}

/// Share within y = r/beta of the normalised profile (1/r) erfc(r/beta): sqrt(pi) y erfc(y) + 1 - exp(-y²).
pub fn encircled_erfc(y: f64) -> f64 {
    PI.sqrt() * y * erfc(y) - (-y * y).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_and_closed_form_meet() {
        for (f, closed) in [
            (mean_gaussian as fn(f64) -> f64, 0.5 * PI.sqrt() * erf(0.0999) / 0.0999),
            (mean_gaussian_slope, (-0.0999_f64 * 0.0999).exp() - 0.5 * PI.sqrt() * erf(0.0999) / 0.0999),
        ] {
            assert!((f(0.0999) - closed).abs() < 1e-14);
        }
    }

    #[test]
    fn narrow_ones_have_mean_cosine_one_minus_two_b() {
        let g = Gaussian::new(1e-3).unwrap().mean_cosine();
        // The next term of the expansion is of order B².
        assert!((g - (1.0 - 2e-3)).abs() < 1e-5, "{g}");
    }
}
