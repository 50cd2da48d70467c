//! An image blurred by one Gaussian, in real space.
//!
//! A Gaussian is separable, so its blur is E = Y L Xᵀ with a band matrix an axis, which holds the pixel convention and
//! the border rule exactly. An element of the matrix is the Gaussian averaged over both pixels: the second difference of
//! its second antiderivative, all aliases included.
//!
//! A wide blur goes by way of a coarse grid, as two of half the variance each: L -> C = Y₁ L X₁ᵀ on a grid of step d, and
//! E = Y₂ C X₂ᵀ. Sampling leaves exp(-(2 pi/d)² sigma²/8) of it, d being chosen so that this is 3e-7.

use super::Target;
use super::canvas::Canvas;
use crate::image::{Border, View};
use libm::erfc;
use std::borrow::Cow;
use std::f64::consts::{FRAC_1_SQRT_2, PI};
use std::ops::Range;

/// Widths above this, px, go by way of a coarse grid.
const FINE: f64 = 2.0;
/// Step of the coarse grid in units of sigma.
const STEP: f64 = 1.0 / 1.75;
/// Standard deviations beyond which a Gaussian ends: 6e-7 of its light.
const REACH: f64 = 5.0;

/// Padding for band-limited Gaussians up to that width, whose rings fall like 1/u².
const FINE_REACH: f64 = 32.0;

/// Rows of the view that are computed together.
pub const STRIP: usize = 16;

/// One column of a strip.
pub type Lane = [f32; STRIP];

/// A band matrix.
struct Band {
    /// Where each row begins, and its elements.
    rows: Vec<(usize, Vec<f32>)>,
}

impl Band {
    /// The matrix whose row at the position x has the weights `taps(u, n)` of the inputs at x + u, x + u + 1, …, up to
    /// `reach` away; what lies beyond the `inputs` is as `border` says.
    fn new(
        positions: impl Iterator<Item = f64>,
        (inputs, border): (usize, Border),
        reach: f64,
        taps: impl Fn(f64, usize) -> Vec<f64>,
    ) -> Self {
        let (nearest, farthest) = match border {
            Border::Zero => (0, inputs as i64 - 1),
            Border::Clamp | Border::Mirror | Border::Unknown => (i64::MIN, i64::MAX),
        };
        let mut dense = vec![0.0; inputs];
        let row = |x: f64| {
            let start = ((x - reach).ceil() as i64).max(nearest);
            let end = ((x + reach).floor() as i64).min(farthest);
            let count = (end - start + 1).max(0) as usize;
            let (mut first, mut last) = (inputs, 0);
            for (place, tap) in (start..).zip(taps(start as f64 - x, count)) {
                if let Some(i) = border.index(place, inputs) {
                    dense[i] += tap;
                    (first, last) = (first.min(i), last.max(i + 1));
                }
            }
            let first = first.min(last);
            let elements = dense[first..last].iter().map(|&v| v as f32).collect();
            dense[first..last].fill(0.0);
            (first, elements)
        };
        Self { rows: positions.map(row).collect() }
    }

    /// `rows` of the product with a matrix whose rows have `width` elements.
    fn times(&self, rows: Range<usize>, matrix: &[f32], width: usize) -> Vec<f32> {
        let mut product = vec![0.0; rows.len() * width];
        for ((first, elements), out) in self.rows[rows].iter().zip(product.chunks_mut(width)) {
            for (element, row) in elements.iter().zip(matrix[first * width..].chunks(width)) {
                out.iter_mut().zip(row).for_each(|(sum, v)| *sum += element * v);
            }
        }
        product
    }
}

/// The sum of products.
pub fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut lanes = [0.0_f32; 8];
    let (a, rest_a) = a.as_chunks::<8>();
    let (b, rest_b) = b.as_chunks::<8>();
    for (a, b) in a.iter().zip(b) {
        for (sum, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    let rest: f32 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    lanes.iter().sum::<f32>() + rest
}

/// An image blurred by one Gaussian, ready to be computed strip by strip over a view.
pub struct Blur<'a> {
    /// The image itself, or the one blurred on the coarse grid.
    inner: Cow<'a, [f32]>,
    inner_width: usize,
    across: Band,
    down: Band,
}

impl<'a> Blur<'a> {
    /// The blur of `image`, `size` [width, height] large, by a Gaussian of `width` px, to be seen over `view`.
    pub fn new(image: &'a [f32], size: [usize; 2], border: Border, view: View, width: f64) -> Self {
        let pixels = if width <= FINE { width } else { width * FRAC_1_SQRT_2 };
        Self::by(image, size, (border, view), width, |u, n| between_pixels(pixels, u, n))
    }

