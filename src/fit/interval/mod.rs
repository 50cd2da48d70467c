//! Intervals that do not rest on the curvature at the optimum: they fit again and again.

mod bootstrap;
mod profile;

pub use bootstrap::{Draws, bootstrap};
pub use profile::profile;

/// Ends of the 95 % interval of each parameter of the medium, by its name. An end is `None` where the data do not close the
/// interval, an interval where the parameter is fixed.
pub type Intervals = Vec<(String, Option<[Option<f64>; 2]>)>;
