//! `single-scatter`: light scattered exactly once, M - T = T tau F(kz).
//!
//! For the Gaussian lobe Psi_1 = sigma_s exp(-sigma_t z) / (4 sqrt(pi B) r) · erfc(r / (2 z sqrt(B))), which is
//! Shinya et al., eq. 25, with the prefactor that its derivation gives. Total T tau.

use super::{Dual, SpreadKernel};
use crate::medium::Medium;
use crate::phase::PhaseFunction;

pub(super) struct SingleScatter<'a> {
    medium: Medium,
    phase: &'a dyn PhaseFunction,
    z: f64,
    once: f64,
}

impl<'a> SingleScatter<'a> {
    pub(super) fn new(medium: Medium, phase: &'a dyn PhaseFunction, z: f64) -> Self {
        let once = medium.transmittance(z) * medium.tau(z);
        Self { medium, phase, z, once }
    }
}

impl SpreadKernel for SingleScatter<'_> {
    fn path_length(&self) -> f64 {
        self.z
    }

    fn medium(&self) -> &Medium {
        &self.medium
    }

    fn phase(&self) -> Option<&dyn PhaseFunction> {
        Some(self.phase)
    }

    fn scattered_transfer(&self, k: f64) -> Dual {
        let (z, t) = (self.z, self.medium.transmittance(self.z));
        let f = self.phase.mean_planar_transform(k * z);
        let value = self.once * f;
        let d_b = self.once * self.phase.mean_planar_transform_derivative(k * z);
        Dual { value, gradient: [z * t * f - z * value, -z * value, d_b] }
    }

    fn psf(&self, r: f64) -> f64 {
        self.once * self.phase.single_scatter_psf(r, self.z)
    }

    fn encircled_energy(&self, r: f64) -> f64 {
        self.once * self.phase.single_scatter_encircled(r, self.z)
    }

    fn width(&self) -> f64 {
        self.z * self.phase.planar_width()
    }
}
