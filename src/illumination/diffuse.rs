//! The delta-Eddington approximation: diffuse light in a plane-parallel medium as I0 + I1 cos.
//!
//! Joseph, Wiscombe and Weinman (1976). Their scaling with f = g² takes the forward peak for unscattered light,
//! sigma_s' = sigma_s (1 - g²), g' = g/(1 + g); then, with tau = sigma_t' h, omega = sigma_s'/sigma_t' and beam irradiance
//! E0 exp(-tau/mu0),
//!
//! ```text
//! dI1/dtau = -3 (1 - omega) I0 + 3 q exp(-tau/mu0)             q = omega E0/(4 pi)
//! dI0/dtau = -(1 - omega g') I1 + 3 g' mu0 q exp(-tau/mu0)
//! I0 = A exp(-k tau) + C exp(-k (tau_max - tau)) - alpha exp(-tau/mu0)
//! I1 = P [A exp(-k tau) - C exp(-k (tau_max - tau))] - beta exp(-tau/mu0)
//! k² = 3 (1 - omega)(1 - omega g'),  P = k/(1 - omega g')
//! ```
//!
//! A and C follow from: no diffuse light comes in through the surface, F_down(0) = 0; the bottom is Lambertian,
//! F_up = rho (F_down + mu0 E0 exp(-tau_max/mu0)); F = pi (I0 ± 2/3 I1).

use crate::error::{Result, in_range};
use crate::medium::Medium;
use std::f64::consts::PI;

/// What bounds the medium below.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bottom {
    depth: f64,
    reflectance: f64,
}

impl Bottom {
    /// A Lambertian bottom of `reflectance` at `depth` (length) below the surface.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) that names `bottom` or `reflectance` unless `depth` is above 0 and
    /// finite and `reflectance` between 0 and 1.
    pub fn new(depth: f64, reflectance: f64) -> Result<Self> {
        in_range("bottom", depth, depth > 0.0 && depth.is_finite(), "finite and above 0 (length)")?;
        let ok = (0.0..=1.0).contains(&reflectance);
        in_range("bottom_reflectance", reflectance, ok, "between 0 and 1")?;
        Ok(Self { depth, reflectance })
    }

    /// No bottom: the medium is infinitely deep.
    pub const NONE: Self = Self { depth: f64::INFINITY, reflectance: 0.0 };

    /// The same without its light.
    pub fn black(self) -> Self {
        Self { reflectance: 0.0, ..self }
    }

    /// Depth of the bottom below the surface, length.
    pub fn depth(&self) -> f64 {
        self.depth
    }
}

/// Least absorbed share 1 - omega of scattered light: where k is 0 the exponentials coincide. It costs 1e-5 of the light
/// that an infinite conservative medium returns, and 1e-10 of that of a finite one.
const LEAST_ABSORBED: f64 = 1e-10;

/// Where k mu0 is this close to 1, the light's direction is moved by as much: alpha has a pole there, which A and C
/// cancel.
const RESONANCE: f64 = 1e-6;

/// coefficient · exp(-(offset + rate h)), h in lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exponential {
    pub coefficient: f64,
    pub offset: f64,
    pub rate: f64,
}

impl Exponential {
    fn at(&self, h: f64) -> f64 {
        self.coefficient * (-(self.offset + self.rate * h)).exp()
    }
}

/// The phase function of the scaled medium. The approximation needs only its mean cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanCosine(pub f64);

/// The diffuse radiance I0(h) + I1(h) cos, cos to the inward normal, of beam irradiance 1.
#[derive(Debug, Clone)]
pub struct DiffuseField {
    scaled: Medium<MeanCosine>,
    mu0: f64,
    i0: [Exponential; 3],
    i1: [Exponential; 3],
}

