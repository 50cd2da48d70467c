//! The veil along a ray, in closed form.

use super::Sun;
use super::diffuse::{Bottom, DiffuseField, Exponential, MeanCosine};
use crate::error::Result;
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use glam::DVec3;
use std::f64::consts::PI;

/// A plane-parallel medium under parallel light, one channel.
#[derive(Debug)]
pub struct PlaneParallel {
    sun: Sun,
    irradiance: f64,
    bottom: Bottom,
    medium: Medium,
    /// Without light from the bottom: the veil is light that has met no object.
    field: DiffuseField,
    /// With light from the bottom: what lights objects.
    lit: DiffuseField,
}

impl PlaneParallel {
    /// `medium` under light of `irradiance` on a plane perpendicular to it.
    ///
    /// # Errors
    /// As [`DiffuseField::new`].
    pub fn new(sun: Sun, irradiance: f64, bottom: Bottom, medium: Medium) -> Result<Self> {
        let coarse = medium.with_phase(MeanCosine(medium.phase().mean_cosine()));
        let field = |bottom| DiffuseField::new(coarse, sun.mu0(), bottom);
        let (field, lit) = (field(bottom.black())?, field(bottom)?);
        Ok(Self { sun, irradiance, bottom, medium, field, lit })
    }

    /// The light and the surface.
    pub fn sun(&self) -> Sun {
        self.sun
    }

    /// Radiance scattered to the camera from the first `z` of the path of a ray that leaves the camera along the unit
    /// vector `ray` and enters the medium (its cosine to the inward normal is above 0). Without an object `z` is
    /// infinite: the bottom ends the path.
    pub fn veil(&self, ray: DVec3, z: f64) -> f64 {
        if self.medium.sigma_s() == 0.0 {
            return 0.0;
        }
        let mu = -ray.dot(self.sun.normal());
        let z = z.min(self.bottom.depth() / mu);
        let sigma_t = self.field.scaled().sigma_t();
        let integral = |term: Exponential| {
            term.coefficient * exponential_integral(term.offset, sigma_t + term.rate * mu, z)
        };
        self.irradiance * self.source(ray).map(integral).sum::<f64>()
    }

    /// J(h) of beam irradiance 1, towards the camera.
    fn source(&self, ray: DVec3) -> impl Iterator<Item = Exponential> + '_ {
        let p = self.medium.phase().eval(-ray.dot(self.sun.direction()));
        let once = Exponential {
            coefficient: self.medium.sigma_s() * p / (4.0 * PI),
            offset: 0.0,
            rate: self.field.scaled().sigma_t() / self.sun.mu0(),
        };
        std::iter::once(once).chain(self.field.source(ray.dot(self.sun.normal())))
    }

    /// Irradiance at depth `h` on a surface of outward unit normal `normal` that clear light would meet with the share
    /// `shading` of its irradiance: the cosine, or 0 in a shadow.
    pub fn irradiance(&self, h: f64, normal: DVec3, shading: f64) -> f64 {
        let diffuse = self.lit.irradiance(h, normal.dot(self.sun.normal()));
        self.irradiance * (shading * self.lit.beam(h) + diffuse)
    }
}

