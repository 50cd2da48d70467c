//! Peeling: from near to far, each screen takes away the surfaces that end before it.
//!
//! At a screen, a pixel whose surface lies before it is opaque if along that surface the way to an edge over the
//! screen's depth is shorter than the way to where the surface itself crosses that depth. So an object that stands
//! before others is opaque as a whole, while a plane that slopes through the screen is not. Behind an opaque pixel
//! comes the next known layer there; behind the last one, the surface across the nearest edge is supposed to go on.

use super::map::DepthMap;
use crate::geometry::Field;
use crate::image::Image;
use std::collections::VecDeque;

/// What is seen from the camera after some surfaces have been taken away.
pub(super) struct Front<'a> {
    maps: &'a [DepthMap<'a>],
    distance: Vec<f64>,
    /// The layer that is seen at each pixel; beyond the last where nothing is known.
    layer: Vec<usize>,
}

impl<'a> Front<'a> {
    pub(super) fn new(maps: &'a [DepthMap<'a>]) -> Self {
        let pixels = maps[0].distance.len();
        let mut front = Self { maps, distance: vec![0.0; pixels], layer: vec![0; pixels] };
        (0..pixels).for_each(|i| front.show(i, 0, 0.0));
        front
    }

    /// Shows the nearest layer from `first` on that lies beyond `beyond`, or else nothing.
    fn show(&mut self, i: usize, first: usize, beyond: f64) {
        let there = |layer: &usize| {
            let d = self.maps[*layer].distance[i];
            d > beyond && d.is_finite()
        };
        let layer = (first..self.maps.len()).find(there);
        self.distance[i] = layer.map_or(f64::INFINITY, |layer| self.maps[layer].distance[i]);
        self.layer[i] = layer.unwrap_or(self.maps.len());
    }

    /// Takes away what covers something beyond `screen`: the opaque pixels, and the distance of what is supposed, but
    /// not known, to be behind them.
    pub(super) fn peel(&mut self, screen: f64) -> (Vec<bool>, Field) {
        let across = self.across(screen);
        let width = self.maps[0].geometry.width;
        let mut hidden = Image::filled(width, across.len() / width, 0.0);
        for (i, supposed) in across.iter().enumerate() {
            let Some(supposed) = supposed else { continue };
            let next = self.layer[i] + 1;
            if next < self.maps.len() {
                self.show(i, next, screen);
            } else {
                self.distance[i] = *supposed;
                if supposed.is_finite() {
                    hidden.data[i] = *supposed as f32;
                }
            }
        }
        (across.iter().map(Option::is_some).collect(), Field::Map(hidden))
    }

    /// For each opaque pixel, the distance beyond `screen` across the edge that is nearest along its surface; infinite
    /// if nothing is there.
    fn across(&self, screen: f64) -> Vec<Option<f64>> {
        let (map, distance) = (&self.maps[0], &self.distance);
        let mut across = vec![None; distance.len()];
        let mut reached = vec![false; distance.len()];
        let mut queue = VecDeque::new();
        for i in (0..distance.len()).filter(|&i| distance[i] <= screen) {
            let mut beyond = map.neighbours(i).into_iter().flatten().filter(|&j| distance[j] > screen);
            if let Some(first) = beyond.next() {
                let joined = |j: usize| !map.is_edge(i, distance[i], distance[j]);
                across[i] = (!joined(first) && !beyond.any(joined)).then_some(distance[first]);
                reached[i] = true;
                queue.push_back(i);
            }
        }
        while let Some(i) = queue.pop_front() {
            for j in map.neighbours(i).into_iter().flatten() {
                let open = !reached[j] && distance[j] <= screen;
                if open && !map.is_edge(i, distance[i], distance[j]) {
                    reached[j] = true;
                    across[j] = across[i];
                    queue.push_back(j);
                }
            }
        }
        across
    }
}
