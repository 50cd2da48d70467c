//! narrowbeam
pub mod error;
pub mod filter;
pub mod fit;
pub mod geometry;
pub mod image;
pub mod medium;
pub mod phase;
mod quadrature;
pub mod scene;
pub mod spread;
pub mod trace;

pub use error::{Error, Result};
