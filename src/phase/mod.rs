//! Phase functions: how a single scattering event turns the light.
//!
//! Convention: both directions are directions of *propagation*, so `cos_theta = 1` is straight ahead and the
//! mean cosine of a forward-scattering medium is positive. `eval` is normalised as in Shinya et al.,
//! (1/4pi) ∫ p dOmega = 1; `pdf` = p / 4pi is the density per steradian.
//!
//! Small-angle theory needs the *planar* phase function, which is the same function of the slopes s in a plane, through
//! its transform Phat(q) and the mean of that over the path,
//! F(q) = (1/q) ∫_0^q Phat(t) dt, since sigma_s ∫_0^z Phat(k u) du = sigma_s z F(k z).

mod either;
mod family;
mod gaussian;
mod henyey_greenstein;

pub use either::Phase;
pub use family::Family;
pub use gaussian::{Gaussian, b_of_spread_angle, encircled_erfc, mean_gaussian, mean_gaussian_slope};
pub use henyey_greenstein::HenyeyGreenstein;

/// What the tracer and the spread kernels need of a phase function.
pub trait PhaseFunction: Send + Sync + std::fmt::Debug {
    /// The family that it belongs to.
    fn family(&self) -> Family;

    /// Its parameter in that family: B, rad², or g.
    fn parameter(&self) -> f64;

    /// p(cos theta), with (1/4pi) ∫ p dOmega = 1.
    fn eval(&self, cos_theta: f64) -> f64;

    /// Density per steradian, p / 4pi.
    fn pdf(&self, cos_theta: f64) -> f64 {
        self.eval(cos_theta) / (4.0 * std::f64::consts::PI)
    }

    /// Draws a deflection. `uniform` yields independent numbers in [0, 1).
    ///
    /// Returns the sine and cosine of the polar angle and of the azimuth: `[sin theta, cos theta, cos phi, sin phi]`.
    fn sample(&self, uniform: &mut impl FnMut() -> f32) -> [f32; 4]
    where
        Self: Sized;

    /// Mean cosine g of the deflection.
    fn mean_cosine(&self) -> f64;

    /// Phat(q): transform of the planar phase function, Phat(0) = 1.
    fn planar_transform(&self, q: f64) -> f64;

    /// dPhat/d(parameter) at `q`.
    fn planar_transform_derivative(&self, q: f64) -> f64;

    /// F(q) = (1/q) ∫_0^q Phat(t) dt, F(0) = 1.
    fn mean_planar_transform(&self, q: f64) -> f64;

    /// dF/d(parameter) at `q`.
    fn mean_planar_transform_derivative(&self, q: f64) -> f64;

    /// The angle on which the planar phase function varies: sqrt(B) or a, rad.
    fn planar_width(&self) -> f64;

    /// Its derivative in the parameter.
    fn planar_width_derivative(&self) -> f64;

    /// Planar second moment <s²>, rad²; `None` where it is infinite.
    fn planar_second_moment(&self) -> Option<f64>;

    /// Density at radius `r`, per area, of u·s for u uniform on (0, `z`) and s drawn from the planar phase
    /// function: where singly scattered light lands. The 2-D transform of F(k z).
    fn single_scatter_psf(&self, r: f64, z: f64) -> f64;

    /// Share of that density within radius `r`.
    fn single_scatter_encircled(&self, r: f64, z: f64) -> f64;
}
