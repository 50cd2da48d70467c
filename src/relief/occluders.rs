//! The depths of the occluders.
//!
//! Every edge between a near pixel at d and a far one at d' needs an occluder just behind d, which blocks the light of
//! the far pixel. An occluder farther back still serves, with an error that grows with the distance: it may lie in the
//! first half of the gap, and no farther behind the near pixel than a quarter of that pixel's path length. So the edges
//! are intervals, to be pierced by as few depths as possible. Each occluder lies at the farthest of the near pixels
//! whose edges it serves, and behind their noise. Edges are weighted by their gap. Occluders that serve very little are
//! left out: one farther back in the gap serves their edges too.

use super::map::DepthMap;

/// Largest number of occluders: each costs a transform to image space and back.
const MOST_OCCLUDERS: usize = 6;
/// Share of the gap behind a near pixel in which its occluder may lie, and share of the near pixel's path length.
const SHARE: f64 = 0.5;
const NEARBY: f64 = 0.25;
/// Gaps of less than this share of the path length behind them are left to eq. 29.
const LEAST_GAP: f64 = 0.05;
/// Share of all gaps that occluders must serve.
const SERVED: f64 = 0.99;

/// The depths at which an occluder serves an edge, and the gap of that edge.
#[derive(Debug, Clone, Copy)]
struct Edge {
    near: f64,
    reach: f64,
    gap: f64,
}

/// A depth that pierces some intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piercing {
    depth: f64,
    /// Sum of the gaps that it serves.
    gaps: f64,
}

/// Depths of the occluders, increasing.
pub(super) fn depths(maps: &[DepthMap]) -> Vec<f64> {
    let farthest = farthest(maps);
    let mut all: Vec<Edge> = Vec::new();
    for (layer, map) in maps.iter().enumerate() {
        // Where a further layer ends, the object itself may continue it.
        all.extend(
            edges(map, farthest).filter(|&(far, _)| layer == 0 || far.is_finite()).map(|(_, edge)| edge),
        );
    }
    all.sort_by(|a, b| a.near.total_cmp(&b.near));
    let behind_noise = maps.iter().map(|map| map.least_step).fold(0.0, f64::max);
    let mut depths = pierced(&all, behind_noise);
    let gaps: f64 = depths.iter().map(|d| d.gaps).sum();
    depths.sort_by(|a, b| b.gaps.total_cmp(&a.gaps));
    let mut served = 0.0;
    depths.truncate(MOST_OCCLUDERS);
    depths.retain(|depth| {
        let needed = served < SERVED * gaps;
        served += depth.gaps;
        needed
    });
    depths.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    depths.into_iter().map(|d| d.depth).collect()
}

fn farthest(maps: &[DepthMap]) -> f64 {
    let there = maps.iter().flat_map(|m| &m.depth).copied().filter(|d| d.is_finite());
    there.fold(0.0, f64::max)
}

/// Every edge that matters, with its far depth. An edge to empty pixels may still cover other objects.
fn edges<'a>(map: &'a DepthMap, farthest: f64) -> impl Iterator<Item = (f64, Edge)> + 'a {
    let pairs = (0..map.depth.len()).flat_map(|i| {
        [map.neighbours(i)[1], map.neighbours(i)[3]].into_iter().flatten().map(move |j| (i, j))
    });
    pairs.filter_map(move |(i, j)| {
        let (i, j) = if map.depth[i] <= map.depth[j] { (i, j) } else { (j, i) };
        let (near, far) = (map.depth[i], map.depth[j]);
        let gap = far.min(farthest) - near;
        let counts =
            near.is_finite() && map.is_edge(near, far) && gap > LEAST_GAP * map.path_length(i, near + gap);
        let reach = near + (SHARE * gap).min(NEARBY * map.path_length(i, near));
        counts.then_some((far, Edge { near, reach, gap }))
    })
}

/// The fewest depths that lie within reach of all `edges`, which are sorted by their near ends; `behind_noise` farther
/// back, if that is within reach too.
fn pierced(edges: &[Edge], behind_noise: f64) -> Vec<Piercing> {
    let mut depths: Vec<Piercing> = Vec::new();
    let mut end = f64::NEG_INFINITY;
    for &Edge { near, reach, gap } in edges {
        match depths.last_mut() {
            Some(last) if near <= end => {
                end = end.min(reach);
                *last = Piercing { depth: (near + behind_noise).min(end), gaps: last.gaps + gap };
            }
            _ => {
                end = reach;
                depths.push(Piercing { depth: (near + behind_noise).min(end), gaps: gap });
            }
        }
    }
    depths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_depths_pierce_all_intervals_as_early_as_they_can() {
        let edges = [[1.0, 2.0], [1.0625, 3.0], [1.25, 2.0], [2.0, 3.0]];
        let found = |share: f64, noise: f64| {
            let edge =
                |&[near, far]: &[f64; 2]| Edge { near, reach: near + share * (far - near), gap: far - near };
            let edges: Vec<Edge> = edges.iter().map(edge).collect();
            pierced(&edges, noise).iter().map(|d| (d.depth, d.gaps)).collect::<Vec<_>>()
        };
        assert_eq!(found(0.125, 0.0), vec![(1.0625, 2.9375), (1.25, 0.75), (2.0, 1.0)]);
        assert_eq!(found(0.5, 0.0), vec![(1.25, 3.6875), (2.0, 1.0)]);
        assert_eq!(found(0.5, 0.125), vec![(1.375, 3.6875), (2.125, 1.0)]);
    }
}
