//! narrowbeam
pub mod error;
pub mod geometry;
pub mod image;
pub mod medium;
pub mod phase;
pub mod scene;
mod quadrature;

pub use error::{Error, Result};
