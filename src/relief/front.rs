//! What the camera sees after each occluder, from near to far, has removed the surfaces that end in front of it.
//!
//! A pixel whose surface lies in front of an occluder is opaque there if the surface reaches an edge across the
//! occluder's depth before it crosses that depth itself. So an object that stands in front of others is opaque as a
//! whole, while a plane that slopes through the occluder is not. Behind an opaque pixel lies the next known layer
//! there. Behind the last one the depth is inpainted from the surroundings of the opaque pixels with the smoothest
//! surface between them (a harmonic function), which continues a plane as a plane.

use super::map::DepthMap;
use crate::geometry::Field;
use crate::image::Image;
use std::collections::VecDeque;

/// Successive over-relaxation of the inpainted depths: its factor, the relative change of a depth below which it ends,
/// and the largest number of sweeps. It need not converge: the result only has to be continuous with its surroundings.
const OVER_RELAXATION: f64 = 1.9;
const RELAXED: f64 = 1e-5;
const MOST_SWEEPS: usize = 200;

/// What is seen from the camera after some surfaces have been removed.
pub(super) struct Front<'a> {
    maps: &'a [DepthMap<'a>],
    depth: Vec<f64>,
    /// The layer that is seen at each pixel; beyond the last where nothing is known.
    layer: Vec<usize>,
}

impl<'a> Front<'a> {
    pub(super) fn new(maps: &'a [DepthMap<'a>]) -> Self {
        let pixels = maps[0].depth.len();
        let mut front = Self { maps, depth: vec![0.0; pixels], layer: vec![0; pixels] };
        (0..pixels).for_each(|i| front.show(i, 0, 0.0));
        front
    }

    /// Shows the nearest layer from `first` on that lies beyond `beyond`, or else nothing.
    fn show(&mut self, i: usize, first: usize, beyond: f64) {
        let there = |layer: &usize| {
            let d = self.maps[*layer].depth[i];
            d > beyond && d.is_finite()
        };
        let layer = (first..self.maps.len()).find(there);
        self.depth[i] = layer.map_or(f64::INFINITY, |layer| self.maps[layer].depth[i]);
        self.layer[i] = layer.unwrap_or(self.maps.len());
    }

    /// Removes the surfaces that cover something beyond the depth `occluder`. Returns which pixels are opaque, and the
    /// inpainted distance behind those where no layer is known.
    pub(super) fn remove_before(&mut self, occluder: f64) -> (Vec<bool>, Field) {
        let across = self.across(occluder);
        let opaque: Vec<bool> = across.iter().map(Option::is_some).collect();
        let inpainted = self.inpaint(across);
        let geometry = self.maps[0].geometry;
        let mut hidden = Image::filled(geometry.width, geometry.height, 0.0);
        for i in (0..opaque.len()).filter(|&i| opaque[i]) {
            let unknown = self.layer[i] + 1 >= self.maps.len();
            self.show(i, self.layer[i] + 1, occluder);
            if self.depth[i].is_infinite() {
                self.depth[i] = inpainted[i];
            }
            if unknown && inpainted[i] > occluder && inpainted[i].is_finite() {
                let (x, y) = (i % geometry.width, i / geometry.width);
                hidden.data[i] = (inpainted[i] / geometry.cos_off_axis(x, y)) as f32;
            }
        }
        (opaque, Field::Map(hidden))
    }

    /// The depths that may lie behind opaque pixels: `across` at first, relaxed towards the mean of the neighbours.
    /// Neighbours in front of them do not count: they say nothing about what is behind.
    fn inpaint(&self, across: Vec<Option<f64>>) -> Vec<f64> {
        let (map, depth) = (&self.maps[0], &self.depth);
        let mut inpainted: Vec<f64> = across.iter().zip(depth).map(|(a, d)| a.unwrap_or(*d)).collect();
        let opaque: Vec<usize> = (0..across.len()).filter(|&i| across[i].is_some()).collect();
        let counts = |i: usize, j: usize| {
            across[j].is_some() || depth[j] > depth[i] || !map.is_edge(depth[i], depth[j])
        };
        let around: Vec<Vec<usize>> = opaque
            .iter()
            .map(|&i| map.neighbours(i).into_iter().flatten().filter(|&j| counts(i, j)).collect())
            .collect();
        for sweep in 0..MOST_SWEEPS {
            let mut change: f64 = 0.0;
            for n in 0..opaque.len() {
                // Alternate directions, so that depths known at one end soon reach the other.
                let n = if sweep % 2 == 0 { n } else { opaque.len() - 1 - n };
                let (i, around) = (opaque[n], &around[n]);
                let known = || around.iter().map(|&j| inpainted[j]).filter(|d| d.is_finite());
                let count = known().count();
                if count == 0 || inpainted[i].is_infinite() {
                    continue;
                }
                let step = known().sum::<f64>() / count as f64 - inpainted[i];
                inpainted[i] += OVER_RELAXATION * step;
                change = change.max(step.abs() / inpainted[i]);
            }
            if change < RELAXED {
                break;
            }
        }
        inpainted
    }

    /// For each opaque pixel, the depth beyond `occluder` across the edge that is nearest along its surface; infinite
    /// if nothing is there.
    fn across(&self, occluder: f64) -> Vec<Option<f64>> {
        let (map, depth) = (&self.maps[0], &self.depth);
        let mut across = vec![None; depth.len()];
        let mut reached = vec![false; depth.len()];
        let mut queue = VecDeque::new();
        for i in (0..depth.len()).filter(|&i| depth[i] <= occluder) {
            // Inpainted depths do not count.
            let known = |&j: &usize| {
                depth[j] > occluder && (depth[j].is_infinite() || self.layer[j] < self.maps.len())
            };
            let mut beyond = map.neighbours(i).into_iter().flatten().filter(known);
            if let Some(first) = beyond.next() {
                let joined = |j: usize| !map.is_edge(depth[i], depth[j]);
                across[i] = (!joined(first) && !beyond.any(joined)).then_some(depth[first]);
                reached[i] = true;
                queue.push_back(i);
            }
        }
        while let Some(i) = queue.pop_front() {
            for j in map.neighbours(i).into_iter().flatten() {
                let open = !reached[j] && depth[j] <= occluder;
                if open && !map.is_edge(depth[i], depth[j]) {
                    reached[j] = true;
                    across[j] = across[i];
                    queue.push_back(j);
                }
            }
        }
        across
    }
}
