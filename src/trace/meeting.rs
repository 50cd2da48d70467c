//! What a path may meet, and which pixel's light it then sees.

use crate::image::Border;

/// What a segment meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Meeting {
    /// Nothing.
    Nothing,
    /// The lit side of the object: the pixel's index, and the distance from the segment's start.
    Object { pixel: usize, distance: f64 },
    /// The rear of an object, which sends no light, or the dark outside of the image.
    Dark,
}

/// Index of the pixel that stands for a column.
#[inline]
pub(super) fn pixel([u, v]: [i64; 2], border: Border, [width, height]: [usize; 2]) -> Option<usize> {
    Some(border.index(v, height)? * width + border.index(u, width)?)
}
