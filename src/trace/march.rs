//! The march of a straight segment through the columns of the pixel grid.
//!
//! A column is the region that a pixel sees: a prism along z for parallel rays, a pyramid with its tip in the camera for a
//! perspective view. Both become unit squares in image coordinates (u, v) px, with a height h that grows with depth:
//! h = Z for parallel rays, h = -1/Z in perspective. The map (x, y, Z) -> (u, v, h) takes straight lines to straight
//! lines and planes to planes, so one march in (u, v, h) serves both cameras.

use crate::geometry::Camera;
use glam::{DVec2, DVec3};
use std::ops::ControlFlow;

/// Columns that one segment may cross. More means a nearly sideways path in a very thin medium, far outside any
/// image: what it would meet further on is left out.
const MAX_COLUMNS: usize = 1 << 16;

/// The map from space to image coordinates and height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    perspective: bool,
    /// Length of a pixel (parallel rays), or length per unit of depth (perspective).
    pitch: f64,
    centre: DVec2,
}

impl Projection {
    pub(super) fn new(camera: Camera, width: usize, height: usize) -> Self {
        let centre = 0.5 * DVec2::new(width as f64, height as f64);
        match camera {
            Camera::Orthographic { pixel_pitch } => Self { perspective: false, pitch: pixel_pitch, centre },
            Camera::Perspective { fov_x } => {
                Self { perspective: true, pitch: (0.5 * fov_x).tan() / centre.x, centre }
            }
        }
    }

    pub(super) fn is_perspective(&self) -> bool {
        self.perspective
    }

    /// (u, v, h) of a point; in perspective its depth must be above 0.
    #[inline]
    pub(super) fn project(&self, p: DVec3) -> DVec3 {
        let scale = if self.perspective { 1.0 / (self.pitch * p.z) } else { 1.0 / self.pitch };
        (p.truncate() * scale + self.centre).extend(self.height(p.z))
    }

    /// Height h of the depth `z`.
    #[inline]
    pub(super) fn height(&self, z: f64) -> f64 {
        if self.perspective { -1.0 / z } else { z }
    }

    /// Depth at the height `h`.
    #[inline]
    pub(super) fn depth(&self, h: f64) -> f64 {
        if self.perspective { -1.0 / h } else { h }
    }

    /// Length of a pixel at depth `z`.
    #[inline]
    pub(super) fn pitch(&self, z: f64) -> f64 {
        if self.perspective { self.pitch * z } else { self.pitch }
    }

    /// Share of the way from depth `z0` to depth `z1` in space for the share `s` of the way in (u, v, h).
    #[inline]
    fn share_in_space(&self, s: f64, z0: f64, z1: f64) -> f64 {
        if self.perspective { s * z0 / (z1 * (1.0 - s) + s * z0) } else { s }
    }
}

/// Part of a line, as parameters of its points.
type Range = (f64, f64);

/// The part of `range` on which a + s (b - a) lies between `low` and `high` in one coordinate, or `None`.
#[inline]
fn clip(range: Range, a: f64, b: f64, low: f64, high: f64) -> Option<Range> {
    let slope = b - a;
    if slope == 0.0 {
        return (a >= low && a <= high).then_some(range);
    }
    let (to_low, to_high) = ((low - a) / slope, (high - a) / slope);
    let clipped = (range.0.max(to_low.min(to_high)), range.1.min(to_low.max(to_high)));
    (clipped.0 <= clipped.1).then_some(clipped)
}

/// The part of a straight segment within some depths, projected: the points a + s (b - a) for s in a range.
#[derive(Debug)]
pub(super) struct Segment {
    projection: Projection,
    a: DVec3,
    b: DVec3,
    range: Range,
    /// Distances of a and b from the start of the whole segment, and their depths.
    ends: Range,
    depths: Range,
}

impl Segment {
    /// The part between two depths (in perspective, both above 0) of the segment from `p` in direction `d`.
    #[inline]
    pub(super) fn new(
        projection: Projection,
        p: DVec3,
        d: DVec3,
        length: f64,
        (near, far): (f64, f64),
    ) -> Option<Self> {
        let ends = clip((0.0, length), p.z, p.z + d.z, near, far)?;
        let (first, last) = (p + d * ends.0, p + d * ends.1);
        let (a, b) = (projection.project(first), projection.project(last));
        Some(Self { projection, a, b, range: (0.0, 1.0), ends, depths: (first.z, last.z) })
    }

