//! What lies behind everything and sends no light is nothing.

use crate::geometry::{Field, Geometry};
use crate::image::{Channel, Image};

/// Empties the pixels of the depth map that are black in all channels and farther than everything that is not: they send no
/// light and cover nothing, so they should set no bound, no slice and no cost. Pixels behind which a further layer lies stay.
pub(super) fn empty_dark_background(geometry: &mut Geometry, object: &[Channel], behind: &[Vec<Image>]) {
    let lit = |x: usize, y: usize| object.iter().any(|channel| channel.image.at(x, y) != 0.0);
    let (width, height) = (geometry.width, geometry.height);
    let pixels = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let farthest = pixels().filter(|&(x, y)| lit(x, y)).filter_map(|(x, y)| geometry.object_distance(x, y));
    let farthest = farthest.fold(0.0, f64::max);
    if behind.iter().any(|layers| !layers.is_empty()) || farthest == 0.0 {
        return;
    }
    if let Field::Map(depth) = &mut geometry.depth {
        for (x, y) in pixels().filter(|&(x, y)| !lit(x, y)) {
            let distance = &mut depth.data[y * width + x];
            if f64::from(*distance) > farthest {
                *distance = 0.0;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Camera;

    #[test]
    fn only_what_is_black_and_behind_everything_is_emptied() {
        let depth = Image { width: 4, height: 1, data: vec![1.0, 2.0, 15.0, 1.5] };
        let light = Image { width: 4, height: 1, data: vec![0.0, 1.0, 0.0, 0.5] };
        let mut geometry = Geometry {
            width: 4,
            height: 1,
            camera: Camera::orthographic(0.1).unwrap(),
            depth: Field::Map(depth),
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        };
        empty_dark_background(&mut geometry, &[Channel { name: "Y".into(), image: light }], &[Vec::new()]);
        let left: Vec<Option<f64>> = (0..4).map(|x| geometry.object_distance(x, 0)).collect();
        assert_eq!(left, [Some(1.0), Some(2.0), None, Some(1.5)]);
    }
}
