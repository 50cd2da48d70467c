//! Scene files: what is refused, and how the rest is understood.

mod bad_input;
pub(crate) mod folder;
mod layers;
mod phase;
mod rules;
