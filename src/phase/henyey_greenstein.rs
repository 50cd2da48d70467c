//! The Henyey-Greenstein phase function (Henyey and Greenstein 1941), for forward scattering, 0 < g < 1.
//!
//! p = (1 - g²) / (1 + g² - 2 g cos theta)^{3/2}. In small-angle theory, with a = (1-g)/sqrt(g):
//! Phat(q) = exp(-a q), F(q) = (1 - exp(-a q))/(a q). The planar second moment is infinite.

use super::{Family, PhaseFunction};
use crate::error::{Result, in_range};
use std::f64::consts::PI;

/// Henyey-Greenstein phase function of mean cosine g.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

impl HenyeyGreenstein {
    /// The Henyey-Greenstein phase function of mean cosine `g`.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless 0 < `g` < 1.
    pub fn new(g: f64) -> Result<Self> {
        Ok(Self { g: in_range("g", g, g > 0.0 && g < 1.0, "between 0 and 1, exclusive")? })
    }
}

impl PhaseFunction for HenyeyGreenstein {
    fn family(&self) -> Family {
        Family::HenyeyGreenstein
    }

    fn parameter(&self) -> f64 {
        self.g
    }

    fn eval(&self, cos_theta: f64) -> f64 {
        let g = self.g;
        (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cos_theta).powf(1.5)
    }

    /// Inversion of the distribution function. 1 - cos theta is formed without cancellation, in f64.
    fn sample(&self, uniform: &mut impl FnMut() -> f32) -> [f32; 4] {
        let (g, u) = (self.g, f64::from(uniform()));
        let d = 1.0 - g + 2.0 * g * u;
        let one_minus_cos = 2.0 * (1.0 - g) * (1.0 - g) * (1.0 - u) * (1.0 + g * u) / (d * d);
        let cos = 1.0 - one_minus_cos;
        let sin = (one_minus_cos * (2.0 - one_minus_cos)).max(0.0).sqrt();
        let (sin_phi, cos_phi) = (2.0 * std::f32::consts::PI * uniform()).sin_cos();
        [sin as f32, cos as f32, cos_phi, sin_phi]
    }

    fn mean_cosine(&self) -> f64 {
        self.g
    }

    fn planar_transform(&self, q: f64) -> f64 {
        (-self.planar_width() * q).exp()
    }

    /// dPhat/dg = -q Phat da/dg.
    fn planar_transform_derivative(&self, q: f64) -> f64 {
        -q * self.planar_transform(q) * self.planar_width_derivative()
    }

    fn mean_planar_transform(&self, q: f64) -> f64 {
        let x = self.planar_width() * q;
        if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
    }

    /// dF/dg = (Phat - F)/a · da/dg.
    fn mean_planar_transform_derivative(&self, q: f64) -> f64 {
        let slope = (self.planar_transform(q) - self.mean_planar_transform(q)) / self.planar_width();
        slope * self.planar_width_derivative()
    }

    /// a = (1-g)/sqrt(g).
    fn planar_width(&self) -> f64 {
        (1.0 - self.g) / self.g.sqrt()
    }

    /// da/dg = -(1+g)/(2 g^{3/2}).
    fn planar_width_derivative(&self) -> f64 {
        -(1.0 + self.g) / (2.0 * self.g.powf(1.5))
    }

    fn planar_second_moment(&self) -> Option<f64> {
        None
    }

    fn single_scatter_psf(&self, r: f64, z: f64) -> f64 {
        let az = self.planar_width() * z;
        (1.0 / r - 1.0 / r.hypot(az)) / (2.0 * PI * az)
    }

    fn single_scatter_encircled(&self, r: f64, z: f64) -> f64 {
        let az = self.planar_width() * z;
        1.0 - (r.hypot(az) - r) / az
    }
}
