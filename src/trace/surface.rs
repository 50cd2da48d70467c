//! The object's layers and the medium's surface, as what a path meets: a plane, or the patches of a depth map.
//!
//! Outside the image, `Clamp` repeats the outermost pixels, `Mirror` mirrors them, `Zero` has no object. The medium
//! does not end with the image: its surface continues under `Zero` as under `Clamp`.

use super::march::Projection;
use super::meeting::{Meeting, pixel};
use super::patches::Patches;
use crate::geometry::{Camera, Field, Geometry};
use crate::image::Border;
use glam::DVec3;

/// A layer of the object, or the medium's surface.
#[derive(Debug)]
pub(super) enum Surface {
    /// A plane at one depth Z.
    Plane { depth: f64, projection: Projection, border: Border, size: [usize; 2] },
    /// A depth map.
    Patches(Patches),
}

impl Surface {
    /// The layer of the object at the distances `depth`. One depth and parallel rays make a plane, if there is no
    /// other layer: a plane has no open side by which a path could get behind it.
    pub(super) fn layer(geometry: &Geometry, depth: &Field, border: Border) -> Self {
        match (geometry.camera, depth) {
            (Camera::Orthographic { .. }, &Field::Uniform(depth)) if geometry.behind.is_empty() => {
                Self::plane(geometry, depth, border)
            }
            _ => {
                let distance = |x, y| depth.distance(x, y).unwrap_or(f64::INFINITY);
                Self::Patches(Patches::new(geometry, border, distance))
            }
        }
    }

    /// The medium's surface. Surface 0 of a perspective view is the plane of the camera.
    pub(super) fn front(geometry: &Geometry, border: Border) -> Self {
        let border = if border == Border::Zero { Border::Clamp } else { border };
        match (geometry.camera, &geometry.surface) {
            (Camera::Orthographic { .. }, &Field::Uniform(depth)) => Self::plane(geometry, depth, border),
            (_, &Field::Uniform(0.0)) => Self::plane(geometry, 0.0, border),
            _ => Self::Patches(Patches::new(geometry, border, |x, y| geometry.surface.at(x, y))),
        }
    }

    fn plane(geometry: &Geometry, depth: f64, border: Border) -> Self {
        let projection = Projection::new(geometry.camera, geometry.width, geometry.height);
        Self::Plane { depth, projection, border, size: [geometry.width, geometry.height] }
    }

    /// Depth of the surface and index of the pixel at image position (`u`, `v`) px inside the image.
    pub(super) fn at(&self, u: f64, v: f64) -> Option<(f64, usize)> {
        match self {
            Self::Plane { depth, border, size, .. } => {
                Some((*depth, pixel([u.floor() as i64, v.floor() as i64], *border, *size)?))
            }
            Self::Patches(patches) => patches.at(u, v),
        }
    }

    /// Smallest and largest depth.
    pub(super) fn depths(&self) -> (f64, f64) {
        match self {
            Self::Plane { depth, .. } => (*depth, *depth),
            Self::Patches(patches) => patches.depths(),
        }
    }

    /// Where the segment from `p` in direction `d` first meets this layer within `length`.
    #[inline]
    pub(super) fn meet(&self, p: DVec3, d: DVec3, length: f64) -> Option<Meeting> {
        match self {
            Self::Plane { depth, projection, border, size } => {
                if p.z + d.z * length < *depth {
                    return None;
                }
                let distance = (depth - p.z) / d.z;
                let at = projection.project(p + d * distance);
                let pixel = pixel([at.x.floor() as i64, at.y.floor() as i64], *border, *size);
                Some(Meeting { distance, pixel })
            }
            Self::Patches(patches) => patches.meet(p, d, length),
        }
    }

    /// Whether the segment from `p`, behind this surface, in direction `d` comes to lie before it within `length`.
    #[inline]
    pub(super) fn is_left(&self, p: DVec3, d: DVec3, length: f64) -> bool {
        match self {
            Self::Plane { depth, .. } => p.z + d.z * length < *depth,
            Self::Patches(patches) => patches.is_left(p, d, length),
        }
    }
}