impl DiffuseField {
    /// The field in `medium` lit at cosine `mu0`.
    ///
    /// # Errors
    /// None that a [`Medium`] could cause; as [`Medium::new`].
    pub fn new(medium: Medium<MeanCosine>, mu0: f64, bottom: Bottom) -> Result<Self> {
        let MeanCosine(g) = *medium.phase();
        let scaled_sigma_s = medium.sigma_s() * (1.0 - g * g);
        let scaled = Medium::new(scaled_sigma_s, medium.sigma_a(), MeanCosine(g / (1.0 + g)))?;
        let MeanCosine(g) = *scaled.phase();
        let omega = scaled.albedo().min(1.0 - LEAST_ABSORBED);
        let k = (3.0 * (1.0 - omega) * (1.0 - omega * g)).sqrt();
        let mu0 = if (k * mu0 - 1.0).abs() < RESONANCE { mu0 * (1.0 - RESONANCE) } else { mu0 };
        let q = omega / (4.0 * PI);
        let alpha = 3.0 * q * mu0 * mu0 * (1.0 + g * (1.0 - omega)) / (1.0 - (k * mu0).powi(2));
        let beta = (alpha / mu0 - 3.0 * g * mu0 * q) / (1.0 - omega * g);
        let p = k / (1.0 - omega * g);

        let (beam, rate) = (scaled.sigma_t() / mu0, k * scaled.sigma_t());
        let offset = if rate > 0.0 { rate * bottom.depth } else { 0.0 };
        let (across, left) = ((-offset).exp(), (-beam * bottom.depth).exp());
        let left = if left.is_nan() { 1.0 } else { left };
        // F_down/pi and F_up/pi of 1·A, 1·C at their own end, and of the beam.
        let (with, against) = (1.0 + 2.0 / 3.0 * p, 1.0 - 2.0 / 3.0 * p);
        let (down, up) = (alpha + 2.0 / 3.0 * beta, alpha - 2.0 / 3.0 * beta);
        let rho = bottom.reflectance;
        let rows = [[with, against * across], [(against - rho * with) * across, with - rho * against]];
        let right = [down, left * (up - rho * down + rho * mu0 / PI)];
        let determinant = rows[0][0] * rows[1][1] - rows[0][1] * rows[1][0];
        let a = (right[0] * rows[1][1] - rows[0][1] * right[1]) / determinant;
        let c = (rows[0][0] * right[1] - right[0] * rows[1][0]) / determinant;

        let falling = |coefficient, rate| Exponential { coefficient, offset: 0.0, rate };
        // No light comes up from an infinitely deep bottom.
        let rising = |coefficient| match offset.is_finite() {
            true => Exponential { coefficient, offset, rate: -rate },
            false => falling(0.0, 0.0),
        };
        Ok(Self {
            scaled,
            mu0,
            i0: [falling(a, rate), rising(c), falling(-alpha, beam)],
            i1: [falling(p * a, rate), rising(-p * c), falling(-beta, beam)],
        })
    }

    /// The medium of sigma_s', sigma_a and g'.
    pub fn scaled(&self) -> Medium<MeanCosine> {
        self.scaled
    }

    /// Share exp(-sigma_t' h/mu0) of the light that is left in the beam or its forward peak at depth `h`.
    pub fn beam(&self, h: f64) -> f64 {
        (-self.scaled.sigma_t() * h / self.mu0).exp()
    }

    /// I0 at depth `h`, per beam irradiance.
    pub fn i0(&self, h: f64) -> f64 {
        self.i0.iter().map(|term| term.at(h)).sum()
    }

    /// I1 at depth `h`, per beam irradiance.
    pub fn i1(&self, h: f64) -> f64 {
        self.i1.iter().map(|term| term.at(h)).sum()
    }

    /// Diffuse irradiance at depth `h` of a surface whose normal has the cosine `facing` to the medium's outward one:
    /// pi (I0 + 2/3 facing I1), at least 0.
    pub fn irradiance(&self, h: f64, facing: f64) -> f64 {
        PI * (self.i0(h) + 2.0 / 3.0 * facing * self.i1(h)).max(0.0)
    }

