//! The experiments of M. Shinya, Y. Dobashi, M. Shiraishi, T. Nishita, *Rendering Objects in Random Scattering Media with
//! the Narrow Beam Theory*, section 5, as numbers: traced light against every kernel of [`Model::ALL`].
//!
//! A pencil beam enters the half-space z > 0 on the axis (their fig. 3); what crosses a plane is counted by radius. Lengths
//! are in units of the mean free path: sigma_t = 1 throughout. The phase function is Gaussian, of spread angle
//! sqrt(4 B). Like the paper we look at 2 pi r Psi(r), as Psi itself is singular at r = 0.
//!
//! | figure | what varies | what is compared |
//! | --- | --- | --- |
//! | [4](figure_4) | spread angle; sigma_s = 0.95 | maps over (r, z) |
//! | [5](figure_5) | spread angle 5 to 60 degrees; sigma_s = 0.95 | relative rms error at z = 1, 2, 3 |
//! | [6](figure_6) | albedo 0.7 and 0.99; 30 degrees | profiles at z = 1, 2, 3 |
//! | [8](figure_8) | - | no experiment: a picture synthesized from depths and reflectance |
//!
//! `narrowbeam reproduce` draws them; docs/paper.md compares the results with the paper's claims.

pub mod figure_4;
pub mod figure_5;
pub mod figure_6;
pub mod figure_8;
mod rings;

pub use rings::{Experiment, Plane, Rings};

use crate::spread::Model;

/// How much is traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// For the figures: noise well below every difference that is discussed.
    Full,
    /// For a check in seconds.
    Quick,
}

/// Scattering coefficient of figures 4 and 5 in units of sigma_t.
pub const ALBEDO: f64 = 0.95;

/// The models that are compared: all that have scattered light.
pub fn models() -> impl Iterator<Item = Model> {
    Model::ALL.into_iter().filter(|m| m.spreads())
}
