//! Depth maps as surfaces: every pixel is one planar patch.
//!
//! In the coordinates of [`march`](super::march) a patch is h = h_c + h_u (u - u_c) + h_v (v - v_c) over its pixel,
//! a plane in space for either camera. Its slopes are central differences of its neighbours' heights, one-sided
//! where only one neighbour belongs to the same surface, 0 where none does. Two neighbours belong to one surface
//! unless their depths differ by more than [`EDGE_PITCHES`] pixel lengths; an empty pixel belongs to none.
//!
//! Outside the image, `Clamp` repeats the outermost Z-depths without slope across the border, `Mirror` mirrors depths
//! and slopes, `Zero` has nothing there.

use super::march::{Projection, Segment, march};
use super::meeting::{Meeting, pixel};
use crate::geometry::{EDGE_PITCHES, FARTHEST, Geometry};
use crate::image::Border;
use glam::DVec3;
use std::ops::ControlFlow;

/// Smallest depth of a patch in perspective, as a share of the largest: h = -1/Z must stay finite.
const NEAREST: f64 = 1e-6;

/// The plane over one pixel.
#[derive(Debug, Clone, Copy)]
struct Patch {
    pixel: usize,
    centre: [f64; 2],
    h: f64,
    slope: [f64; 2],
}

impl Patch {
    #[inline]
    fn height(&self, u: f64, v: f64) -> f64 {
        self.h + self.slope[0] * (u - self.centre[0]) + self.slope[1] * (v - self.centre[1])
    }

    /// How much higher a point (u, v, h) is than the plane: above 0 behind it, below 0 before it.
    #[inline]
    fn height_beyond(&self, p: DVec3) -> f64 {
        p.z - self.height(p.x, p.y)
    }
}

/// A depth map as planar patches.
#[derive(Debug)]
pub(super) struct Patches {
    projection: Projection,
    border: Border,
    size: [usize; 2],
    /// Height, slope along u and slope along v of each pixel; the height of an empty pixel is infinite.
    planes: Vec<[f64; 3]>,
    /// Smallest and largest depth.
    depths: (f64, f64),
}

impl Patches {
    /// Patches of a map of distances along the rays, infinite where there is nothing.
    pub(super) fn new(geometry: &Geometry, border: Border, distance: impl Fn(usize, usize) -> f64) -> Self {
        let (width, height) = (geometry.width, geometry.height);
        let projection = Projection::new(geometry.camera, width, height);
        let z_depth = |i: usize| distance(i % width, i / width) * geometry.cos_off_axis(i % width, i / width);
        let mut z: Vec<f64> = (0..width * height).map(z_depth).collect();
        if projection.is_perspective() {
            let largest = z.iter().copied().filter(|z| z.is_finite()).fold(0.0, f64::max);
            z.iter_mut().for_each(|z| *z = z.max(NEAREST * largest));
        }
        let slope = |i: usize, before: Option<usize>, after: Option<usize>| {
            let side = |j: Option<usize>| j.filter(|&j| joined(&projection, z[i], z[j]));
            let h = |j: usize| projection.height(z[j]);
            match (side(before), side(after)) {
                (Some(a), Some(b)) => 0.5 * (h(b) - h(a)),
                (Some(a), None) => h(i) - h(a),
                (None, Some(b)) => h(b) - h(i),
                (None, None) => 0.0,
            }
        };
        let plane = |i: usize| {
            if !z[i].is_finite() {
                return [f64::INFINITY, 0.0, 0.0];
            }
            let (x, y) = (i % width, i / width);
            let along_u = slope(i, (x > 0).then(|| i - 1), (x + 1 < width).then_some(i + 1));
            let along_v = slope(i, (y > 0).then(|| i - width), (y + 1 < height).then_some(i + width));
            [projection.height(z[i]), along_u, along_v]
        };
        let planes: Vec<[f64; 3]> = (0..width * height).map(plane).collect();
        // A patch reaches beyond the depth of its centre, by at most half of both slopes.
        let reach = |p: &[f64; 3]| 0.5 * (p[1].abs() + p[2].abs());
        let there = || planes.iter().filter(|p| p[0].is_finite());
        let low = there().map(|p| p[0] - reach(p)).fold(f64::INFINITY, f64::min);
        let high = there().map(|p| p[0] + reach(p)).fold(f64::NEG_INFINITY, f64::max);
        let depths = (projection.depth(low), projection.depth(high.min(projection.height(FARTHEST))));
        Self { projection, border, size: [width, height], planes, depths }
    }

