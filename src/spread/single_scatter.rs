//! `single-scatter`: light scattered exactly once, M - T = T tau F(kz).
//!
//! For the Gaussian phase function Psi_1 = sigma_s exp(-sigma_t z) / (4 sqrt(pi B) r) · erfc(r / (2 z sqrt(B))), which is
//! Shinya et al., eq. 25, with the prefactor that follows from its derivation. Total T tau.

use super::{Dual, SpreadKernel};
use crate::medium::Medium;
use crate::phase::PhaseFunction;

pub(super) struct SingleScatter {
    medium: Medium,
    z: f64,
    once: f64,
}

impl SingleScatter {
    pub(super) fn new(medium: Medium, z: f64) -> Self {
        let once = medium.transmittance(z) * medium.tau(z);
        Self { medium, z, once }
    }
}

impl SpreadKernel for SingleScatter {
    fn path_length(&self) -> f64 {
        self.z
    }

    fn medium(&self) -> &Medium {
        &self.medium
    }

    fn scattered_transfer(&self, k: f64) -> Dual {
        let (z, t) = (self.z, self.medium.transmittance(self.z));
        let f = self.medium.phase().mean_planar_transform(k * z);
        let value = self.once * f;
        let d_b = self.once * self.medium.phase().mean_planar_transform_derivative(k * z);
        Dual { value, gradient: [z * t * f - z * value, -z * value, d_b] }
    }

    fn psf(&self, r: f64) -> f64 {
        self.once * self.medium.phase().single_scatter_psf(r, self.z)
    }

    fn encircled_energy(&self, r: f64) -> f64 {
        self.once * self.medium.phase().single_scatter_encircled(r, self.z)
    }

    fn width(&self) -> f64 {
        self.z * self.medium.phase().planar_width()
    }
}
