//! `beer-lambert`: direct light only. Determines sigma_t only.

use super::{Dual, SpreadKernel};
use crate::medium::Medium;

pub(super) struct BeerLambert {
    medium: Medium,
    z: f64,
}

impl BeerLambert {
    pub(super) fn new(medium: Medium, z: f64) -> Self {
        Self { medium, z }
    }
}

impl SpreadKernel for BeerLambert {
    fn path_length(&self) -> f64 {
        self.z
    }

    fn medium(&self) -> &Medium {
        &self.medium
    }

    fn spreads(&self) -> bool {
        false
    }

    fn scattered_transfer(&self, _k: f64) -> Dual {
        Dual::default()
    }

    fn psf(&self, _r: f64) -> f64 {
        0.0
    }

    fn encircled_energy(&self, _r: f64) -> f64 {
        0.0
    }

    fn width(&self) -> f64 {
        0.0
    }
}
