//! OpenEXR images, found and written by name of channel.
//!
//! Samples are float, half or 32-bit integers in the file and f32 here. A file whose data window is not its display window is
//! refused: what lies outside may be black, or not have been rendered, and the file does not say which.

mod damage;
mod depth;
mod read;
mod select;
mod write;

pub use read::{ExrFile, size};
pub use select::Pick;
pub use write::{write, write_finite};
