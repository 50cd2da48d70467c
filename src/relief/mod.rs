//! The relief of an object: its slopes, and the depth edges at which a near surface covers a far one.
//!
//! Eq. 29 of Shinya et al. lets the light of every object pixel spread freely. What it leaves out is found here,
//! from the geometry alone:
//!
//! - **Slopes.** Within a surface nothing is occluded, but oblique paths meet a sloping surface at another rate: each
//!   pixel has its own [`slope`](Slopes), from which the filter computes a slope correction.
//! - **Occluders.** Across an edge the near surface blocks the light of what lies behind it. A few depths, the occluders
//!   ([`occluders`](Relief::occluders)), represent all edges. At each of them some pixels are opaque.
//! - **Hidden light.** What lies behind opaque pixels is known from further layers, or not at all. Then its depth is
//!   inpainted from the far side of the edge, and the light that it may send counts as hidden.
//!
//! Two neighbouring pixels belong to one surface unless their depths differ by more than
//! [`EDGE_PITCHES`](crate::geometry::EDGE_PITCHES) pixel lengths, and by more than eight times the depth map's own
//! noise (`map`).

mod edges;
mod front;
mod map;
mod occluders;

use crate::geometry::{Camera, Field, Geometry, median};
use front::Front;
use map::DepthMap;

/// Slope along x and y of the depth along the camera's axis at every pixel of a layer, length per pixel.
pub type Slopes = Vec<[f32; 2]>;

/// An occluder: a depth at which near surfaces cover what lies behind.
#[derive(Debug, Clone)]
pub struct Occluder {
    /// Depth along the camera's axis: light from beyond must pass the occluder.
    pub depth: f64,
    /// Path length in the medium to the occluder, along the camera's axis: one for all pixels.
    pub z: f64,
    /// Whether a pixel (row-major over the object image) lets no light pass.
    pub opaque: Vec<bool>,
    /// Inpainted distance behind each opaque pixel where no layer is known; 0 elsewhere.
    pub hidden: Field,
}

/// Slopes and occluders of an object.
#[derive(Debug, Clone)]
pub struct Relief {
    /// Slopes of the object and of each further layer; `None` for a layer without any.
    pub slopes: Vec<Option<Slopes>>,
    /// The occluders, from near to far.
    pub occluders: Vec<Occluder>,
}

impl Relief {
    /// The relief of `geometry`.
    pub fn new(geometry: &Geometry) -> Self {
        let fields = || std::iter::once(&geometry.depth).chain(&geometry.behind);
        let facing =
            matches!((geometry.camera, &geometry.depth), (Camera::Orthographic { .. }, Field::Uniform(_)));
        if facing && geometry.behind.is_empty() {
            return Self { slopes: vec![None], occluders: Vec::new() };
        }
        let maps: Vec<DepthMap> = fields().map(|field| DepthMap::new(geometry, field)).collect();
        let slopes = maps.iter().map(DepthMap::slopes).collect();
        let mut front = Front::new(&maps);
        let mut occluders = Vec::new();
        for depth in occluders::depths(&maps) {
            let (opaque, hidden) = front.remove_before(depth);
            if opaque.contains(&true) {
                occluders.push(occluder(&maps[0], depth, opaque, hidden));
            }
        }
        settle_path_lengths(&mut occluders, &maps);
        Self { slopes, occluders }
    }

    /// Whether every pixel's light spreads freely, as eq. 29 has it.
    pub fn is_flat(&self) -> bool {
        self.occluders.is_empty() && self.slopes.iter().all(Option::is_none)
    }

    /// Distance of every pixel of the object image of `geometry`, row-major, from the nearest edge of a near surface, px; infinite without one.
    pub(crate) fn edge_distances_px(&self, geometry: &Geometry) -> Vec<f32> {
        edges::distances(&self.occluders, geometry.width, geometry.height)
    }

    /// Whether some light may come from surfaces that no image shows.
    pub fn hides(&self) -> bool {
        let any = |occluder: &Occluder| matches!(&occluder.hidden, Field::Map(map) if map.data.iter().any(|&d| d > 0.0));
        self.occluders.iter().any(any)
    }
}

/// Slopes of the object within its surfaces; `None` if it has none.
pub(crate) fn surface_slopes(geometry: &Geometry) -> Option<Slopes> {
    DepthMap::new(geometry, &geometry.depth).slopes()
}

/// The occluder at `depth`; its path length is the median over its opaque pixels.
fn occluder(map: &DepthMap, depth: f64, opaque: Vec<bool>, hidden: Field) -> Occluder {
    let covered = (0..opaque.len()).filter(|&i| opaque[i]);
    let z = median(covered.map(|i| map.path_length(i, depth)).collect());
    Occluder { depth, z, opaque, hidden }
}

/// Under an uneven surface of the medium, an occluder's path length may exceed that of something behind it. Light cannot
/// gain on its way, so the shorter one is then used for both.
fn settle_path_lengths(occluders: &mut [Occluder], maps: &[DepthMap]) {
    let mut beyond = f64::INFINITY;
    for occluder in occluders.iter_mut().rev() {
        for map in maps {
            let behind =
                |(i, &d): (usize, &f64)| (d > occluder.depth && d.is_finite()).then(|| map.path_length(i, d));
            beyond = map.depth.iter().enumerate().filter_map(behind).fold(beyond, f64::min);
        }
        occluder.z = occluder.z.min(beyond);
    }
}
