//! Figure 4: maps of 2 pi r Psi over (r, z) for several spread angles, sigma_t = 1, sigma_s = 0.95.

use super::{ALBEDO, Effort, Experiment, Plane};

/// Spread angles, degrees: one where small angles hold, one in between, one where they do not.
pub const SPREAD_ANGLES_DEG: [f64; 3] = [10.0, 30.0, 60.0];

/// Deepest plane, mean free paths.
pub const DEEPEST: f64 = 3.0;

/// Largest radius, mean free paths.
pub const FARTHEST: f64 = 1.5;

/// One experiment per spread angle: planes evenly spaced, rings of one width at all of them.
pub fn experiments(effort: Effort) -> Vec<Experiment> {
    let (planes, rings, paths) = match effort {
        Effort::Full => (60, 120, 10_000_000),
        Effort::Quick => (15, 30, 100_000),
    };
    let plane = |i: usize| Plane { z: DEEPEST * i as f64 / planes as f64, steps: 1 };
    let experiment = |(i, spread_angle_deg): (usize, f64)| Experiment {
        albedo: ALBEDO,
        spread_angle_deg,
        planes: (1..=planes).map(plane).collect(),
        rings,
        step: FARTHEST / rings as f64,
        paths,
        seed: 400 + i as u64,
    };
    SPREAD_ANGLES_DEG.into_iter().enumerate().map(experiment).collect()
}
