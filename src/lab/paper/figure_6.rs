//! Figure 6: profiles of 2 pi r Psi at a low and a high albedo, spread angle 30 degrees, at z = 1, 2, 3; sigma_t = 1.

use super::figure_5::{REACH, RINGS, paths, planes};
use super::{Effort, Experiment};

/// sigma_s at sigma_t = 1.
pub const ALBEDOS: [f64; 2] = [0.7, 0.99];

/// sqrt(4 B), degrees.
pub const SPREAD_ANGLE_DEG: f64 = 30.0;

/// One experiment per albedo, in the rings of figure 5.
pub fn experiments(effort: Effort) -> Vec<Experiment> {
    let experiment = |(i, albedo): (usize, f64)| Experiment {
        albedo,
        spread_angle_deg: SPREAD_ANGLE_DEG,
        planes: planes(),
        rings: RINGS,
        step: REACH as f64 / RINGS as f64,
        paths: paths(effort),
        seed: 600 + i as u64,
    };
    ALBEDOS.into_iter().enumerate().map(experiment).collect()
}
