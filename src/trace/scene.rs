//! A scene for tracing: from a place in the image into the medium, and to the object unless the path is lost.
//!
//! The first scattering is forced to lie before the object, with the weight 1 - exp(-sigma_s z); the path then continues at
//! random until it meets the object or is lost. Rays that see no object scatter too.

use super::OPAQUE;
use super::config::ImageConfig;
use super::meeting::Meeting;
use super::path::{Path, free_path};
use super::rng::Stream;
use super::surface::Surface;
use crate::geometry::Geometry;
use crate::image::Image;
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use glam::DVec3;

/// One layer of the object.
struct Layer<'a> {
    surface: Surface,
    radiance: &'a Image,
}

impl Layer<'_> {
    fn light(&self, pixel: usize) -> f64 {
        f64::from(self.radiance.data[pixel])
    }
}

/// Where scattered light comes from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrival {
    /// Length of the path in the medium.
    pub length: f64,
    /// Radiance that it meets.
    pub light: f64,
}

/// What one path contributes to a place in the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Glimpse {
    /// Share of the light that is scattered before the object: the light that the path represents.
    pub share: f64,
    /// What the path meets; `None` if it is lost.
    pub arrival: Option<Arrival>,
}

/// A scene prepared for tracing. The z of paths begins at the nearest point of the medium's surface, so that f32
/// resolves the medium however far away the camera is.
pub(super) struct Tracer<'a, P> {
    geometry: &'a Geometry,
    medium: Medium<P>,
    object: Layer<'a>,
    /// The further layers in which there is anything.
    behind: Vec<Layer<'a>>,
    front: Surface,
    origin: DVec3,
    /// Depth beyond which no object lies.
    beyond: f64,
}

impl<'a, P: PhaseFunction + Copy> Tracer<'a, P> {
    pub(super) fn new(config: &ImageConfig<'a, P>) -> Self {
        let ImageConfig { geometry, radiance, behind, border, medium, .. } = *config;
        let pixels =
            || (0..geometry.width * geometry.height).map(|i| (i % geometry.width, i / geometry.width));
        let layer = |depth, radiance| Layer { surface: Surface::layer(geometry, depth, border), radiance };
        let object = layer(&geometry.depth, radiance);
        let behind: Vec<_> = (geometry.behind.iter().zip(behind))
            .filter(|(depth, _)| pixels().any(|(x, y)| depth.distance(x, y).is_some()))
            .map(|(depth, radiance)| layer(depth, radiance))
            .collect();
        let front = Surface::front(geometry, border);
        let origin = DVec3::Z * front.depths().0;
        let farthest = |layer: &Layer| layer.surface.depths().1;
        let beyond = behind.iter().map(farthest).fold(farthest(&object), f64::max);
        Self { geometry, medium, object, behind, front, origin, beyond }
    }

    /// Path length in the medium and radiance of what is seen at image position (`u`, `v`) px through clear air.
    pub(super) fn direct(&self, u: f64, v: f64) -> Option<Arrival> {
        let (_, surface, direction) = self.ray(u, v)?;
        let (depth, light) = self.seen(u, v)?;
        Some(Arrival { length: ((depth - surface) / direction.z).max(0.0), light })
    }

    /// Where the ray of image position (`u`, `v`) px enters the medium, at which depth, and its direction.
    fn ray(&self, u: f64, v: f64) -> Option<(DVec3, f64, DVec3)> {
        let Geometry { camera, width, height, .. } = *self.geometry;
        let (surface, _) = self.front.at(u, v)?;
        let (start, direction) = camera.ray(u, v, (width, height));
        Some((start + direction * ((surface - start.z) / direction.z), surface, direction))
    }

    /// Follows one scattered path from image position (`u`, `v`) px, seen through clear air as `direct`; calls `turned`
    /// with every deflection (rad).
    pub(super) fn scattered(
        &self,
        (u, v): (f64, f64),
        direct: Option<Arrival>,
        stream: &mut Stream,
        mut turned: impl FnMut(f32),
    ) -> Glimpse {
        let lost = Glimpse { share: 0.0, arrival: None };
        let Some((start, _, direction)) = self.ray(u, v) else { return lost };
        let mut path = Path::new((start - self.origin).as_vec3(), direction.as_vec3());
        let Some(Arrival { length: z, .. }) = direct else {
            return Glimpse { share: 1.0, arrival: self.follow(&mut path, stream, &mut turned) };
        };
        // Share of the light that is scattered before the object; the first free path is drawn from that share.
        let share = -(-self.medium.tau(z)).exp_m1();
        if share == 0.0 {
            return lost;
        }
        let distance = -(-share * stream.uniform_f64()).ln_1p() / self.medium.sigma_s();
        path.advance(distance.min(z) as f32);
        turned(path.scatter(self.medium.phase(), stream));
        Glimpse { share, arrival: self.follow(&mut path, stream, &mut turned) }
    }

    /// Depth and radiance of the nearest layer at image position (`u`, `v`) px. Where a layer repeats the one in front
    /// of it, the latter counts.
    fn seen(&self, u: f64, v: f64) -> Option<(f64, f64)> {
        let there = |layer: &Layer| {
            let (depth, pixel) = layer.surface.at(u, v)?;
            Some((depth, layer.light(pixel)))
        };
        [&self.object].into_iter().chain(&self.behind).filter_map(there).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Where the segment from `p` in direction `d` first meets a layer within `length`, and which.
    #[inline]
    fn meet(&self, p: DVec3, d: DVec3, length: f64) -> Option<(Meeting, &Layer<'a>)> {
        let mut first = self.object.surface.meet(p, d, length).map(|meeting| (meeting, &self.object));
        for layer in &self.behind {
            if let Some(meeting) = layer.surface.meet(p, d, length)
                && first.is_none_or(|(nearest, _)| meeting.distance < nearest.distance)
            {
                first = Some((meeting, layer));
            }
        }
        first
    }

    /// What a path meets from where it is; `None` if it is lost.
    fn follow(&self, path: &mut Path, stream: &mut Stream, turned: &mut impl FnMut(f32)) -> Option<Arrival> {
        let sigma_s = self.medium.sigma_s() as f32;
        let sigma_a = self.medium.sigma_a() as f32;
        if sigma_s == 0.0 {
            return None;
        }
        loop {
            let step = free_path(sigma_s, stream);
            let (p, d) = (path.position.as_dvec3() + self.origin, path.direction.as_dvec3());
            if let Some((Meeting { distance, pixel }, layer)) = self.meet(p, d, f64::from(step)) {
                let lit = pixel.filter(|_| !self.front.is_left(p, d, distance));
                let length = f64::from(path.length) + distance;
                return lit.map(|pixel| Arrival { length, light: layer.light(pixel) });
            }
            path.advance(step);
            let gone = f64::from(path.position.z) + self.origin.z > self.beyond;
            if gone || sigma_a * path.length > OPAQUE || self.front.is_left(p, d, f64::from(step)) {
                return None;
            }
            turned(path.scatter(self.medium.phase(), stream));
        }
    }
}
