//! Traced images against what is known exactly, and against the radial tallies.

mod layers;
mod planes_and_maps;
mod setup;
