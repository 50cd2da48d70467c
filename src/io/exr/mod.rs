//! OpenEXR images, found and written by name of channel.
//!
//! Samples are float, half or 32-bit integers in the file and f32 here. The pixels are those of the data window;
//! its place in the display window is not used.

mod damage;
mod read;
mod select;
mod write;

pub use read::{ExrFile, size};
pub use write::write;