    /// Depth of the patches and index of the pixel at image position (`u`, `v`) px.
    pub(super) fn at(&self, u: f64, v: f64) -> Option<(f64, usize)> {
        let patch = self.patch([u.floor() as i64, v.floor() as i64]);
        let h = patch.height(u, v);
        h.is_finite().then(|| (self.projection.depth(h), patch.pixel))
    }

    /// Smallest and largest depth.
    pub(super) fn depths(&self) -> (f64, f64) {
        self.depths
    }

    /// The patch of a column; infinitely far where there is nothing.
    #[inline]
    fn patch(&self, column: [i64; 2]) -> Patch {
        let centre = [column[0] as f64 + 0.5, column[1] as f64 + 0.5];
        match pixel(column, self.border, self.size) {
            None => Patch { pixel: usize::MAX, centre, h: f64::INFINITY, slope: [0.0; 2] },
            Some(pixel) => {
                let [h, along_u, along_v] = self.planes[pixel];
                let turn = |axis: usize| self.border.turn(column[axis], self.size[axis]);
                let slope = [turn(0) * along_u, turn(1) * along_v];
                Patch { pixel, centre, h, slope }
            }
        }
    }

    fn joined(&self, a: &Patch, b: &Patch) -> bool {
        a.pixel == b.pixel || joined(&self.projection, self.projection.depth(a.h), self.projection.depth(b.h))
    }

    /// The part of a segment between the surface's smallest and largest depth (and, with nothing outside, over the
    /// image), projected.
    #[inline]
    fn clipped(&self, p: DVec3, d: DVec3, length: f64) -> Option<Segment> {
        // A little more, so that a crossing at the very end of the range has a before and an after.
        let margin = 1e-3 * self.projection.pitch(self.depths.0);
        let (near, far) = (self.depths.0 - margin, self.depths.1 + margin);
        let near = if self.projection.is_perspective() { near.max(0.5 * self.depths.0) } else { near };
        let segment = Segment::new(self.projection, p, d, length, (near, far))?;
        if self.border == Border::Zero { segment.over_image(self.size) } else { Some(segment) }
    }

    /// First intersection with the surface.
    ///
    /// While the segment is before the patches, crossing one is a hit. So is entering a column already behind its
    /// patch from a column of the same surface: the patches do not join without cracks. From a column of another
    /// surface, across a depth edge, it means that the path went past the edge and is hidden: it meets nothing until
    /// it emerges in front of the near surface again. The rear of a surface is dark.
    pub(super) fn meet(&self, p: DVec3, d: DVec3, length: f64) -> Option<Meeting> {
        let segment = self.clipped(p, d, length)?;
        let mut last: Option<Patch> = None;
        let mut before = true;
        march(&segment, |column, entry, exit| {
            let patch = self.patch(column);
            let (f_in, f_out) =
                (patch.height_beyond(segment.at(entry)), patch.height_beyond(segment.at(exit)));
            // The lit side if the segment comes from before the patch, else its rear.
            let hit = |before: bool, s| {
                let pixel = before.then_some(patch.pixel);
                ControlFlow::Break(Meeting { distance: segment.distance(s), pixel })
            };
            let now = f_in < 0.0;
            match &last {
                Some(last) if now != before && self.joined(last, &patch) => {
                    return hit(before, entry);
                }
                _ => before = now,
            }
            if before != (f_out < 0.0) {
                return hit(before, entry + (exit - entry) * f_in / (f_in - f_out));
            }
            last = Some(patch);
            ControlFlow::Continue(())
        })
    }

