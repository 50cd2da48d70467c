//! Which depths serve as screens.
//!
//! Every edge between a near pixel at d and a far one at d' asks for a screen just behind d: there the light of the
//! far one is stopped. One at d + f (d' - d) still serves, with an error that grows with f. So the edges are
//! intervals to be pierced by as few depths as possible, and f is the smallest of a few for which that takes at most
//! [`MOST_SCREENS`]. Each screen lies at the farthest of the near pixels whose edges it serves.

use super::map::DepthMap;

/// Screens at most: each costs a round trip through image space.
pub const MOST_SCREENS: usize = 6;
/// Shares of the gap behind a near pixel in which its screen may lie.
const SHARES: [f64; 4] = [0.1, 0.2, 0.4, 0.8];
/// Gaps of less than this share of the path length behind them are left to eq. 29.
const LEAST_GAP: f64 = 0.05;

/// Distances of the screens, increasing.
pub(super) fn distances(maps: &[DepthMap]) -> Vec<f64> {
    let mut edges: Vec<[f64; 2]> = maps.iter().flat_map(|map| edges(map, farthest(maps))).collect();
    edges.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut groups = Vec::new();
    for share in SHARES {
        groups = pierced(&edges, share);
        if groups.len() <= MOST_SCREENS {
            break;
        }
    }
    // Too many all the same: those that serve the most edges.
    groups.sort_by_key(|&(_, served)| std::cmp::Reverse(served));
    groups.truncate(MOST_SCREENS);
    let mut distances: Vec<f64> = groups.into_iter().map(|(distance, _)| distance).collect();
    distances.sort_by(f64::total_cmp);
    distances
}

fn farthest(maps: &[DepthMap]) -> f64 {
    let there = maps.iter().flat_map(|m| &m.distance).copied().filter(|d| d.is_finite());
    there.fold(0.0, f64::max)
}

/// Near and far distance of every edge that matters; an edge to nothing may still cover the farthest object.
fn edges<'a>(map: &'a DepthMap, farthest: f64) -> impl Iterator<Item = [f64; 2]> + 'a {
    let pairs = (0..map.distance.len()).flat_map(|i| {
        [map.neighbours(i)[1], map.neighbours(i)[3]].into_iter().flatten().map(move |j| (i, j))
    });
    pairs.filter_map(move |(i, j)| {
        let (i, j) = if map.distance[i] <= map.distance[j] { (i, j) } else { (j, i) };
        let (near, far) = (map.distance[i], map.distance[j]);
        let gap = far.min(farthest) - near;
        let counts = near.is_finite() && map.is_edge(i, near, far);
        (counts && gap > LEAST_GAP * map.path_length(i, near + gap)).then_some([near, near + gap])
    })
}

/// The fewest depths that lie in the first `share` of all `edges` (sorted by their near ends), and how many each serves.
fn pierced(edges: &[[f64; 2]], share: f64) -> Vec<(f64, usize)> {
    let mut groups: Vec<(f64, usize)> = Vec::new();
    let mut end = f64::NEG_INFINITY;
    for &[near, far] in edges {
        let reach = near + share * (far - near);
        if near > end {
            groups.push((near, 1));
            end = reach;
        } else {
            let group = groups.last_mut().expect("nothing lies before the first group's end");
            *group = (near, group.1 + 1);
            end = end.min(reach);
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_depths_pierce_all_intervals_as_early_as_they_can() {
        let edges = [[1.0, 2.0], [1.05, 3.0], [1.2, 2.0], [2.0, 3.0]];
        assert_eq!(pierced(&edges, 0.1), vec![(1.05, 2), (1.2, 1), (2.0, 1)]);
        assert_eq!(pierced(&edges, 0.5), vec![(1.2, 3), (2.0, 1)]);
    }
}
