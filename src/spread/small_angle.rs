//! `small-angle`: every order of scattering, exact for small angles.
//!
//! M(k) = exp(-sigma_t z + sigma_s ∫_0^z Phat(k u) du) = T exp(tau F(kz)) for any phase function (Wells 1969;
//! Ishimaru 1978, ch. 13), u being the distance from the scattering event to the object plane. The density has no
//! closed form: its part scattered once has, and the rest, T (exp(tau F) - 1 - tau F), falls like 1/k² and is
//! transformed numerically.

use super::{Dual, SpreadKernel, hankel};
use crate::medium::Medium;
use crate::phase::PhaseFunction;

pub(super) struct SmallAngle {
    medium: Medium,
    z: f64,
    t: f64,
    tau: f64,
}

impl SmallAngle {
    pub(super) fn new(medium: Medium, z: f64) -> Self {
        Self { medium, z, t: medium.transmittance(z), tau: medium.tau(z) }
    }

    /// Transfer function of the light scattered twice or more.
    fn multiple(&self, k: f64) -> f64 {
        let x = self.tau * self.medium.phase().mean_planar_transform(k * self.z);
        // exp(x) - 1 - x cancels below 1e-3, where three terms of the series are exact to 1e-13.
        match x {
            _ if x < 1e-3 => self.t * x * x * (0.5 + x * (1.0 / 6.0 + x / 24.0)),
            _ if x < 1.0 => self.t * (x.exp_m1() - x),
            _ => (x - self.medium.sigma_t() * self.z).exp() - self.t * (1.0 + x),
        }
    }

    fn k_scale(&self) -> f64 {
        1.0 / self.width()
    }
}

impl SpreadKernel for SmallAngle {
    fn path_length(&self) -> f64 {
        self.z
    }

    fn medium(&self) -> &Medium {
        &self.medium
    }

    fn scattered_transfer(&self, k: f64) -> Dual {
        let (z, t, tau) = (self.z, self.t, self.tau);
        let f = self.medium.phase().mean_planar_transform(k * z);
        let whole = (tau * f - self.medium.sigma_t() * z).exp();
        // M - T cancels where little is scattered; T (exp(tau F) - 1) overflows where much is.
        let value = if tau * f < 1.0 { t * (tau * f).exp_m1() } else { whole - t };
        let d_f = self.medium.phase().mean_planar_transform_derivative(k * z);
        Dual { value, gradient: [z * (whole * f - value), -z * value, whole * tau * d_f] }
    }

    fn psf(&self, r: f64) -> f64 {
        let once = self.t * self.tau * self.medium.phase().single_scatter_psf(r, self.z);
        once + hankel::inverse_j0(|k| self.multiple(k), r, self.k_scale())
    }

    fn encircled_energy(&self, r: f64) -> f64 {
        let once = self.t * self.tau * self.medium.phase().single_scatter_encircled(r, self.z);
        once + hankel::encircled_j1(|k| self.multiple(k), r, self.k_scale())
    }

    fn width(&self) -> f64 {
        self.z * self.medium.phase().planar_width()
    }
}
