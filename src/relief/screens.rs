//! Which depths serve as screens.
//!
//! Every edge between a near pixel at d and a far one at d' asks for a screen just behind d: there the light of the
//! far one is stopped. One at d + f (d' - d) still serves, with an error that grows with f. So the edges are
//! intervals, to be pierced by as few depths as possible; each screen lies at the farthest of the near pixels whose
//! edges it serves. Edges count by their gap, and screens that serve next to nothing are left out: a screen farther
//! back in the gap serves their edges too.

use super::map::DepthMap;

/// Screens at most: each costs a round trip through image space.
pub const MOST_SCREENS: usize = 6;
/// Share of the gap behind a near pixel in which its screen may lie.
const SHARE: f64 = 0.5;
/// Gaps of less than this share of the path length behind them are left to eq. 29.
const LEAST_GAP: f64 = 0.05;
/// Share of all gaps that screens must serve.
const SERVED: f64 = 0.99;

/// A depth that pierces some intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piercing {
    depth: f64,
    /// Sum of the gaps that it serves.
    gaps: f64,
}

/// Depths of the screens, increasing.
pub(super) fn depths(maps: &[DepthMap]) -> Vec<f64> {
    // Where a further layer ends it may go on as the object itself.
    let farthest = farthest(maps);
    let counts = |layer: usize, [_, far]: [f64; 2]| layer == 0 || far.is_finite();
    let mut edges: Vec<[f64; 2]> = (0..maps.len())
        .flat_map(|layer| edges(&maps[layer]).filter(move |&edge| counts(layer, edge)))
        .map(|[near, far]| [near, far.min(farthest)])
        .filter(|[near, far]| far > near)
        .collect();
    edges.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut depths = pierced(&edges, SHARE);
    let all: f64 = depths.iter().map(|d| d.gaps).sum();
    depths.sort_by(|a, b| b.gaps.total_cmp(&a.gaps));
    let mut served = 0.0;
    depths.truncate(MOST_SCREENS);
    depths.retain(|depth| {
        let needed = served < SERVED * all;
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

/// Near and far depth of every edge that matters; an edge to nothing may still cover other objects.
fn edges<'a>(map: &'a DepthMap) -> impl Iterator<Item = [f64; 2]> + 'a {
    let pairs = (0..map.depth.len()).flat_map(|i| {
        [map.neighbours(i)[1], map.neighbours(i)[3]].into_iter().flatten().map(move |j| (i, j))
    });
    pairs.filter_map(move |(i, j)| {
        let (i, j) = if map.depth[i] <= map.depth[j] { (i, j) } else { (j, i) };
        let (near, far) = (map.depth[i], map.depth[j]);
        let counts = near.is_finite() && map.is_edge(near, far);
        let matters = far.is_infinite() || far - near > LEAST_GAP * map.path_length(i, far);
        (counts && matters).then_some([near, far])
    })
}

/// The fewest depths that lie in the first `share` of all `edges`, which are sorted by their near ends.
fn pierced(edges: &[[f64; 2]], share: f64) -> Vec<Piercing> {
    let mut depths: Vec<Piercing> = Vec::new();
    let mut end = f64::NEG_INFINITY;
    for &[near, far] in edges {
        let gap = far - near;
        let reach = near + share * gap;
        match depths.last_mut() {
            Some(last) if near <= end => {
                *last = Piercing { depth: near, gaps: last.gaps + gap };
                end = end.min(reach);
            }
            _ => {
                depths.push(Piercing { depth: near, gaps: gap });
                end = reach;
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
        let found = |share| pierced(&edges, share).iter().map(|d| (d.depth, d.gaps)).collect::<Vec<_>>();
        assert_eq!(found(0.125), vec![(1.0625, 2.9375), (1.25, 0.75), (2.0, 1.0)]);
        assert_eq!(found(0.5), vec![(1.25, 3.6875), (2.0, 1.0)]);
    }
}
