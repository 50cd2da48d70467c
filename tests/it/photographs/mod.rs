//! Photographs: image files, transfer curves, noise of sensors and of the clear image, saturation, and the way from two pictures to a fit.

mod cases;
mod files;
mod init;
pub(crate) mod made;
mod noise;
mod scenes;
