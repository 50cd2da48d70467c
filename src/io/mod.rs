//! Files in and out: EXR images by name of channel, PNG pictures, and writing that never destroys an old file.

pub mod atomic;
pub mod colour;
pub mod exr;
pub mod input;
pub mod png;
