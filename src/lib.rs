//! narrowbeam
pub mod error;
pub mod geometry;
pub mod image;
pub mod medium;
pub mod phase;
mod quadrature;
pub mod scene;
pub mod trace;

pub use error::{Error, Result};
