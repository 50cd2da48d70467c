//! Scenes and comparators shared by the tests.
#![allow(dead_code, unused_imports, reason = "each bench uses its own part")]

pub mod bundled;
pub mod estimates;
pub mod planes;
pub mod program;
pub mod recovery;
pub mod report;

pub use narrowbeam::fit::noise::with_noise;
use narrowbeam::geometry::{Camera, Field, Geometry};
use narrowbeam::image::Image;

/// A texture with edges and smooth parts, positive.
pub fn texture(width: usize, height: usize) -> Image {
    Image::from_fn(width, height, |x, y| {
        let checker = if (x / 5 + y / 7) % 2 == 0 { 0.7 } else { 0.1 };
        let wave = 0.2 * (1.0 + (0.31 * x as f32 + 0.17 * y as f32).sin());
        let spot = if (x * 7 + y * 13) % 29 == 0 { 0.8 } else { 0.0 };
        checker + wave + spot
    })
}

/// A plane whose depth grows by `slope` per length towards the right, seen by parallel rays.
pub fn sloping(width: usize, height: usize, pixel_pitch: f64, mean_depth: f64, slope: f64) -> Geometry {
    let depth = Image::from_fn(width, height, |x, _| {
        (mean_depth + slope * pixel_pitch * (x as f64 + 0.5 - 0.5 * width as f64)) as f32
    });
    Geometry {
        width,
        height,
        camera: Camera::orthographic(pixel_pitch).unwrap(),
        depth: Field::Map(depth),
        behind: Vec::new(),
        surface: Field::Uniform(0.0),
    }
}

/// Half a slope, half a plane behind it, with an edge between them.
pub fn edge_and_slope(side: usize) -> Geometry {
    let depth = |x: usize, y: usize| if x < side / 2 { 0.6 + 0.02 * y as f32 } else { 2.0 };
    Geometry {
        width: side,
        height: side,
        camera: Camera::orthographic(0.05).unwrap(),
        depth: Field::Map(Image::from_fn(side, side, depth)),
        behind: Vec::new(),
        surface: Field::Uniform(0.0),
    }
}

/// Relative L2 distance of `a` from `b`.
pub fn relative_l2(a: impl IntoIterator<Item = f64>, b: impl IntoIterator<Item = f64>) -> f64 {
    let (mut difference, mut whole) = (0.0, 0.0);
    for (a, b) in a.into_iter().zip(b) {
        difference += (a - b) * (a - b);
        whole += b * b;
    }
    (difference / whole).sqrt()
}

/// The pixels of an image as f64.
pub fn pixels(image: &Image) -> impl Iterator<Item = f64> + '_ {
    image.data.iter().map(|&v| f64::from(v))
}
