//! Files in and out: images of all formats by name of channel, pictures, and writing that never destroys an old file.

pub mod atomic;
pub mod colour;
pub mod exr;
pub mod identity;
pub mod input;
pub mod picture;
pub mod png;
pub mod temporary;
pub mod transfer;
