//! The homogeneous, index-matched scattering medium.
//!
//! `sigma_s` and `sigma_a` are the scattering and the absorption coefficient, in 1/length; everything else
//! about the amount of light is derived from them. The direction of scattered light is the
//! [`PhaseFunction`]'s.

use crate::error::{Result, in_range};
use crate::phase::{Gaussian, Phase, PhaseFunction};

/// A homogeneous medium: scattering and absorption coefficient, 1/length, and phase function.
///
/// ```
/// use narrowbeam::medium::Medium;
/// let fog = Medium::gaussian(0.95, 0.05, 0.01)?;
/// assert!((fog.transmittance(2.0) - (-2.0_f64).exp()).abs() < 1e-15);
/// # Ok::<(), narrowbeam::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium<P = Phase> {
    sigma_s: f64,
    sigma_a: f64,
    phase: P,
}

impl Medium {
    /// A medium of coefficients `sigma_s` and `sigma_a`, 1/length, with the Gaussian phase function of width `b`, rad².
    ///
    /// # Errors
    /// As [`Medium::new`] and [`Gaussian::new`].
    pub fn gaussian(sigma_s: f64, sigma_a: f64, b: f64) -> Result<Self> {
        Self::new(sigma_s, sigma_a, Gaussian::new(b)?.into())
    }
}

impl<P> Medium<P> {
    /// A medium of scattering coefficient `sigma_s` and absorption coefficient `sigma_a`, both in 1/length, and of the phase
    /// function `phase`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless both are at least 0 and at most 1e30, which f32 can hold.
    pub fn new(sigma_s: f64, sigma_a: f64, phase: P) -> Result<Self> {
        let allowed = "at least 0 and at most 1e30 (1/length)";
        let ok = |v: f64| (0.0..=1e30).contains(&v);
        Ok(Self {
            sigma_s: in_range("sigma_s", sigma_s, ok(sigma_s), allowed)?,
            sigma_a: in_range("sigma_a", sigma_a, ok(sigma_a), allowed)?,
            phase,
        })
    }

    /// A medium of these coefficients with another phase function.
    pub fn with_phase<Q>(&self, phase: Q) -> Medium<Q> {
        Medium { sigma_s: self.sigma_s, sigma_a: self.sigma_a, phase }
    }

    /// Scattering coefficient, 1/length.
    pub fn sigma_s(&self) -> f64 {
        self.sigma_s
    }

    /// Absorption coefficient, 1/length.
    pub fn sigma_a(&self) -> f64 {
        self.sigma_a
    }

    /// Phase function.
    pub fn phase(&self) -> &P {
        &self.phase
    }

    /// Extinction coefficient sigma_s + sigma_a, 1/length.
    pub fn sigma_t(&self) -> f64 {
        self.sigma_s + self.sigma_a
    }

    /// Single-scattering albedo sigma_s / sigma_t; 0 in a vacuum.
    pub fn albedo(&self) -> f64 {
        if self.sigma_t() > 0.0 { self.sigma_s / self.sigma_t() } else { 0.0 }
    }

    /// Scattering optical depth tau = sigma_s z over the path length `z`.
    pub fn tau(&self, z: f64) -> f64 {
        self.sigma_s * z
    }

    /// Unscattered share exp(-sigma_t z) of the light (Beer-Lambert) over the path length `z`.
    pub fn transmittance(&self, z: f64) -> f64 {
        (-self.sigma_t() * z).exp()
    }

    /// Share exp(-sigma_a z)(1 - exp(-sigma_s z)) of the light that is scattered and not absorbed, in
    /// small-angle theory (Shinya et al., eq. 20).
    pub fn scattered_total(&self, z: f64) -> f64 {
        -(-self.sigma_a * z).exp() * (-self.tau(z)).exp_m1()
    }
}

impl<P: PhaseFunction> Medium<P> {
    /// sigma_s, sigma_a and the phase-function parameter.
    pub fn parameters(&self) -> [f64; 3] {
        [self.sigma_s, self.sigma_a, self.phase.parameter()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const B: f64 = 0.01;

    #[test]
    fn transmittance_multiplies_over_segments() {
        let medium = Medium::gaussian(0.7, 0.3, B).unwrap();
        let whole = medium.transmittance(1.7);
        let parts = medium.transmittance(0.5) * medium.transmittance(1.2);
        assert!((whole - parts).abs() < 1e-15);
    }

    #[test]
    fn direct_and_scattered_light_add_up_to_what_is_not_absorbed() {
        let medium = Medium::gaussian(0.7, 0.3, B).unwrap();
        let kept = medium.transmittance(2.0) + medium.scattered_total(2.0);
        assert!((kept - (-0.6_f64).exp()).abs() < 1e-15);
    }

    #[test]
    fn a_negative_or_nan_coefficient_is_refused_by_name() {
        let message = Medium::gaussian(-0.1, 0.0, B).unwrap_err().to_string();
        assert!(message.contains("sigma_s = -0.1"), "{message}");
        let message = Medium::gaussian(0.1, f64::NAN, B).unwrap_err().to_string();
        assert!(message.contains("sigma_a"), "{message}");
    }

    #[test]
    fn a_vacuum_has_albedo_zero() {
        assert_eq!(Medium::gaussian(0.0, 0.0, B).unwrap().albedo(), 0.0);
    }
}
