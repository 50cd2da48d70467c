//! The kernels of fixed profile: `gaussian`, `narrow-beam` and `narrow-beam-printed`.
//!
//! Total phi = exp(-sigma_a z)(1 - exp(-sigma_s z)) (Shinya et al., eq. 20) and mean square radius m = R/phi fix
//! the scale of the profile. With y = k² m:
//!
//! | profile | density of unit total | transform |
//! | --- | --- | --- |
//! | Gaussian | exp(-r²/m) / (pi m) | exp(-y/4) |
//! | erfc (eq. 26, 28 with G = erfc/2) | erfc(r/beta) / (2 sqrt(pi) beta r), beta² = 3 m | F(x), x = k beta/2 |
//!
//! F(x) = sqrt(pi) erf(x)/(2x). The exact second moment is R = (4/3) sigma_s B z³ exp(-sigma_a z); the printed
//! eq. 21 is up to three times as large in thick media: it multiplies the angle gained after the first scattering by z
//! instead of the remaining distance.

use super::{Dual, SpreadKernel};
use crate::medium::Medium;
use crate::phase::{PhaseFunction, encircled_erfc, mean_gaussian, mean_gaussian_slope};
use libm::erfc;
use std::f64::consts::PI;

/// The profile of the scattered light.
#[derive(Debug, Clone, Copy)]
pub(super) enum Profile {
    Gaussian,
    Erfc,
}

/// Which second moment a profile is matched to.
#[derive(Debug, Clone, Copy)]
pub(super) enum Moments {
    Exact,
    Printed,
}

/// Mean square radius R/phi and its logarithmic derivative in tau.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeanSquareRadius {
    pub value: f64,
    pub d_ln_d_tau: f64,
}

/// Below this tau the brackets of R/phi are summed as series: the closed forms cancel.
const SERIES_BELOW: f64 = 0.5;

impl Moments {
    /// R/phi for scattering depth `tau`, phase function of width `b` and path length `z`.
    pub(super) fn mean_square_radius(self, tau: f64, b: f64, z: f64) -> MeanSquareRadius {
        let scattered = -(-tau).exp_m1();
        // tau / (1 - exp(-tau)) and the derivative of its logarithm.
        let (thick, d_thick) = if tau < 1e-4 {
            (1.0 + 0.5 * tau, 0.5 - tau / 12.0)
        } else {
            (tau / scattered, 1.0 / tau - 1.0 / tau.exp_m1())
        };
        match self {
            Moments::Exact => MeanSquareRadius { value: 4.0 / 3.0 * b * z * z * thick, d_ln_d_tau: d_thick },
            Moments::Printed => {
                let (h, d_h) = printed_bracket(tau);
                MeanSquareRadius { value: 4.0 * b * z * z * h * thick, d_ln_d_tau: d_h / h + d_thick }
            }
        }
    }
}

/// Eq. 21 in units of 4 B z² tau exp(-sigma_a z), with A = sigma_s B and a = sigma_s:
/// h(tau) = [exp(-tau)(1 - 2/tau²) + 2/tau² - 2/tau + tau] / tau, and dh/dtau.
fn printed_bracket(tau: f64) -> (f64, f64) {
    if tau < SERIES_BELOW {
        // Coefficients (-1)^n [1/n! - 2/(n+2)!] of tau^n for n ≥ 2; 1/3 for n = 1.
        let (mut h, mut d_h) = (1.0 / 3.0, 0.0);
        let (mut factorial, mut sign) = (1.0, -1.0);
        for n in 2..20 {
            let m = f64::from(n);
            factorial *= m;
            sign = -sign;
            let c = sign / factorial * (1.0 - 2.0 / ((m + 1.0) * (m + 2.0)));
            h += c * tau.powi(n - 1);
            d_h += c * (m - 1.0) * tau.powi(n - 2);
        }
        (h, d_h)
    } else {
        let (e, t2) = ((-tau).exp(), tau * tau);
        let sum = e * (1.0 - 2.0 / t2) + 2.0 / t2 - 2.0 / tau + tau;
        let d_sum = -e * (1.0 - 2.0 / t2) + 4.0 * e / (t2 * tau) - 4.0 / (t2 * tau) + 2.0 / t2 + 1.0;
        (sum / tau, d_sum / tau - sum / t2)
    }
}

impl Profile {
    /// Transform at y = k² m, and its derivative in ln y.
    fn transform(self, y: f64) -> (f64, f64) {
        match self {
            Profile::Gaussian => {
                let e = (-0.25 * y).exp();
                (e, -0.25 * y * e)
            }
            Profile::Erfc => {
                let x = (0.75 * y).sqrt();
                (mean_gaussian(x), 0.5 * mean_gaussian_slope(x))
            }
        }
    }

    /// Density at radius `r` of unit total, for mean square radius `m`.
    fn density(self, r: f64, m: f64) -> f64 {
        match self {
            Profile::Gaussian => (-r * r / m).exp() / (PI * m),
            Profile::Erfc => {
                let beta = (3.0 * m).sqrt();
                erfc(r / beta) / (2.0 * PI.sqrt() * beta * r)
            }
        }
    }

