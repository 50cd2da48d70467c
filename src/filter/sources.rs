//! What sends light, pixel by pixel: the object and its further layers, or the inpainted hidden layers.

use super::Target;
use super::slices::Node;
use crate::error::Result;
use crate::geometry::Field;
use crate::memory::{Reservation, product, reserve};
use crate::relief::{Occluder, Relief};
use rayon::prelude::*;

/// The light of one pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Source {
    /// Where it is.
    pub node: Node,
    /// Cosine of its ray off the camera's axis.
    pub cosine: f64,
    /// Clear radiance.
    pub light: f32,
    /// Slope of its surface along x and y, length per pixel.
    pub slope: [f32; 2],
    /// Number of occluders that its light must pass.
    pub occluders: usize,
}

/// One source for every pixel of the object image, row-major; `None` where there is nothing.
pub(super) type Layer = Vec<Option<Source>>;

/// Reserves what finding the slices of `target` takes: the sources of all layers, and their nodes, sorted.
pub(super) fn reserve_layers(target: &Target) -> Result<Reservation> {
    let pixels = target.radiance.data.len();
    let each = size_of::<Option<Source>>() * (1 + target.behind.len()) + 3 * size_of::<Node>();
    let what = || {
        let (width, height) = (target.radiance.width, target.radiance.height);
        format!("the light of {width}x{height} px in {} layers", 1 + target.behind.len())
    };
    reserve(what, product(&[pixels, each]))
}

/// The object alone if every pixel's light spreads freely; with its relief, the further layers too. What is black is no source.
pub(super) fn layers(target: &Target) -> Vec<Layer> {
    let mut all = surfaces(target);
    let sources = all.iter_mut().flatten();
    sources.for_each(|source| *source = source.filter(|s| s.light != 0.0));
    all
}

/// The same with what is black.
fn surfaces(target: &Target) -> Vec<Layer> {
    let Some(relief) = target.relief else {
        return vec![layer(target, &[], &target.geometry.depth, |i| (target.radiance.data[i], [0.0; 2]))];
    };
    let layers = std::iter::once((&target.geometry.depth, target.radiance))
        .chain(target.geometry.behind.iter().zip(target.behind));
    let mut all: Vec<Layer> = Vec::new();
    for ((distance, radiance), slopes) in layers.zip(&relief.slopes) {
        let slope = |i: usize| slopes.as_ref().map_or([0.0; 2], |s| s[i]);
        let mut layer = layer(target, &relief.occluders, distance, |i| (radiance.data[i], slope(i)));
        // A pixel behind another, with no occluder between them, lies too close behind it to be seen.
        for (i, source) in layer.iter_mut().enumerate() {
            let Some(nearer) = all.iter().filter_map(|nearer| nearer[i]).map(|s| s.occluders).max() else {
                continue;
            };
            let between = |s: &Source| relief.occluders.get(nearer..s.occluders).unwrap_or_default();
            *source = source.filter(|s| between(s).iter().any(|occluder| occluder.opaque[i]));
        }
        all.push(layer);
    }
    all
}

/// Light of radiance 1 from the surfaces inpainted behind the occluders of `relief`.
pub(super) fn hidden_layers(target: &Target, relief: &Relief) -> Vec<Layer> {
    let hidden = relief.occluders.iter().map(|occluder| &occluder.hidden);
    hidden.map(|distance| layer(target, &relief.occluders, distance, |_| (1.0, [0.0; 2]))).collect()
}

fn layer(
    target: &Target,
    occluders: &[Occluder],
    distance: &Field,
    light_and_slope: impl Fn(usize) -> (f32, [f32; 2]) + Sync,
) -> Layer {
    let geometry = target.geometry;
    let source = |i: usize| {
        let (x, y) = (i % geometry.width, i / geometry.width);
        let d = distance.distance(x, y)?;
        let cosine = geometry.cos_off_axis(x, y);
        let depth = geometry.along_axis(x, y, d);
        let z = geometry.along_axis(x, y, d - geometry.surface.at(x, y));
        let node = Node { z, pitch: geometry.pixel_pitch(depth) };
        let (light, slope) = light_and_slope(i);
        let occluders = occluders.iter().take_while(|occluder| occluder.depth < depth).count();
        (z > 0.0).then_some(Source { node, cosine, light, slope, occluders })
    };
    (0..geometry.width * geometry.height).into_par_iter().map(source).collect()
}
