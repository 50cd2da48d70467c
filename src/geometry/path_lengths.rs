//! How long the paths through the medium are.

use super::Geometry;
use crate::image::Image;

/// Path lengths of all pixels of all scenes, length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathLengths {
    /// Their median.
    pub median: f64,
    /// The longest.
    pub longest: f64,
}

/// Path lengths over the pixels of all scenes, each with its clear radiance, that send light; over all pixels if none does. A flat
/// scene counts as many times as it has pixels.
///
/// # Panics
/// If no scene shows an object.
pub fn path_lengths(scenes: &[(&Geometry, &Image)]) -> PathLengths {
    let mut weighted: Vec<(f64, usize)> = Vec::new();
    for (geometry, radiance) in scenes {
        let lengths = geometry.path_lengths();
        if let [z] = lengths[..] {
            weighted.push((z, geometry.width * geometry.height));
            continue;
        }
        let pixels = (0..geometry.height).flat_map(|y| (0..geometry.width).map(move |x| (x, y)));
        let lit = pixels.filter(|&(x, y)| radiance.at(x, y) != 0.0);
        let lit: Vec<f64> = lit.filter_map(|(x, y)| geometry.path_length(x, y)).collect();
        let lengths = if lit.is_empty() { lengths } else { lit };
        weighted.extend(lengths.into_iter().map(|z| (z, 1)));
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