    /// Share within radius `r`, for mean square radius `m`.
    fn encircled(self, r: f64, m: f64) -> f64 {
        match self {
            Profile::Gaussian => -(-r * r / m).exp_m1(),
            Profile::Erfc => encircled_erfc(r / (3.0 * m).sqrt()),
        }
    }
}

pub(super) struct MomentMatched {
    medium: Medium,
    z: f64,
    b: f64,
    profile: Profile,
    phi: f64,
    radius: MeanSquareRadius,
}

impl MomentMatched {
    /// `b` is a quarter of the planar second moment <s²> = 4B of the phase function, rad².
    pub(super) fn new(medium: Medium, b: f64, z: f64, profile: Profile, moments: Moments) -> Self {
        let radius = moments.mean_square_radius(medium.tau(z), b, z);
        Self { medium, z, b, profile, phi: medium.scattered_total(z), radius }
    }
}

impl SpreadKernel for MomentMatched {
    fn path_length(&self) -> f64 {
        self.z
    }

    fn medium(&self) -> &Medium {
        &self.medium
    }

    fn scattered_transfer(&self, k: f64) -> Dual {
        let (f, d_f) = self.profile.transform(k * k * self.radius.value);
        let value = self.phi * f;
        let d_phi = self.z * self.medium.transmittance(self.z);
        let d_sigma_s = d_phi * f + self.phi * d_f * self.z * self.radius.d_ln_d_tau;
        Dual { value, gradient: [d_sigma_s, -self.z * value, self.phi * d_f / self.b] }
    }

    fn psf(&self, r: f64) -> f64 {
        self.phi * self.profile.density(r, self.radius.value)
    }

    fn encircled_energy(&self, r: f64) -> f64 {
        self.phi * self.profile.encircled(r, self.radius.value)
    }

    /// beta/2 or sqrt(m)/2: where the argument of the transform is 1.
    fn width(&self) -> f64 {
        match self.profile {
            Profile::Gaussian => 0.5 * self.radius.value.sqrt(),
            Profile::Erfc => 0.5 * (3.0 * self.radius.value).sqrt(),
        }
    }
}

/// Absolute second radial moment of the scattered light in small-angle theory, length².
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SecondMoments {
    /// The exact one.
    pub exact: f64,
    /// As printed in eq. 21 of Shinya et al.
    pub printed: f64,
}

/// The second moments in `medium` after path length `z`; `None` where they are infinite.
pub fn second_moments(medium: &Medium, z: f64) -> Option<SecondMoments> {
    let b = gaussian_width(medium)?;
    let of =
        |moments: Moments| moments.mean_square_radius(medium.tau(z), b, z).value * medium.scattered_total(z);
    Some(SecondMoments { exact: of(Moments::Exact), printed: of(Moments::Printed) })
}

/// Width B of the Gaussian phase function with the planar second moment <s²> = 4B of that of `medium`, rad²; `None` where
/// that is infinite.
pub(super) fn gaussian_width(medium: &Medium) -> Option<f64> {
    medium.phase().planar_second_moment().map(|moment| 0.25 * moment)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn printed_moment_is_eq_21_term_by_term() {
        let (sigma_s, b, z) = (0.9_f64, 0.004, 2.3);
        let (cap_a, a, e) = (sigma_s * b, sigma_s, (-sigma_s * z).exp());
        let bracket = e * (cap_a * z * z / a - 2.0 * b / (a * a))
            + (2.0 * b / (a * a) - 2.0 * b * z / a + (-cap_a / a + b) * z * z + cap_a * z.powi(3));
        let medium = Medium::gaussian(sigma_s, 0.2, b).unwrap();
        let printed = second_moments(&medium, z).unwrap().printed;
        let want = 4.0 * (-0.2 * z).exp() * bracket;
        assert!((printed / want - 1.0).abs() < 1e-12, "{printed} {want}");
    }

    #[test]
    fn printed_moment_tends_to_the_exact_one_in_thin_media_and_to_three_times_it_in_thick_ones() {
        let ratio = |tau: f64| {
            Moments::Printed.mean_square_radius(tau, 0.01, 1.0).value
                / Moments::Exact.mean_square_radius(tau, 0.01, 1.0).value
        };
        assert!((ratio(1e-9) - 1.0).abs() < 1e-8);
        // The next term is 3 (1 - 2/tau²).
        assert!((ratio(1e4) / 3.0 - 1.0).abs() < 1e-7);
    }

    #[test]
    fn series_and_closed_form_of_the_printed_bracket_meet() {
        let (below, above) = (printed_bracket(SERIES_BELOW - 1e-9), printed_bracket(SERIES_BELOW + 1e-9));
        assert!((below.0 - above.0).abs() < 1e-8 && (below.1 - above.1).abs() < 1e-8);
    }
}
