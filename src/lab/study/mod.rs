//! Studies of the estimation itself, on planes behind known media: whether its error bars are right, where each model
//! fails and whether it reports that, and what accuracy costs.

pub mod calibration;
pub mod chart;
pub mod grid;
pub mod setting;
pub mod stability;
pub mod sweeps;
pub mod trial;

pub use setting::{Setting, Texture};
