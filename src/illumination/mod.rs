//! Light that falls into the medium: the veil that it scatters to the camera, and the light that it gives to objects.
//!
//! The medium is plane-parallel: flat, index-matched, endless sideways, lit from above by parallel light. Depth h is
//! measured from its surface along the inward normal, mu0 and mu are the cosines of the light's and of the ray's
//! direction to it. Objects cast no shadows into the medium and do not light one another. The veil is light that
//! has met no object, since the filter computes the light of objects. So its I0 and I1 are those above a black bottom, while
//! E has those above the real bottom.
//!
//! ```text
//! veil(z)  = ∫_0^z exp(-sigma_t' t) J(mu t) dt                                       along the ray
//! J(h)     = sigma_s p(theta)/(4 pi) E0 exp(-sigma_t' h/mu0)                         scattered once
//!          + sigma_s' [ I0(h) - g' mu I1(h) ]                                        scattered more often
//! E(h)     = c E0 exp(-sigma_t' h/mu0) + pi [ I0(h) + 2/3 (m·n) I1(h) ]              on a surface of normal m
//! ```
//!
//! The diffuse radiance I0 + I1 cos is that of the delta-Eddington approximation (Joseph, Wiscombe and Weinman, J.
//! Atmos. Sci. 33, 2452, 1976; [`DiffuseField`]), primes mark its coefficients: light in the forward peak, the share g²
//! of what is scattered, continues as if unscattered. J is its source function, in which single scattering is exact
//! (Nakajima and Tanaka, J. Quant. Spectrosc. Radiat. Transfer 40, 51, 1988, their TMS method). So the veil is a sum
//! of exponentials in closed form.
//!
//! `docs/synthesis.md` compares this with light traced without approximations.

mod diffuse;
mod object;
mod veil;

pub use diffuse::{Bottom, DiffuseField, MeanCosine};
pub use object::{Shading, lit_radiance};
pub use veil::PlaneParallel;

use crate::error::{Result, in_range};
use glam::DVec3;

/// Parallel light and the flat surface through which it enters the medium. Camera axes: x right, y down, z away.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sun {
    direction: DVec3,
    normal: DVec3,
}

impl Sun {
    /// Light that travels along `direction` through a surface of normal `normal`, which points out of the medium; both
    /// of any length.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) that names `direction` or `normal` unless both are finite and not
    /// zero, and the light enters: cosine above 0.
    pub fn new(direction: DVec3, normal: DVec3) -> Result<Self> {
        for (name, vector) in [("direction", direction), ("normal", normal)] {
            let length = vector.length();
            in_range(name, length, length.is_finite() && length > 0.0, "of a length above 0 and finite")?;
        }
        let sun = Self { direction: direction.normalize(), normal: normal.normalize() };
        let allowed = "above 0: the light never enters the medium";
        in_range("direction: its cosine to the inward normal", sun.mu0(), sun.mu0() > 0.0, allowed)?;
        Ok(sun)
    }

    /// Cosine of the light's direction to the inward normal, above 0.
    pub fn mu0(&self) -> f64 {
        -self.direction.dot(self.normal)
    }

    /// Unit vector along which the light travels.
    pub fn direction(&self) -> DVec3 {
        self.direction
    }

    /// Unit normal of the surface, out of the medium.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
}
