//! White normal noise, for images that are fitted again.

use crate::image::Image;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// `image` with independent normal noise of standard deviation `noise` on every pixel; the same for the same `seed`.
pub fn with_noise(image: &Image, noise: f64, seed: u64) -> Image {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut noisy = image.clone();
    for value in &mut noisy.data {
        let drawn: f64 = StandardNormal.sample(&mut stream);
        *value += (noise * drawn) as f32;
    }
    noisy
}