    /// Whether a segment that starts behind the patches comes to lie before them. One that starts on its patch and
    /// goes in does not, whatever the rounding says.
    pub(super) fn is_left(&self, p: DVec3, d: DVec3, length: f64) -> bool {
        if p.z.min(p.z + d.z * length) > self.depths.1 {
            return false;
        }
        let Some(segment) = self.clipped(p, d, length) else {
            return p.z.max(p.z + d.z * length) < self.depths.0;
        };
        let mut first = segment.is_unclipped_at_start();
        march(&segment, |column, entry, exit| {
            let patch = self.patch(column);
            let f_out = patch.height_beyond(segment.at(exit));
            let outside = f_out < 0.0 && !(first && f_out >= patch.height_beyond(segment.at(entry)));
            first = false;
            if outside { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
        .is_some()
    }
}

/// Whether neighbours at these depths belong to one surface.
#[inline]
fn joined(projection: &Projection, z0: f64, z1: f64) -> bool {
    (z0 - z1).abs() <= EDGE_PITCHES * projection.pitch(z0.min(z1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Camera, Field};
    use crate::image::Image;
    use crate::trace::Stream;

    const SIZE: (usize, usize) = (32, 24);

    fn patches(camera: Camera, border: Border, distance: impl Fn(DVec3, DVec3) -> f64) -> Patches {
        let (width, height) = SIZE;
        let map = Image::from_fn(width, height, |x, y| {
            let (start, direction) = camera.ray(x as f64 + 0.5, y as f64 + 0.5, SIZE);
            distance(start, direction) as f32
        });
        let geometry = Geometry {
            width,
            height,
            camera,
            depth: Field::Map(map),
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        };
        Patches::new(&geometry, border, |x, y| geometry.depth.at(x, y))
    }

    #[test]
    fn a_tilted_plane_is_hit_where_it_is_by_either_camera() {
        let normal = DVec3::new(0.5, -0.2, 1.0);
        for camera in [Camera::orthographic(0.1).unwrap(), Camera::perspective(60.0).unwrap()] {
            let plane = |start: DVec3, d: DVec3| (4.0 - normal.dot(start)) / normal.dot(d);
            let map = patches(camera, Border::Zero, plane);
            let mut stream = Stream::new(Stream::key(1), 0);
            let mut uniform = || stream.uniform_f64() - 0.5;
            let mut hits = 0;
            for _ in 0..10_000 {
                let start = DVec3::new(2.0 * uniform(), 2.0 * uniform(), 1.5 + uniform());
                let direction = DVec3::new(uniform(), uniform(), 0.6 + uniform()).normalize();
                let truth = plane(start, direction);
                match map.meet(start, direction, 10.0) {
                    Some(Meeting { distance, pixel: Some(_) }) => {
                        hits += 1;
                        // The map holds f32.
                        assert!((distance - truth).abs() < 1e-5 * truth, "{start} {direction}");
                        assert_eq!(map.meet(start, direction, 0.999 * truth), None);
                        let beyond = start + direction * 1.1 * truth;
                        let p = map.projection.project(beyond);
                        if map.at(p.x, p.y).is_some() {
                            assert!(map.is_left(beyond, -direction, truth));
                            assert!(!map.is_left(beyond, -direction, 0.05 * truth));
                        }
                    }
                    // Past the image.
                    _ => {
                        let p = map.projection.project(start + direction * truth);
                        let (u, v) = (p.x / SIZE.0 as f64, p.y / SIZE.1 as f64);
                        assert!(truth < 0.0 || u.min(v) < 1e-6 || u.max(v) > 1.0 - 1e-6 || truth > 10.0);
                    }
                }
            }
            assert!(hits > 2000, "{hits}");
        }
    }

    #[test]
    fn no_path_slips_through_the_cracks_of_a_wavy_surface() {
        for border in [Border::Clamp, Border::Mirror] {
            let camera = Camera::orthographic(0.1).unwrap();
            let map = patches(camera, border, |p, _| 2.0 + 0.3 * (3.0 * p.x).sin() * (4.0 * p.y).cos());
            let mut stream = Stream::new(Stream::key(2), 0);
            let mut uniform = || stream.uniform_f64() - 0.5;
            for _ in 0..20_000 {
                let start = DVec3::new(6.0 * uniform(), 6.0 * uniform(), 1.0);
                let direction = DVec3::new(4.0 * uniform(), 4.0 * uniform(), 1.0).normalize();
                let through = 2.0 / direction.z;
                let met = map.meet(start, direction, through);
                assert!(met.is_some_and(|m| m.pixel.is_some()), "{border:?}");
                assert!(map.is_left(start + direction * through, -direction, through), "{border:?}");
            }
        }
    }
}
