//! White normal noise, for images that are fitted again.

use crate::image::Image;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// `image` with independent normal noise of standard deviation `noise` on every pixel; the same for the same `seed`.
pub fn with_noise(image: &Image, noise: f64, seed: u64) -> Image {
    noisy(image, |_| noise, seed)
}

/// `image` with independent normal noise of the `variance` of each pixel; the same for the same `seed`.
pub fn with_variance(image: &Image, variance: &Image, seed: u64) -> Image {
    noisy(image, |i| f64::from(variance.data[i]).sqrt(), seed)
}

fn noisy(image: &Image, std_deviation: impl Fn(usize) -> f64, seed: u64) -> Image {
    let mut stream = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut noisy = image.clone();
    for (i, value) in noisy.data.iter_mut().enumerate() {
        let drawn: f64 = StandardNormal.sample(&mut stream);
        *value += (std_deviation(i) * drawn) as f32;
    }
    noisy
}
