//! narrowbeam
pub mod cli;
pub mod compare;
pub mod error;
pub mod filter;
pub mod fit;
pub mod geometry;
pub mod image;
pub mod io;
pub mod medium;
pub mod phase;
pub mod plots;
mod quadrature;
pub mod scene;
pub mod spread;
pub mod trace;

pub use error::{Error, Result};
