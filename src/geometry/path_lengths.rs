//! How long the paths through the medium are.

use super::Geometry;

/// Path lengths of all pixels of all scenes, length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLengths {
    /// Their median.
    pub median: f64,
    /// The longest.
    pub longest: f64,
}

/// Path lengths over the pixels of all scenes; a flat scene counts as many times as it has pixels.
///
/// # Panics
/// If no scene shows an object.
pub fn path_lengths(scenes: &[&Geometry]) -> PathLengths {
    let mut weighted: Vec<(f64, usize)> = Vec::new();
    for geometry in scenes {
        let lengths = geometry.path_lengths();
        let weight = if lengths.len() == 1 { geometry.width * geometry.height } else { 1 };
        weighted.extend(lengths.into_iter().map(|z| (z, weight)));
    }
    weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = weighted.iter().map(|(_, weight)| weight).sum::<usize>() / 2;
    let mut passed = 0;
    let reached = |&&(_, weight): &&(f64, usize)| {
        passed += weight;
        passed > half
    };
    let median = weighted.iter().find(reached).expect("checked: every scene shows an object").0;
    PathLengths { median, longest: weighted[weighted.len() - 1].0 }
}
