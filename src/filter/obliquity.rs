//! Rays off the axis of a perspective camera.
//!
//! A kernel stands on the plane perpendicular to its ray. Depths count along the camera's axis here; on the plane at
//! depth Z a ray at the angle theta off the axis has gone z/cos(theta) through the medium, and a length across it
//! covers 1/cos(theta) times as much in the radial direction, as much in the other. Kernels stay round in pixels, by
//! the geometric mean: that of a pixel pitch·sqrt(cos theta) long. This is the approximation made; what it errs by is
//! in docs/composite.md.
//!
//! The angle is that of the ray which sees the light, not of the pixel that sends it: so a plane of uniform radiance
//! keeps it. Images of a few angles are interpolated to each pixel's own.

use super::slices::Node;
use crate::chebyshev::Chebyshev;
use crate::geometry::{Camera, Geometry};
use crate::image::View;

/// A ray's obliquity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Obliquity {
    /// Cosine of its angle off the camera's axis.
    pub cosine: f64,
}

impl Obliquity {
    /// Path length and pixel of this ray's kernel, for `node` along the axis.
    pub(super) fn scaled(self, node: Node) -> Node {
        Node { z: node.z / self.cosine, pitch: node.pitch * self.cosine.sqrt() }
    }
}

/// A few obliquities that stand for those of all pixels of a view.
pub(super) struct Obliquities {
    cosines: Chebyshev,
    /// For each of them its weight at each pixel of the view; none if there is but one.
    weights: Vec<Vec<f32>>,
}

/// Interpolation over cosines of half-range rho about their middle falls like rho^n, to this.
const TOLERANCE: f64 = 3e-4;

impl Obliquities {
    pub(super) fn new(geometry: &Geometry, view: View) -> Self {
        if matches!(geometry.camera, Camera::Orthographic { .. }) {
            return Self { cosines: Chebyshev::new(1, 1.0, 1.0), weights: Vec::new() };
        }
        let at = |i: usize| geometry.cos_off_axis(view.x + i % view.width, view.y + i / view.width);
        let all: Vec<f64> = (0..view.pixels()).map(at).collect();
        let low = all.iter().copied().fold(1.0, f64::min);
        let high = all.iter().copied().fold(0.0, f64::max);
        let rho = (high - low) / (high + low);
        let count = (TOLERANCE.ln() / rho.max(1e-12).ln()).ceil() as usize;
        let cosines = Chebyshev::new(count, low, high);
        if count == 1 {
            return Self { cosines, weights: Vec::new() };
        }
        let mut weights = vec![Vec::with_capacity(all.len()); count];
        for cosine in all {
            let basis = cosines.basis(cosine);
            weights.iter_mut().zip(basis).for_each(|(plane, weight)| plane.push(weight as f32));
        }
        Self { cosines, weights }
    }

    pub(super) fn count(&self) -> usize {
        self.cosines.x.len()
    }

    /// Each obliquity with its weights over the view, row-major; no weights mean 1.
    pub(super) fn iter(&self) -> impl Iterator<Item = (Obliquity, Option<&[f32]>)> {
        let weights = |i: usize| self.weights.get(i).map(Vec::as_slice);
        self.cosines.x.iter().enumerate().map(move |(i, &cosine)| (Obliquity { cosine }, weights(i)))
    }
}
