//! A small scene to trace, and how traced images are compared.

use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::trace::{ImageConfig, TracedImage, trace_image};

/// A small scene with its medium; fields are changed by each test.
pub struct Setup {
    pub geometry: Geometry,
    pub radiance: Image,
    pub behind: Vec<Image>,
    pub border: Border,
    pub view: View,
    pub medium: Medium,
    pub samples: u32,
    pub seed: u64,
}

impl Setup {
    /// A plane at z = 1 behind parallel rays .02 apart, tau 2, spread angle 10 degrees.
    pub fn plane(width: usize, height: usize, radiance: impl FnMut(usize, usize) -> f32) -> Self {
        let spread = 10.0_f64.to_radians();
        Self {
            geometry: Geometry::planar(width, height, 0.02, 1.0).unwrap(),
            radiance: Image::from_fn(width, height, radiance),
            behind: Vec::new(),
            border: Border::Clamp,
            view: View::whole(width, height),
            medium: Medium::gaussian(2.0, 0.1, 0.25 * spread * spread).unwrap(),
            samples: 64,
            seed: 1,
        }
    }

    pub fn config(&self) -> ImageConfig<'_> {
        ImageConfig {
            geometry: &self.geometry,
            radiance: &self.radiance,
            behind: &self.behind,
            border: self.border,
            view: self.view,
            medium: self.medium,
            samples: self.samples,
            seed: self.seed,
        }
    }

    pub fn trace(&self) -> TracedImage {
        trace_image(&self.config(), &|_| ()).unwrap()
    }

    pub fn size(&self) -> (usize, usize) {
        (self.geometry.width, self.geometry.height)
    }
}

/// Mean of a traced image and its standard error.
pub fn mean(image: &TracedImage) -> (f64, f64) {
    (image.mean.mean(), (image.variance.mean() / image.variance.data.len() as f64).sqrt())
}

/// Mean of each column and the variance of that mean.
pub fn columns(image: &TracedImage) -> Vec<(f64, f64)> {
    let (width, height) = (image.mean.width, image.mean.height);
    let column =
        |i: &Image, x: usize| (0..height).map(|y| f64::from(i.at(x, y))).sum::<f64>() / height as f64;
    (0..width).map(|x| (column(&image.mean, x), column(&image.variance, x) / height as f64)).collect()
}

/// Asserts that independent estimates (value, variance, truth) agree: none 5 standard errors off, and together
/// no more chi² than 4 of its standard deviations above its mean.
pub fn assert_agree(what: &str, estimates: &[(f64, f64, f64)]) {
    let z2 = estimates.iter().map(|(value, variance, truth)| (value - truth) * (value - truth) / variance);
    let (chi2, worst) = z2.fold((0.0, 0.0_f64), |(sum, worst), z2| (sum + z2, worst.max(z2.sqrt())));
    let n = estimates.len() as f64;
    println!("{what}: chi² {chi2:.1} of {n}, worst {worst:.2}");
    assert!(worst < 5.0, "{what}: worst {worst} standard errors");
    assert!(chi2 < n + 4.0 * (2.0 * n).sqrt(), "{what}: chi² {chi2} of {n}");
}

/// Pairs of independent traced pixels.
pub fn assert_same_images(what: &str, a: &TracedImage, b: &TracedImage) {
    let pixels = a.mean.data.iter().zip(&a.variance.data).zip(b.mean.data.iter().zip(&b.variance.data));
    let pairs: Vec<_> =
        pixels.map(|((a, va), (b, vb))| (f64::from(*a), f64::from(va + vb), f64::from(*b))).collect();
    assert_agree(what, &pairs);
}
