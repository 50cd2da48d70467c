//! Figure 5: the relative rms error of the kernels against the spread angle, sigma_t = 1, sigma_s = 0.95, at z = 1, 2, 3.
//!
//! The paper does not define its error. Ours is that of 2 pi r Psi over 0 < r < 3 z, see [`crate::lab::compare::rms_error`].

use super::{ALBEDO, Effort, Experiment, Plane};

/// Rings between the axis and r = 3 z: at 5 degrees, four of them to a kernel width z sqrt(B).
pub const RINGS: usize = 300;

/// Radii up to this many depths count.
pub const REACH: usize = 3;

/// z = 1, 2, 3, each with rings of a width in proportion.
pub(super) fn planes() -> Vec<Plane> {
    [1, 2, 3].map(|steps| Plane { z: steps as f64, steps }).to_vec()
}

/// Paths of one experiment.
pub(super) fn paths(effort: Effort) -> u64 {
    match effort {
        Effort::Full => 20_000_000,
        Effort::Quick => 400_000,
    }
}

/// One experiment per spread angle, from 5 to 60 degrees.
pub fn experiments(effort: Effort) -> Vec<Experiment> {
    let experiment = |i: u64| Experiment {
        albedo: ALBEDO,
        spread_angle_deg: 5.0 * i as f64,
        planes: planes(),
        rings: RINGS,
        step: REACH as f64 / RINGS as f64,
        paths: paths(effort),
        seed: 500 + i,
    };
    (1..=12).map(experiment).collect()
}
