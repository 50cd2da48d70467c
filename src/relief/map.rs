//! A depth map as surfaces: its edges, its noise and its slopes.

use super::Slopes;
use crate::geometry::{EDGE_PITCHES, Field, Geometry, median};

/// Steps of less than this many times the map's noise are no edges: 5.7 standard deviations of a step between two
/// noisy pixels, one false edge in 10⁸.
const EDGE_NOISES: f64 = 8.0;

/// Depths of one layer along the camera's axis.
pub(super) struct DepthMap<'a> {
    pub geometry: &'a Geometry,
    /// Row-major; infinite where there is no object.
    pub depth: Vec<f64>,
    /// Least step that can be an edge, because of the noise.
    pub least_step: f64,
}

impl<'a> DepthMap<'a> {
    pub(super) fn new(geometry: &'a Geometry, field: &Field) -> Self {
        let (width, height) = (geometry.width, geometry.height);
        let at = |i: usize| {
            let (x, y) = (i % width, i / width);
            field.distance(x, y).map_or(f64::INFINITY, |d| geometry.along_axis(x, y, d))
        };
        let depth: Vec<f64> = (0..width * height).map(at).collect();
        let least_step = EDGE_NOISES * noise(&depth, width);
        Self { geometry, depth, least_step }
    }

    /// The neighbours of pixel `i`: left, right, above, below.
    pub(super) fn neighbours(&self, i: usize) -> [Option<usize>; 4] {
        let width = self.geometry.width;
        [
            (!i.is_multiple_of(width)).then(|| i - 1),
            (i % width + 1 < width).then_some(i + 1),
            i.checked_sub(width),
            (i + width < self.depth.len()).then_some(i + width),
        ]
    }

    /// Whether neighbours at depths `a` and `b` belong to different surfaces.
    pub(super) fn is_edge(&self, a: f64, b: f64) -> bool {
        let step = (a - b).abs();
        step.is_nan() || step > self.least_step && step > EDGE_PITCHES * self.geometry.pixel_pitch(a.min(b))
    }

    /// Path length in the medium to `depth` at pixel `i`, along the camera's axis.
    pub(super) fn path_length(&self, i: usize, depth: f64) -> f64 {
        let (x, y) = (i % self.geometry.width, i / self.geometry.width);
        depth - self.geometry.along_axis(x, y, self.geometry.surface.at(x, y))
    }

    /// Central differences of neighbours on the same surface, one-sided where only one is, 0 where none is; `None` if
    /// all of them are 0.
    pub(super) fn slopes(&self) -> Option<Slopes> {
        let slope = |i: usize, before: Option<usize>, after: Option<usize>| {
            let step = |j: Option<usize>| {
                let j = j.filter(|&j| !self.is_edge(self.depth[i], self.depth[j]))?;
                Some(self.depth[j] - self.depth[i])
            };
            let slope = match (step(before), step(after)) {
                (Some(a), Some(b)) => 0.5 * (b - a),
                (Some(a), None) => -a,
                (None, Some(b)) => b,
                (None, None) => 0.0,
            };
            slope as f32
        };
        let at = |i: usize| {
            let [left, right, above, below] = self.neighbours(i);
            [slope(i, left, right), slope(i, above, below)]
        };
        let slopes: Slopes = (0..self.depth.len()).map(at).collect();
        slopes.iter().any(|s| *s != [0.0; 2]).then_some(slopes)
    }
}

/// Standard deviation of the noise of a depth map, from the median second difference along its rows, on which
/// slopes have no influence and edges little.
fn noise(depth: &[f64], width: usize) -> f64 {
    let second_differences: Vec<f64> = depth
        .chunks(width)
        .flat_map(|row| row.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()))
        .filter(|d| d.is_finite())
        .collect();
    if second_differences.is_empty() {
        return 0.0;
    }
    // The median of |x| is 0.6745 standard deviations of a normal x, and a second difference has variance 1 + 4 + 1.
    median(second_differences) / (0.6745 * 6.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use rand_core::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// A plane with slope `slope` (length per pixel) in x beside one that lies `step` farther, with noise.
    fn relief(slope: f64, step: f64, noise: f64) -> Geometry {
        let mut geometry = Geometry::planar(40, 30, 0.01, 1.0).unwrap();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut uniform = || ((rng.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        let mut normal = || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
        geometry.depth = Field::Map(Image::from_fn(40, 30, |x, _| {
            let beyond = if x < 20 { 0.0 } else { step };
            (1.0 + slope * x as f64 + beyond + noise * normal()) as f32
        }));
        geometry
    }

    fn map(geometry: &Geometry) -> DepthMap<'_> {
        DepthMap::new(geometry, &geometry.depth)
    }

    fn edges(map: &DepthMap) -> Vec<usize> {
        let to = |i: usize, side: usize| {
            map.neighbours(i)[side].is_some_and(|j| map.is_edge(map.depth[i], map.depth[j]))
        };
        (0..map.depth.len()).filter(|&i| to(i, 1) || to(i, 3)).collect()
    }

    #[test]
    fn a_noisy_depth_map_is_cut_at_its_step_and_nowhere_else() {
        for (slope, step, noise) in [(0.0, 0.5, 0.0), (0.02, 0.5, 0.0), (0.0, 0.5, 0.03), (0.02, 0.5, 0.03)] {
            let geometry = relief(slope, step, noise);
            let map = map(&geometry);
            assert!((map.least_step / EDGE_NOISES - noise).abs() <= 0.1 * noise + 1e-7);
            let found = edges(&map);
            assert_eq!(found, (0..30).map(|y| 40 * y + 19).collect::<Vec<_>>(), "{slope} {noise}");
        }
    }

    #[test]
    fn a_step_within_the_noise_is_no_edge() {
        assert!(edges(&map(&relief(0.0, 0.1, 0.03))).is_empty());
    }

    #[test]
    fn slopes_stop_at_edges() {
        let slopes = map(&relief(0.01, 0.5, 0.0)).slopes().unwrap();
        assert!(slopes.iter().all(|s| (s[0] - 0.01).abs() < 1e-6 && s[1] == 0.0));
        assert!(map(&relief(0.0, 0.5, 0.0)).slopes().is_none());
    }
}
