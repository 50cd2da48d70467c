//! Studies of the estimation itself, on planes behind media that are known: whether its error bars hold, where each model
//! fails and whether it says so, and what accuracy costs.

pub mod calibration;
pub mod chart;
pub mod setting;
pub mod stability;
pub mod sweeps;
pub mod trial;

pub use setting::{Setting, Texture};
