//! Planes behind media that several tests look through.

use narrowbeam::lab::study::{Setting, Texture};
use narrowbeam::medium::Medium;
use std::sync::LazyLock;

/// A checkerboard of 48² px behind a medium of tau 1.4.
pub static PLANE: LazyLock<Setting> = LazyLock::new(|| Setting {
    texture: Texture::Checker,
    side: 48,
    pixel_pitch: 0.03,
    z: 2.0,
    medium: Medium::gaussian(0.7, 0.15, 0.004).unwrap(),
});
