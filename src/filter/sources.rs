//! What sends light, pixel by pixel: the object and its further layers, or what is supposed to be hidden.

use super::Target;
use super::slices::Node;
use crate::geometry::Field;
use crate::relief::{Relief, Screen};
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
    /// Number of screens that its light must pass.
    pub screens: usize,
}

/// One source for every pixel of the object image, row-major; `None` where there is nothing.
pub(super) type Sheet = Vec<Option<Source>>;

/// The object alone if every pixel's light spreads freely; with its relief, the further layers too.
pub(super) fn sheets(target: &Target) -> Vec<Sheet> {
    let Some(relief) = target.relief else {
        return vec![sheet(target, &[], &target.geometry.depth, |i| (target.radiance.data[i], [0.0; 2]))];
    };
    let layers = std::iter::once((&target.geometry.depth, target.radiance))
        .chain(target.geometry.behind.iter().zip(target.behind));
    let mut all: Vec<Sheet> = Vec::new();
    for ((distance, radiance), slopes) in layers.zip(&relief.slopes) {
        let slope = |i: usize| slopes.as_ref().map_or([0.0; 2], |s| s[i]);
        let mut layer = sheet(target, &relief.screens, distance, |i| (radiance.data[i], slope(i)));
        // A pixel behind another, with no screen between them, lies too close behind it to be seen.
        for (i, source) in layer.iter_mut().enumerate() {
            let Some(nearer) = all.iter().filter_map(|nearer| nearer[i]).map(|s| s.screens).max() else {
                continue;
            };
            let between = |s: &Source| relief.screens.get(nearer..s.screens).unwrap_or_default();
            *source = source.filter(|s| between(s).iter().any(|screen| screen.opaque[i]));
        }
        all.push(layer);
    }
    all
}

/// Light of radiance 1 from everything that is supposed, but not known, to lie behind the screens of `relief`.
pub(super) fn hidden_sheets(target: &Target, relief: &Relief) -> Vec<Sheet> {
    let hidden = relief.screens.iter().map(|screen| &screen.hidden);
    hidden.map(|distance| sheet(target, &relief.screens, distance, |_| (1.0, [0.0; 2]))).collect()
}

fn sheet(
    target: &Target,
    screens: &[Screen],
    distance: &Field,
    light_and_slope: impl Fn(usize) -> (f32, [f32; 2]) + Sync,
) -> Sheet {
    let geometry = target.geometry;
    let source = |i: usize| {
        let (x, y) = (i % geometry.width, i / geometry.width);
        let d = distance.distance(x, y)?;
        let cosine = geometry.cos_off_axis(x, y);
        let depth = geometry.along_axis(x, y, d);
        let z = geometry.along_axis(x, y, d - geometry.surface.at(x, y));
        let node = Node { z, pitch: geometry.pixel_pitch(depth) };
        let (light, slope) = light_and_slope(i);
        let screens = screens.iter().take_while(|screen| screen.depth < depth).count();
        (z > 0.0).then_some(Source { node, cosine, light, slope, screens })
    };
    (0..geometry.width * geometry.height).into_par_iter().map(source).collect()
}
