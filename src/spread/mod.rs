//! Spread kernels: where the light of one object point lands in the object plane, seen from the camera.
//!
//! A kernel belongs to one medium and one path length z. The direct light, its share
//! T = exp(-sigma_t z), is a point; the scattered light has the density `psf(r)` per area of the object plane.
//! Nothing is normalised away: `psf` integrates to [`SpreadKernel::scattered`], the share of the light that arrives
//! scattered, and the transfer function is
//! M(k) = T + 2 pi ∫ psf(r) J0(k r) r dr, k in rad/length, so M(0) = T + scattered and M(∞) = T.
//!
//! | model | scattered transfer function | source | where it is valid |
//! | --- | --- | --- | --- |
//! | `beer-lambert` | 0 | Beer-Lambert law | scattered light under the noise |
//! | `single-scatter` | T tau F(kz) | Shinya et al., eq. 25 with its prefactor corrected | tau ≪ 1 |
//! | `gaussian` | phi exp(-k² R / (4 phi)), R exact | moment matching | tau ≫ 1, small angles |
//! | `narrow-beam-printed` | phi F(k beta/2), R of eq. 21 | Shinya et al., eq. 20, 21, 26, 28, G = erfc/2 | as published; estimates of B are too low |
//! | `narrow-beam` | phi F(k beta/2), R exact | the same kernel, exact moments | tau ≲ 2, small angles |
//! | `small-angle` | T (exp(tau F(kz)) - 1) | Wells 1969; Ishimaru 1978, ch. 13 | tau·4B ≤ 0.05 to 1 % of M |
//! | `wide-angle` | a mixture of Gaussians from a table | [`wide_angle`] | tau ≤ 12, sigma_a z ≤ 10, spread angle ≤ 60° or g ≥ 0.5 |
//!
//! The model `traced` has no kernel: `fit` and `render` trace the given scene.
//!
//! F is the mean planar transform of the phase function ([`crate::phase`]); in the moment-matched kernels it is
//! that of a Gaussian phase function, even if the medium's is another, and beta² = 3 R / phi.

mod beer_lambert;
mod dual;
mod hankel;
mod model;
mod moment_matched;
mod range;
mod single_scatter;
mod small_angle;
pub mod wide_angle;

use crate::medium::Medium;
use crate::phase::PhaseFunction;

pub use dual::Dual;
pub use model::{Model, SMALL_ANGLE_LIMIT, small_angle_error};
pub use moment_matched::{SecondMoments, second_moments};
pub use range::Range;

/// The spread of one object point's light, for one medium and path length.
pub trait SpreadKernel: Send + Sync {
    /// Path length z in the medium, length.
    fn path_length(&self) -> f64;

    /// The medium.
    fn medium(&self) -> &Medium;

    /// Share of the light that arrives unscattered, T = exp(-sigma_t z).
    fn direct(&self) -> Dual {
        let z = self.path_length();
        let t = self.medium().transmittance(z);
        Dual { value: t, gradient: [-z * t, -z * t, 0.0] }
    }

    /// Share of the light that arrives scattered: the integral of `psf`.
    fn scattered(&self) -> f64 {
        self.scattered_transfer(0.0).value
    }

    /// Transfer function M(k) - T of the scattered light at `k` rad/length.
    fn scattered_transfer(&self, k: f64) -> Dual;

    /// Transfer function M(k) of direct and scattered light together at `k` rad/length.
    fn mtf(&self, k: f64) -> Dual {
        self.direct() + self.scattered_transfer(k)
    }

    /// Whether any light is spread: not by `beer-lambert`.
    fn spreads(&self) -> bool {
        true
    }

    /// N(k), 1/length, of the paths' slope s and offset r at the object: E[s exp(i k·r)] = -i (k/k²) N(k), with
    /// N = sigma_s (Phat(kz) - 1) M(k): the joint characteristic function of (r, s) has the exponent
    /// sigma_s ∫_0^z Phat(|k u + q|) du, whose gradient in q at 0 this is, for any phase function. Kernels whose M is not
    /// the exact small-angle one use the same factor.
    ///
    /// In a perspective view rays diverge and s is relative to the ray to the landing point: s - r/rho, where rho is the
    /// distance from the camera to the object. With `nearness` = z/rho, 0 for parallel rays, Phat - 1 becomes
    /// Phat - 1 - nearness (Phat - F).
    fn mean_slope(&self, k: f64, nearness: f64) -> Dual {
        if !self.spreads() {
            return Dual::default();
        }
        let (q, sigma_s, phase) = (k * self.path_length(), self.medium().sigma_s(), self.medium().phase());
        let transform = phase.planar_transform(q);
        let correction = transform - 1.0 - nearness * (transform - phase.mean_planar_transform(q));
        let correction_in_b = (1.0 - nearness) * phase.planar_transform_derivative(q)
            + nearness * phase.mean_planar_transform_derivative(q);
        self.mtf(k)
            * Dual { value: sigma_s * correction, gradient: [correction, 0.0, sigma_s * correction_in_b] }
    }

    /// Density of the scattered light at radius `r` > 0, 1/area. Most kernels grow like 1/r towards 0.
    fn psf(&self, r: f64) -> f64;

    /// Scattered light within radius `r`, as a share of the light that set out.
    fn encircled_energy(&self, r: f64) -> f64;

    /// Radius beyond which less than the share `outside` of the scattered light falls, to a few percent; 0 if
    /// nothing is scattered.
    fn support(&self, outside: f64) -> f64 {
        self.reach(&|_| outside)
    }

    /// Least radius r beyond which less than the share `outside(r)` of the scattered light falls, to a few percent; 0 if
    /// nothing is scattered.
    fn reach(&self, outside: &dyn Fn(f64) -> f64) -> f64 {
        let scattered = self.scattered();
        if scattered < NO_LIGHT {
            return 0.0;
        }
        let radii = (0..500).map(|i| self.width() * 1.1_f64.powi(i));
        let enough = |r: &f64| {
            let outside = outside(*r);
            outside >= 1.0 || self.encircled_energy(*r) >= (1.0 - outside) * scattered
        };
        radii.clone().find(enough).or(radii.last()).expect("there are radii")
    }

    /// The length on which the kernel varies: z sqrt(B) where light is scattered once; 0 for a kernel without spread.
    fn width(&self) -> f64;
}

/// A share of light so small that its parts cannot be distinguished from rounding errors.
const NO_LIGHT: f64 = 1e-250;

/// Radius that holds 1 - 1/e of the light that small-angle theory scatters into the path length `z`: the root mean square
/// radius, for which the kernel is taken to be a Gaussian, or where that is infinite the radius itself, to a few percent. 0
/// if nothing is scattered.
pub fn typical_radius(medium: &Medium, z: f64) -> f64 {
    match second_moments(medium, z) {
        Some(moments) => {
            let scattered = medium.scattered_total(z).max(f64::MIN_POSITIVE);
            (moments.exact / scattered).sqrt()
        }
        None => small_angle::SmallAngle::new(*medium, z).support((-1.0_f64).exp()),
    }
}
