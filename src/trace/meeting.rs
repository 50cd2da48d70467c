//! Where a path meets a surface, and which pixel's light it sees there.

use crate::image::Border;

/// Where a segment first meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    /// Distance from the segment's start.
    pub distance: f64,
    /// Index of the pixel whose lit side is met; `None` is dark: the rear of a surface, or outside of the image.
    pub pixel: Option<usize>,
}

/// Index of the pixel that represents a column.
#[inline]
pub(super) fn pixel([u, v]: [i64; 2], border: Border, [width, height]: [usize; 2]) -> Option<usize> {
    Some(border.index(v, height)? * width + border.index(u, width)?)
}
