//! One path through the medium: its position, its direction and its length so far.
//!
//! Positions are f32. One step adds a relative rounding of 6e-8 of the coordinate, some 1e-7 of the depth after
//! hundreds of steps, while the narrowest spread of interest is 1e-3 of it; tallies are summed in f64.

use super::rng::Stream;
use crate::phase::PhaseFunction;
use glam::Vec3;

/// Position, direction of propagation and length so far of one path.
#[derive(Debug, Clone, Copy)]
pub struct Path {
    /// Position (length).
    pub position: Vec3,
    /// Direction of propagation, a unit vector.
    pub direction: Vec3,
    /// Its length in the medium so far.
    pub length: f32,
}

impl Path {
    /// A path that starts at `position` in the unit direction `direction`.
    pub fn new(position: Vec3, direction: Vec3) -> Self {
        Self { position, direction, length: 0.0 }
    }

    /// Moves on by `distance`.
    #[inline]
    pub fn advance(&mut self, distance: f32) {
        self.position += self.direction * distance;
        self.length += distance;
    }

    /// Turns into a direction drawn from `phase`. Returns the angle between the two, rad.
    #[inline]
    pub fn scatter(&mut self, phase: &impl PhaseFunction, stream: &mut Stream) -> f32 {
        let deflection = phase.sample(&mut || stream.uniform());
        self.direction = turned(self.direction, deflection);
        deflection[0].atan2(deflection[1])
    }
}

/// A free distance in a medium of scattering coefficient `sigma_s` (1/length): density sigma_s exp(-sigma_s t).
///
/// At most 16.6 mean free paths, the logarithm of the smallest of 2^24 uniform numbers: what is cut off has
/// probability 6e-8. Infinite in a medium that does not scatter.
#[inline]
pub fn free_path(sigma_s: f32, stream: &mut Stream) -> f32 {
    if sigma_s > 0.0 { -stream.uniform_above_zero().ln() / sigma_s } else { f32::INFINITY }
}

/// The unit vector `n` turned by a deflection [sin theta, cos theta, cos phi, sin phi].
///
/// The frame about `n` is Duff et al.'s (JCGT 6(1), 2017), without branches and accurate for every direction.
#[inline]
fn turned(n: Vec3, [sin, cos, cos_phi, sin_phi]: [f32; 4]) -> Vec3 {
    let sign = 1.0_f32.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let first = Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let second = Vec3::new(b, sign + n.y * n.y * a, -n.y);
    let m = first * (sin * cos_phi) + second * (sin * sin_phi) + n * cos;
    // One Newton step of 1/|m|: rounding would otherwise add up over many scatterings.
    m * (1.5 - 0.5 * m.length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::Gaussian;

    #[test]
    fn a_turn_has_its_angle_from_every_direction() {
        let (sin, cos) = 0.3_f32.sin_cos();
        for n in [Vec3::Z, -Vec3::Z, Vec3::X, -Vec3::Y, Vec3::new(1e-4, -1e-4, -1.0).normalize()] {
            for phi in [0.0_f32, 1.0, 2.5, 4.0] {
                let m = turned(n, [sin, cos, phi.cos(), phi.sin()]);
                assert!((m.dot(n) - cos).abs() < 3e-7 && (m.length() - 1.0).abs() < 2e-7, "{n} {phi}");
            }
        }
    }

    #[test]
    fn the_azimuth_turns_a_full_circle() {
        let (sin, cos) = 0.3_f32.sin_cos();
        let n = Vec3::new(0.6, 0.0, -0.8);
        let at = |phi: f32| turned(n, [sin, cos, phi.cos(), phi.sin()]);
        let opposite = (at(1.0) + at(1.0 + std::f32::consts::PI)).normalize();
        assert!(opposite.distance(n) < 1e-6);
    }

    #[test]
    fn directions_stay_unit_vectors_over_thousands_of_scatterings() {
        let phase = Gaussian::new(0.3).unwrap();
        let mut stream = Stream::new(Stream::key(3), 0);
        let mut path = Path::new(Vec3::ZERO, Vec3::Z);
        for _ in 0..100_000 {
            path.scatter(&phase, &mut stream);
            assert!((path.direction.length() - 1.0).abs() < 5e-7);
        }
    }
}
