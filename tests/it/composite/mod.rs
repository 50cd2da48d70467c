//! The composite filter: against its definition, against what must hold whatever the kernel, and against traced light.

mod definition;
mod hidden;
mod invariants;
mod relief;
mod scenes;
mod small_angle_paths;
mod traced;