    /// sigma_s' [I0 + g' cos I1] along depth: what is scattered towards `cosine` to the inward normal, per length.
    pub(super) fn source(&self, cosine: f64) -> impl Iterator<Item = Exponential> + '_ {
        let MeanCosine(g) = *self.scaled.phase();
        let sum = move |(i0, i1): (&Exponential, &Exponential)| {
            let coefficient = self.scaled.sigma_s() * (i0.coefficient + g * cosine * i1.coefficient);
            Exponential { coefficient, ..*i0 }
        };
        self.i0.iter().zip(&self.i1).map(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(sigma_s: f64, sigma_a: f64, g: f64, mu0: f64, bottom: Bottom) -> DiffuseField {
        DiffuseField::new(Medium::new(sigma_s, sigma_a, MeanCosine(g)).unwrap(), mu0, bottom).unwrap()
    }

    fn flux_up(f: &DiffuseField, h: f64) -> f64 {
        f.irradiance(h, -1.0)
    }

    /// Net flux downwards of beam and diffuse light.
    fn net(f: &DiffuseField, mu0: f64, h: f64) -> f64 {
        mu0 * f.beam(h) + 4.0 / 3.0 * PI * f.i1(h)
    }

    #[test]
    fn the_field_obeys_its_equations() {
        for (sigma_a, mu0, bottom) in
            [(0.3, 0.7, Bottom::new(2.0, 0.4).unwrap()), (0.05, 0.3, Bottom::NONE), (0.7, 1.0, Bottom::NONE)]
        {
            let f = field(1.3, sigma_a, 0.6, mu0, bottom);
            let (sigma_t, omega, g) = (f.scaled().sigma_t(), f.scaled().albedo(), 0.6 / 1.6);
            let q = omega / (4.0 * PI);
            for h in [0.1, 0.8, 1.7] {
                let slope =
                    |i: fn(&DiffuseField, f64) -> f64| (i(&f, h + 1e-5) - i(&f, h - 1e-5)) / (2e-5 * sigma_t);
                let beam = f.beam(h);
                let wanted_i1 = -3.0 * (1.0 - omega) * f.i0(h) + 3.0 * q * beam;
                let wanted_i0 = -(1.0 - omega * g) * f.i1(h) + 3.0 * g * mu0 * q * beam;
                // Central differences of step 1e-5: 1e-10 of rounding.
                assert!((slope(DiffuseField::i1) - wanted_i1).abs() < 1e-8, "{h}");
                assert!((slope(DiffuseField::i0) - wanted_i0).abs() < 1e-8, "{h}");
            }
        }
    }

    #[test]
    fn light_enters_through_the_surface_alone_and_the_bottom_reflects_its_share() {
        let f = field(2.0, 0.1, 0.8, 0.6, Bottom::new(1.5, 0.35).unwrap());
        assert!((f.i0(0.0) + 2.0 / 3.0 * f.i1(0.0)).abs() < 1e-14);
        let down = f.irradiance(1.5, 1.0) + 0.6 * f.beam(1.5);
        assert!((flux_up(&f, 1.5) - 0.35 * down).abs() < 1e-14);
    }

    #[test]
    fn nothing_is_lost_without_absorption() {
        for bottom in [Bottom::NONE, Bottom::new(3.0, 1.0).unwrap()] {
            let f = field(2.0, 0.0, 0.9, 0.8, bottom);
            // All that enters comes back; see LEAST_ABSORBED.
            assert!((flux_up(&f, 0.0) - 0.8).abs() < 3e-5, "{}", flux_up(&f, 0.0));
        }
        let f = field(2.0, 0.0, 0.9, 0.8, Bottom::new(3.0, 0.2).unwrap());
        let through = net(&f, 0.8, 3.0);
        assert!([0.0, 0.4, 2.9].iter().all(|&h| (net(&f, 0.8, h) - through).abs() < 1e-8));
        assert!((flux_up(&f, 0.0) + through - 0.8).abs() < 1e-8);
    }

    #[test]
    fn without_scattering_only_the_bottom_gives_diffuse_light() {
        let f = field(0.0, 0.5, 0.9, 0.5, Bottom::new(1.0, 0.0).unwrap());
        assert!([0.0, 0.5, 1.0].iter().all(|&h| f.i0(h) == 0.0 && f.i1(h) == 0.0));
        let f = field(0.0, 0.5, 0.9, 0.5, Bottom::new(1.0, 0.6).unwrap());
        // Linear in cos, light that only goes up has a small negative flux downwards.
        let down = PI * (f.i0(1.0) + 2.0 / 3.0 * f.i1(1.0));
        assert!(down < 0.0 && down > -0.1 * flux_up(&f, 1.0) && f.irradiance(1.0, 1.0) == 0.0);
        assert!((flux_up(&f, 1.0) - 0.6 * (0.5 * f.beam(1.0) + down)).abs() < 1e-14);
        // A vacuum without end.
        let f = field(0.0, 0.0, 0.9, 0.5, Bottom::NONE);
        assert_eq!((f.i0(1.0), f.i1(1.0), f.beam(1.0)), (0.0, 0.0, 1.0));
    }

    #[test]
    fn the_resonance_of_beam_and_diffuse_light_is_no_pole() {
        // k mu0 = 1 for isotropic scattering of omega 2/3 and mu0 = 1.
        let near = |sigma_a: f64| field(2.0, sigma_a, 0.0, 1.0, Bottom::NONE).i0(0.7);
        assert!((near(1.0) / near(1.0 + 1e-4) - 1.0).abs() < 1e-3);
        assert!((near(1.0) / near(1.0 - 1e-4) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn deep_media_neither_overflow_nor_lose_their_bottom() {
        let f = field(1e4, 1e4, 0.5, 0.9, Bottom::new(10.0, 1.0).unwrap());
        assert!([0.0, 1e-4, 10.0].iter().all(|&h| f.i0(h).is_finite() && f.i1(h).is_finite()));
        assert_eq!(f.i0(10.0), 0.0);
    }
}