    /// The same of an `image` the size of the object of `target` that is band-limited, as it is when blurred: nothing is
    /// averaged over pixels.
    pub(super) fn bandlimited(image: &'a [f32], target: &Target, width: f64) -> Self {
        let size = [target.radiance.width, target.radiance.height];
        if width > FINE {
            // Sampled once a pixel, the half of such a Gaussian has 5e-5 of its height where its aliases begin.
            let half = width * FRAC_1_SQRT_2;
            let taps = |u: f64, n: usize| (0..n).map(|i| gaussian(half, u + i as f64)).collect();
            return Self::by(image, size, (target.border, target.view), width, taps);
        }
        let canvas = Canvas::new(target, FINE_REACH);
        let mut padded = vec![0.0; canvas.pixels()];
        for (j, row) in padded.chunks_mut(canvas.fft.width).enumerate() {
            canvas.row(j).for_each(|place| row[place.x] = image[place.of]);
        }
        let mut spectrum = canvas.fft.forward(padded);
        let [across, down] = &canvas.axes;
        for (column, wx) in spectrum.chunks_mut(canvas.fft.height).zip(&across.w) {
            let n = column.len();
            for (ky, value) in column.iter_mut().enumerate() {
                let wy = down.w[ky.min(n - ky)];
                *value *= (-0.5 * width * width * (wx * wx + wy * wy)).exp() as f32;
            }
        }
        let seen = canvas.crop(&canvas.fft.inverse(spectrum), target.view);
        let same = |n: usize| Band { rows: (0..n).map(|i| (i, vec![1.0])).collect() };
        let View { width, height, .. } = target.view;
        Self { inner: Cow::Owned(seen.data), inner_width: width, across: same(width), down: same(height) }
    }

    /// The blur of `image` by a Gaussian of `width` px, of which `taps(u, n)` are the weights of the pixels at u, u + 1, …; of
    /// half its variance, if it goes by way of the coarse grid.
    fn by(
        image: &'a [f32],
        size: [usize; 2],
        (border, view): (Border, View),
        width: f64,
        taps: impl Fn(f64, usize) -> Vec<f64> + Sync,
    ) -> Self {
        let seen = [(view.x, view.width), (view.y, view.height)];
        if width <= FINE {
            let band = |axis: usize| {
                let (start, length) = seen[axis];
                let positions = (start..start + length).map(|i| i as f64);
                Band::new(positions, (size[axis], border), REACH * width + 1.0, &taps)
            };
            let (across, down) = (band(0), band(1));
            return Self { inner: Cow::Borrowed(image), inner_width: size[0], across, down };
        }
        let (half, step) = (width * FRAC_1_SQRT_2, width * STEP);
        let reach = REACH * half;
        let bands = |axis: usize| {
            let (start, length) = seen[axis];
            let origin = start as f64 - reach;
            let count = ((length as f64 + 2.0 * reach) / step).ceil() as usize + 1;
            let grid = (0..count).map(|i| origin + i as f64 * step);
            let inward = Band::new(grid, (size[axis], border), reach + 1.0, &taps);
            let places = (start..start + length).map(|i| (i as f64 - origin) / step);
            let outward =
                |u: f64, n: usize| (0..n).map(|i| step * gaussian(half, step * (u + i as f64))).collect();
            (inward, Band::new(places, (count, Border::Zero), reach / step, outward))
        };
        let ((inward_x, across), (inward_y, down)) = rayon::join(|| bands(0), || bands(1));
        let (columns, rows) = (inward_x.rows.len(), inward_y.rows.len());
        let blurred = inward_y.times(0..rows, image, size[0]);
        let element = |row: &[f32], (first, elements): &(usize, Vec<f32>)| {
            dot(elements, &row[*first..][..elements.len()])
        };
        let inner = blurred
            .chunks(size[0])
            .flat_map(|row| inward_x.rows.iter().map(move |column| element(row, column)))
            .collect();
        Self { inner: Cow::Owned(inner), inner_width: columns, across, down }
    }

    /// What [`columns`](Self::columns) needs of the rows `strip` of the view, transposed; rows beyond a short strip's
    /// end are 0.
    pub fn rows(&self, strip: Range<usize>) -> Vec<Lane> {
        let rows = self.down.times(strip, &self.inner, self.inner_width);
        let mut transposed = vec![[0.0; STRIP]; self.inner_width];
        for (y, row) in rows.chunks(self.inner_width).enumerate() {
            transposed.iter_mut().zip(row).for_each(|(lane, v)| lane[y] = *v);
        }
        transposed
    }

    /// `columns` of the view's strip that `rows` are of.
    pub fn columns<'s>(&'s self, rows: &'s [Lane], columns: Range<usize>) -> impl Iterator<Item = Lane> + 's {
        self.across.rows[columns].iter().map(|(first, elements)| {
            let mut sum = [0.0; STRIP];
            for (element, lane) in elements.iter().zip(&rows[*first..]) {
                sum.iter_mut().zip(lane).for_each(|(sum, v)| *sum += element * v);
            }
            sum
        })
    }
}

/// Density of the normal distribution of standard deviation `width` at `u`.
fn gaussian(width: f64, u: f64) -> f64 {
    (-0.5 * (u / width).powi(2)).exp() / (width * (2.0 * PI).sqrt())
}

/// That density averaged over two pixels whose centres are `u`, `u` + 1, … apart, `count` numbers.
fn between_pixels(width: f64, u: f64, count: usize) -> Vec<f64> {
    let integrals: Vec<f64> = (0..count + 2).map(|i| twice_integrated(width, u + i as f64 - 1.0)).collect();
    integrals.windows(3).map(|g| g[0] - 2.0 * g[1] + g[2]).collect()
}

/// Its second antiderivative, max(u, 0) + ∫ from |u| of (v - |u|) times the density; max(u, 0) for no width.
fn twice_integrated(width: f64, u: f64) -> f64 {
    if width == 0.0 {
        return u.max(0.0);
    }
    let t = u.abs() / width;
    let tail = (-0.5 * t * t).exp() / (2.0 * PI).sqrt() - 0.5 * t * erfc(t * FRAC_1_SQRT_2);
    u.max(0.0) + width * tail
}
