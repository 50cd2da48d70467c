//! Images between their pixels, and images blurred as a whole.
//!
//! Beyond its edges an image goes on as its own mirror image. Between pixels it is the quintic B-spline through all of them
//! (Unser, Aldroubi and Eden 1993): smooth, and closer to the band-limited image than shorter kernels. The coefficients follow
//! from the transform, where a Gaussian blur is one more factor.

use super::fft2::Fft2;
use super::moved::mirrored;
use crate::image::{Border, Image};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Coefficients that a place depends on, along each axis.
const TAPS: usize = 6;

/// The waves of an image and of its mirror images.
pub struct Waves {
    fft: Fft2<f32>,
    spectrum: Vec<Complex<f32>>,
    width: usize,
    height: usize,
}

impl Waves {
    /// Those of `image`.
    pub fn of(image: &Image) -> Self {
        let (fft, data) = mirrored(image);
        let spectrum = fft.forward(data);
        Self { fft, spectrum, width: image.width, height: image.height }
    }

    /// The image with each wave times `factor` of its frequencies along x and y, rad/px.
    pub fn filtered(&self, factor: impl Fn([f64; 2]) -> f64 + Sync) -> Image {
        let (width, height) = (self.fft.width, self.fft.height);
        let frequency = |k: usize, n: usize| {
            let k = k as f64;
            2.0 * PI * (if 2.0 * k <= n as f64 { k } else { k - n as f64 }) / n as f64
        };
        let mut spectrum = self.spectrum.clone();
        spectrum.par_chunks_mut(height).enumerate().for_each(|(kx, column)| {
            let wx = frequency(kx, width);
            for (ky, value) in column.iter_mut().enumerate() {
                *value *= factor([wx, frequency(ky, height)]) as f32;
            }
        });
        let data = self.fft.inverse(spectrum);
        let whole = Image { width, height, data };
        Image::from_fn(self.width, self.height, |x, y| whole.at(x, y))
    }

    /// The image blurred by a Gaussian of the variance `px2`, px².
    pub fn blurred(&self, px2: f64) -> Image {
        self.filtered(|w| gaussian(w, px2))
    }

    /// The derivative of that in the variance, 1/px².
    pub fn blur_slope(&self, px2: f64) -> Image {
        self.filtered(|[x, y]| -0.5 * (x * x + y * y) * gaussian([x, y], px2))
    }

    /// The spline through the image blurred so.
    pub fn spline(&self, px2: f64) -> Spline {
        Spline(self.filtered(|w| gaussian(w, px2) / (sampled_basis(w[0]) * sampled_basis(w[1]))))
    }
}

fn gaussian([x, y]: [f64; 2], variance: f64) -> f64 {
    (-0.5 * variance * (x * x + y * y)).exp()
}

/// Transform of the basis spline at the pixels, 66/120, 26/120 and 1/120 in the middle and on both sides.
fn sampled_basis(w: f64) -> f64 {
    (66.0 + 52.0 * w.cos() + 2.0 * (2.0 * w).cos()) / 120.0
}

/// An image at any place, by its coefficients.
pub struct Spline(Image);

/// The weights of the coefficients about a place along one axis, and their derivatives.
struct Taps {
    indices: [usize; TAPS],
    weights: [f64; TAPS],
    slopes: [f64; TAPS],
}

impl Taps {
    /// At `place`, px, of a row of `n`.
    fn new(place: f64, n: usize) -> Self {
        let first = place.floor() as i64 - 2;
        let t = place - place.floor();
        // Cox's and de Boor's recursion on even knots.
        let mut weights = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let mut before = weights;
        for degree in 1..TAPS {
            before = weights;
            let mut saved = 0.0;
            for (r, weight) in weights.iter_mut().enumerate().take(degree) {
                let part = *weight / degree as f64;
                *weight = saved + (r as f64 + 1.0 - t) * part;
                saved = (t + (degree - r) as f64 - 1.0) * part;
            }
            weights[degree] = saved;
        }
        let slope =
            |k: usize| if k == 0 { 0.0 } else { before[k - 1] } - if k + 1 == TAPS { 0.0 } else { before[k] };
        Self {
            indices: std::array::from_fn(|k| Border::Mirror.index(first + k as i64, n).unwrap_or(0)),
            weights,
            slopes: std::array::from_fn(slope),
        }
    }
}

/// An image at new places, and how it changes there to the right and downwards, 1/px.
pub struct Sampled {
    /// Its values.
    pub image: Image,
    /// Their slopes.
    pub slopes: [Image; 2],
}

