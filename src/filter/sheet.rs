//! What sends light, pixel by pixel: the object, its further layers, or what is supposed to be hidden behind it.

use super::Target;
use super::slices::Node;
use crate::geometry::{Field, Geometry};
use crate::image::Image;
use crate::relief::Relief;

/// Light at a distance, over the object image.
#[derive(Clone, Copy)]
pub(super) struct Sheet<'a> {
    geometry: &'a Geometry,
    relief: Option<&'a Relief>,
    /// Radiance; 1 everywhere if absent.
    light: Option<&'a Image>,
    distance: &'a Field,
    slopes: Option<&'a [[f32; 2]]>,
    /// Sheets nearer to the camera, which hide this one where no screen does.
    nearer: &'a [Field],
    before: Option<&'a Field>,
}

/// The light of one pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    pub node: Node,
    pub light: f32,
    /// Slope of its surface, length per pixel.
    pub slope: [f32; 2],
    /// Number of screens that it must pass.
    pub screens: usize,
}