    /// The part of it over an image of this size.
    pub(super) fn over_image(self, size: [usize; 2]) -> Option<Self> {
        let range = clip(self.range, self.a.x, self.b.x, 0.0, size[0] as f64)?;
        let range = clip(range, self.a.y, self.b.y, 0.0, size[1] as f64)?;
        Some(Self { range, ..self })
    }

    /// Whether it begins where the whole segment begins.
    pub(super) fn is_unclipped_at_start(&self) -> bool {
        self.ends.0 == 0.0 && self.range.0 == 0.0
    }

    /// (u, v, h) at parameter `s`.
    #[inline]
    pub(super) fn at(&self, s: f64) -> DVec3 {
        self.a + (self.b - self.a) * s
    }

    /// Distance in space of that point from the start of the whole segment.
    pub(super) fn distance(&self, s: f64) -> f64 {
        self.ends.0
            + (self.ends.1 - self.ends.0) * self.projection.share_in_space(s, self.depths.0, self.depths.1)
    }
}

/// Visits, in order, the columns that a segment crosses, with the parameters of entry and exit, until `visit` breaks
/// or the segment ends. `None` when it ended, and after [`MAX_COLUMNS`].
#[inline]
pub(super) fn march<T>(
    segment: &Segment,
    mut visit: impl FnMut([i64; 2], f64, f64) -> ControlFlow<T>,
) -> Option<T> {
    let (a, step, range) = (segment.a, segment.b - segment.a, segment.range);
    let start = segment.at(range.0);
    let mut column = [start.x.floor() as i64, start.y.floor() as i64];
    // Parameter of the next wall and between walls, along u and along v.
    let axis = |a: f64, step: f64, column: i64| {
        let wall = if step > 0.0 { column + 1 } else { column };
        if step == 0.0 {
            (f64::INFINITY, f64::INFINITY)
        } else {
            ((wall as f64 - a) / step, (1.0 / step).abs())
        }
    };
    let (mut next_u, between_u) = axis(a.x, step.x, column[0]);
    let (mut next_v, between_v) = axis(a.y, step.y, column[1]);
    let mut entry = range.0;
    for _ in 0..MAX_COLUMNS {
        let exit = next_u.min(next_v).min(range.1).max(entry);
        if let ControlFlow::Break(found) = visit(column, entry, exit) {
            return Some(found);
        }
        if next_u.min(next_v) >= range.1 {
            return None;
        }
        if next_u < next_v {
            column[0] += step.x.signum() as i64;
            next_u += between_u;
        } else {
            column[1] += step.y.signum() as i64;
            next_v += between_v;
        }
        entry = exit;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_march_visits_the_columns_under_a_line_in_order() {
        let view = Projection::new(Camera::orthographic(1.0).unwrap(), 2, 2);
        let (p, d) = (DVec3::new(-0.5, -0.5, 1.0), DVec3::new(3.0, -1.5, 1.0));
        let segment = Segment::new(view, p, d, 1.0, (0.0, 9.0)).unwrap();
        let mut seen = Vec::new();
        let mut last = 0.0;
        let end: Option<()> = march(&segment, |column, entry, exit| {
            let middle = segment.at(0.5 * (entry + exit));
            assert_eq!([middle.x.floor() as i64, middle.y.floor() as i64], column);
            assert_eq!(entry, last);
            last = exit;
            seen.push(column);
            ControlFlow::Continue(())
        });
        assert_eq!((end, last), (None, 1.0));
        assert_eq!(seen, [[0, 0], [1, 0], [1, -1], [2, -1], [3, -1]]);
    }

    #[test]
    fn perspective_keeps_lines_straight_and_finds_the_way_back() {
        let view = Projection::new(Camera::perspective(40.0).unwrap(), 64, 48);
        let (a, b) = (DVec3::new(-0.2, 0.1, 1.0), DVec3::new(0.5, -0.3, 3.0));
        let (pa, pb) = (view.project(a), view.project(b));
        for s in [0.1, 0.5, 0.9] {
            let p = a + (b - a) * view.share_in_space(s, a.z, b.z);
            assert!(view.project(p).distance(pa + (pb - pa) * s) < 1e-12);
        }
    }

    #[test]
    fn clipping_keeps_the_part_inside() {
        assert_eq!(clip((0.0, 1.0), -1.0, 3.0, 0.0, 1.0), Some((0.25, 0.5)));
        assert_eq!(clip((0.0, 1.0), 3.0, -1.0, 0.0, 1.0), Some((0.5, 0.75)));
        assert_eq!(clip((0.0, 1.0), 2.0, 3.0, 0.0, 1.0), None);
        assert_eq!(clip((0.2, 1.0), 0.5, 0.5, 0.0, 1.0), Some((0.2, 1.0)));
    }
}