/// ∫_0^z exp(-(offset + rate t)) dt without overflow, where offset and offset + rate z are at least 0.
fn exponential_integral(offset: f64, rate: f64, z: f64) -> f64 {
    let x = rate * z;
    if x.abs() < 1.0 {
        let mean = if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x };
        (-offset).exp() * mean * z
    } else {
        ((-offset).exp() - (-(offset + x)).exp()) / rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::Gaussian;
    use crate::quadrature::integrate;

    fn scene(medium: Medium, direction: DVec3, bottom: Bottom) -> PlaneParallel {
        let sun = Sun::new(direction, DVec3::new(0.1, -0.2, -1.0)).unwrap();
        PlaneParallel::new(sun, 2.0, bottom, medium).unwrap()
    }

    fn medium(sigma_s: f64, sigma_a: f64, phase: Gaussian) -> Medium {
        Medium::new(sigma_s, sigma_a, phase.into()).unwrap()
    }

    fn ray() -> DVec3 {
        DVec3::new(-0.2, 0.1, 1.0).normalize()
    }

    #[test]
    fn the_closed_form_is_the_integral_of_its_source() {
        let phase = Gaussian::new(0.1).unwrap();
        for (bottom, z) in [
            (Bottom::NONE, 2.5),
            (Bottom::new(3.0, 0.5).unwrap(), 2.5),
            (Bottom::new(1.0, 0.5).unwrap(), 0.01),
        ] {
            let s = scene(medium(1.2, 0.2, phase), DVec3::new(0.4, 0.1, 0.8), bottom);
            let (n, f) = (s.sun.normal(), &s.field);
            let (mu, sigma_t) = (-ray().dot(n), f.scaled().sigma_t());
            let p = phase.eval(-ray().dot(s.sun.direction()));
            let g = phase.mean_cosine();
            let along = |t: f64| {
                let h = mu * t;
                let once = 1.2 * p / (4.0 * PI) * f.beam(h);
                let more = f.scaled().sigma_s() * (f.i0(h) - g / (1.0 + g) * mu * f.i1(h));
                2.0 * (-sigma_t * t).exp() * (once + more)
            };
            let wanted = integrate(0.0, z, 4, along);
            assert!((s.veil(ray(), z) / wanted - 1.0).abs() < 1e-12, "{z}");
        }
    }

    #[test]
    fn a_thin_veil_is_single_scattering() {
        let phase = Gaussian::new(2.0).unwrap();
        let s = scene(medium(1e-5, 0.0, phase), DVec3::new(0.4, 0.1, 0.8), Bottom::new(1.0, 0.0).unwrap());
        let wanted = 2.0 * 1e-5 * phase.pdf(-ray().dot(s.sun.direction())) * 0.7;
        // What is scattered twice is of order tau.
        assert!((s.veil(ray(), 0.7) / wanted - 1.0).abs() < 1e-4);
        assert_eq!(scene(medium(0.0, 0.3, phase), DVec3::Z, Bottom::NONE).veil(ray(), 1.0), 0.0);
        assert_eq!(scene(medium(0.0, 0.0, phase), DVec3::Z, Bottom::NONE).veil(ray(), f64::INFINITY), 0.0);
    }

    #[test]
    fn light_scattered_once_goes_both_ways_alike() {
        // Exchanging light and camera leaves (mu0 + mu) veil/mu0 as it was (Chandrasekhar 1960, section 13). Of a medium
        // that absorbs nearly all, single scattering is all there is.
        let phase = Gaussian::new(1.0).unwrap();
        let normal = DVec3::NEG_Z;
        let (a, b) = (DVec3::new(0.5, 0.0, 1.0).normalize(), DVec3::new(-0.1, 0.3, 1.0).normalize());
        let veil = |light: DVec3, ray: DVec3| {
            let medium = medium(1e-6, 1.0, phase);
            let sun = Sun::new(light, normal).unwrap();
            let s = PlaneParallel::new(sun, 1.0, Bottom::NONE, medium).unwrap();
            s.veil(ray, f64::INFINITY) / sun.mu0()
        };
        assert!((veil(a, b) / veil(b, a) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_veil_grows_with_the_path_and_ends_at_the_bottom() {
        let phase = Gaussian::new(0.05).unwrap();
        let s = scene(medium(2.0, 0.1, phase), DVec3::new(0.4, 0.1, 0.8), Bottom::new(3.0, 0.3).unwrap());
        let veils: Vec<f64> = [0.0, 0.5, 1.0, 2.0, 1e3, f64::INFINITY].map(|z| s.veil(ray(), z)).to_vec();
        assert!(veils[0] == 0.0 && veils.windows(2).take(4).all(|w| w[0] < w[1]) && veils[4] == veils[5]);
    }

    #[test]
    fn light_that_never_enters_is_refused_by_name() {
        let wrong = Sun::new(DVec3::new(0.0, 0.3, -1.0), DVec3::NEG_Z).unwrap_err().to_string();
        assert!(wrong.contains("direction") && wrong.contains("never enters"), "{wrong}");
        assert!(Sun::new(DVec3::X, DVec3::NEG_Z).is_err());
        assert!(Sun::new(DVec3::ZERO, DVec3::NEG_Z).unwrap_err().to_string().contains("direction"));
        assert!(Sun::new(DVec3::Z, DVec3::NAN).unwrap_err().to_string().contains("normal"));
    }
}
