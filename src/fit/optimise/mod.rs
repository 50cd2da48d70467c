//! From a start to the optimum: the problem, the solvers, and the driver that goes round until all has settled.

mod begin;
mod bounded_step;
mod driver;
mod equations;
mod problem;
mod scene_models;
mod search;
mod solver;
mod split;
mod start;
mod task;

pub(super) use begin::{Begun, From};
pub(super) use driver::{Driver, Optimum};
pub(super) use equations::{Eliminated, NormalEquations};
pub(super) use problem::Problem;
pub(super) use scene_models::SceneModels;
pub(super) use start::OTHER_WIDTHS;
pub(super) use task::Task;

pub use scene_models::{HEADROOM, PathsUsed};