/// Each of `splines`, all of one size, where `from` says for each pixel of a new image of `width` columns and `height` rows: in
/// px, (0, 0) being the first pixel's middle.
pub fn sampled(
    splines: &[Spline],
    (width, height): (usize, usize),
    from: impl Fn(usize) -> [f64; 2] + Sync,
) -> Vec<Sampled> {
    let parts = 3 * splines.len();
    let row = |y: usize| {
        let mut values = Vec::with_capacity(width * parts);
        for x in 0..width {
            let [u, v] = from(y * width + x);
            for spline in splines {
                let (across, down) = (Taps::new(u, spline.0.width), Taps::new(v, spline.0.height));
                values.extend(spline.at(&across, &down).map(|v| v as f32));
            }
        }
        values
    };
    let rows: Vec<Vec<f32>> = (0..height).into_par_iter().map(row).collect();
    let image = |part: usize| Image {
        width,
        height,
        data: rows.iter().flat_map(|row| row.iter().skip(part).step_by(parts).copied()).collect(),
    };
    let one = |s: usize| Sampled { image: image(3 * s), slopes: [image(3 * s + 1), image(3 * s + 2)] };
    (0..splines.len()).map(one).collect()
}

impl Spline {
    /// Value and slopes.
    fn at(&self, across: &Taps, down: &Taps) -> [f64; 3] {
        let mut all = [0.0; 3];
        for j in 0..TAPS {
            let row = &self.0.data[down.indices[j] * self.0.width..];
            let (mut value, mut slope) = (0.0, 0.0);
            for i in 0..TAPS {
                let coefficient = f64::from(row[across.indices[i]]);
                value += across.weights[i] * coefficient;
                slope += across.slopes[i] * coefficient;
            }
            all[0] += down.weights[j] * value;
            all[1] += down.weights[j] * slope;
            all[2] += down.slopes[j] * value;
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(x: f64, y: f64) -> f64 {
        0.5 + 0.3 * (0.7 * x).sin() * (0.5 * y).cos()
    }

    fn image() -> Image {
        Image::from_fn(60, 48, |x, y| wave(x as f64, y as f64) as f32)
    }

    #[test]
    fn a_smooth_image_and_its_slopes_are_met_between_pixels() {
        let splines = [Waves::of(&image()).spline(0.0)];
        let place = |i: usize| [20.0 + 0.37 * (i % 8) as f64, 18.0 + 0.41 * (i / 8) as f64];
        let found = &sampled(&splines, (8, 8), place)[0];
        for i in 0..64 {
            let [x, y] = place(i);
            let off = f64::from(found.image.data[i]) - wave(x, y);
            assert!(off.abs() < 1e-4, "{off}");
            let slope = 0.3 * 0.7 * (0.7 * x).cos() * (0.5 * y).cos();
            let off = f64::from(found.slopes[0].data[i]) - slope;
            assert!(off.abs() < 5e-4, "{off}");
        }
        let nearest = |i: usize| place(i).map(f64::round);
        let rounded = &sampled(&splines, (8, 8), nearest)[0];
        assert!((rounded.image.data[9] - found.image.data[9]).abs() > 1e-2, "it does not move");
    }

    #[test]
    fn pixels_are_met_exactly() {
        let rough = Image::from_fn(30, 20, |x, y| ((7 * x + 13 * y + x * y) % 31) as f32 / 31.0);
        let splines = [Waves::of(&rough).spline(0.0)];
        let all = &sampled(&splines, (30, 20), |i| [(i % 30) as f64, (i / 30) as f64])[0];
        assert!(all.image.data.iter().zip(&rough.data).all(|(a, b)| (a - b).abs() < 1e-5));
    }

    #[test]
    fn a_blur_has_its_variance_and_its_derivative() {
        let mut point = Image::filled(41, 41, 0.0);
        point.data[20 * 41 + 20] = 1.0;
        let waves = Waves::of(&point);
        let (px2, step) = (1.7, 1e-2);
        let blurred = waves.blurred(px2);
        let variance: f64 = blurred
            .data
            .iter()
            .enumerate()
            .map(|(i, v)| f64::from(*v) * ((i % 41) as f64 - 20.0).powi(2))
            .sum();
        assert!((variance - px2).abs() < 1e-3, "{variance}");
        let (more, less) = (waves.blurred(px2 + step), waves.blurred(px2 - step));
        let slope = waves.blur_slope(px2);
        for i in [20 * 41 + 20, 20 * 41 + 22, 23 * 41 + 20] {
            let expected = f64::from(more.data[i] - less.data[i]) / (2.0 * step);
            assert!((f64::from(slope.data[i]) - expected).abs() < 1e-4);
        }
    }
}
