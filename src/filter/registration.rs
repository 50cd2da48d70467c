//! A first guess of the shift between a clear image and what is observed of it through a medium.
//!
//! The medium blurs, dims and veils, but its kernel is symmetric: it changes the size of the cross-spectrum of the two images,
//! not its phase, which a shift d turns by exp(-i w·d). So the cross-correlation, however its frequencies are weighted, has its
//! peak at d.
//!
//! First the frequencies are whitened: those of one ring of |w| together, so that strong waves of a ring count more than what has
//! leaked beside them (generalised cross-correlation; Knapp and Carter 1976). Blur leaves the fine frequencies to the noise, so several
//! cut-offs are tried, and the peak that stands out most from what random phases would give is taken. Then windows of the two images are
//! cut that show the same part of the scene, since tapers that stand still pull towards no shift, and each ring is weighted with
//! what a least-squares fit of B = h(|w|) A exp(-i w·d) to it asks for, h over the variance that is left.

use super::fft2::{Fft2, fast_size};
use crate::image::Image;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Share of a window's side over which each end is tapered.
const TAPER: f64 = 0.25;
/// Shifts at which less than this of the tapered windows overlaps are not looked at.
const LEAST_OVERLAP: f64 = 0.3;
/// Waves per window side in a ring's width.
const RING: f64 = 2.0;
/// Cut-offs that are tried, rad/px; the first keeps all.
const CUT_OFFS: [f64; 4] = [5.0, 1.2, 0.5, 0.2];
/// Windows cut anew after the first guess.
const REFINEMENTS: usize = 3;
/// Least share of its power that a ring's noise is taken for.
const LEAST_NOISE: f64 = 1e-3;

/// Shift of `observed` against `object`, px, +x to the right and +y down: what the clear image `object` has at x is seen in
/// `observed` at x + shift. Both are of one size and show the same view; pixels where `mask` is 0 are left out of `observed`.
///
/// Good to some tenths of a pixel up to a third of the image; images without detail give no shift. Panics if the images differ
/// in size.
pub fn coarse_shift(object: &Image, observed: &Image, mask: Option<&Image>) -> [f64; 2] {
    let sizes = [Some(object), Some(observed), mask].into_iter().flatten().map(|i| (i.width, i.height));
    assert!(sizes.clone().all(|size| Some(size) == sizes.clone().next()), "images of one size");
    let mut shift = Windows::cut([object, observed], mask, [0; 2]).whitened_peak();
    for _ in 0..REFINEMENTS {
        let whole = shift.map(|d| d.round() as i64);
        let left = [0, 1].map(|axis| shift[axis] - whole[axis] as f64);
        let found = Windows::cut([object, observed], mask, whole).matched_peak(left);
        shift = [0, 1].map(|axis| whole[axis] as f64 + found[axis]);
    }
    shift
}

/// Two tapered windows in terms of their waves.
struct Windows {
    fft: Fft2<f64>,
    waves: Vec<Wave>,
    /// Number of rings.
    rings: usize,
    /// How much of the two tapers overlaps at each shift, 1 at most.
    overlap: Vec<f64>,
}

/// A frequency of the half spectrum.
struct Wave {
    /// rad/px.
    w: [f64; 2],
    ring: usize,
    /// How often it stands for in the whole spectrum: 1 or 2.
    count: f64,
    /// Of the clear window, of the observed one.
    powers: [f64; 2],
    cross: Complex<f64>,
}

impl Windows {
    /// Windows of the two `images` that show the same part of the scene if the second is shifted by `shift`.
    fn cut([object, observed]: [&Image; 2], mask: Option<&Image>, shift: [i64; 2]) -> Self {
        let whole = [object.width, object.height];
        let size = [0, 1].map(|axis| whole[axis].saturating_sub(shift[axis].unsigned_abs() as usize).max(1));
        // Neither window comes back on the other side of the other before half a side.
        let [width, height] = size.map(|n| fast_size(n + n / 2));
        let fft = Fft2::<f64>::new(width, height);
        let seen = |axis: usize, i: usize| (i + shift[axis].max(0) as usize).min(whole[axis] - 1);
        let sent = |axis: usize, i: usize| (i + (-shift[axis]).max(0) as usize).min(whole[axis] - 1);
        let places = || (0..size[0] * size[1]).map(|i| (i % size[0], i / size[0]));
        let tapers = size.map(|n| (0..n).map(|i| taper(i, n)).collect::<Vec<_>>());
        let counts = |x: usize, y: usize| mask.is_none_or(|m| m.at(seen(0, x), seen(1, y)) != 0.0);
        let weight = |(x, y): (usize, usize)| f64::from(u8::from(counts(x, y))) * tapers[0][x] * tapers[1][y];
        let weights: Vec<f64> = places().map(weight).collect();
        let padded = |values: Vec<f64>| {
            let mut plane = vec![0.0; width * height];
            plane
                .chunks_mut(width)
                .zip(values.chunks(size[0]))
                .for_each(|(row, v)| row[..size[0]].copy_from_slice(v));
            plane
        };
        let spectrum = |value: &dyn Fn(usize, usize) -> f32| {
            let values: Vec<f64> = places().map(|(x, y)| f64::from(value(x, y))).collect();
            let sum: f64 = values.iter().zip(&weights).map(|(v, weight)| v * weight).sum();
            let mean = sum / weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            fft.forward(padded(values.iter().zip(&weights).map(|(v, weight)| (v - mean) * weight).collect()))
        };
        let clear = spectrum(&|x, y| object.at(sent(0, x), sent(1, y)));
        let blurred = spectrum(&|x, y| observed.at(seen(0, x), seen(1, y)));
        let windows = fft.forward(padded(weights));
        let mut overlap = fft.inverse(windows.iter().map(|v| v.norm_sqr().into()).collect());
        let most = overlap[0].max(f64::MIN_POSITIVE);
        overlap.iter_mut().for_each(|v| *v /= most);

        let ring = RING * 2.0 * PI / width.min(height) as f64;
        let wave = |(i, (a, b)): (usize, (&Complex<f64>, &Complex<f64>))| {
            let (kx, ky) = (i / height, i % height);
            let down = if 2 * ky > height { ky as f64 - height as f64 } else { ky as f64 };
            let w = [2.0 * PI * kx as f64 / width as f64, 2.0 * PI * down / height as f64];
            Wave {
                w,
                ring: (w[0].hypot(w[1]) / ring) as usize,
                count: if kx == 0 || 2 * kx == width { 1.0 } else { 2.0 },
                powers: [a.norm_sqr(), b.norm_sqr()],
                cross: a.conj() * b,
            }
        };
        let waves: Vec<Wave> = clear.iter().zip(&blurred).enumerate().map(wave).collect();
        let rings = waves.iter().map(|wave| wave.ring).max().map_or(0, |last| last + 1);
        Self { fft, waves, rings, overlap }
    }

    /// The sum of a value over each ring.
    fn over_rings(&self, value: impl Fn(&Wave) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.rings];
        self.waves.iter().for_each(|wave| sums[wave.ring] += wave.count * value(wave));
        sums
    }

    /// The shift of the peak that stands out most, the rings being whitened up to one of the cut-offs.
    fn whitened_peak(&self) -> [f64; 2] {
        let [clear, blurred] = [0, 1].map(|which| self.over_rings(|wave| wave.powers[which]));
        let whole: Vec<f64> = clear.iter().zip(&blurred).map(|(a, b)| inverse((a * b).sqrt())).collect();
        let peak = |cut_off: f64| {
            let weight =
                |wave: &Wave| if wave.w[0].hypot(wave.w[1]) < cut_off { whole[wave.ring] } else { 0.0 };
            let power = |wave: &Wave| wave.count * (weight(wave) * wave.cross.norm()).powi(2);
            let random = self.waves.iter().map(power).sum::<f64>().sqrt();
            let (shift, height) = self.peak(weight);
            (shift, height * inverse(random))
        };
        let peaks = CUT_OFFS.map(peak);
        peaks.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("there are cut-offs").0
    }

    /// The shift of the peak, each ring being weighted as the noise in it asks for if the windows are `left` apart.
    fn matched_peak(&self, left: [f64; 2]) -> [f64; 2] {
        let [clear, blurred] = [0, 1].map(|which| self.over_rings(|wave| wave.powers[which]));
        let aligned = self.over_rings(|wave| {
            let turn = wave.w[0] * left[0] + wave.w[1] * left[1];
            (wave.cross * Complex::cis(turn)).re
        });
        let counts = self.over_rings(|_| 1.0);
        let weight = |ring: usize| {
            let share = aligned[ring].max(0.0) * inverse(clear[ring]);
            let noise = (blurred[ring] - share * aligned[ring]).max(LEAST_NOISE * blurred[ring]);
            share * counts[ring] * inverse(noise)
        };
        let weights: Vec<f64> = (0..self.rings).map(weight).collect();
        self.peak(|wave| weights[wave.ring]).0
    }

    /// Place of the highest value of the weighted correlation, and that value, as if the windows overlapped wholly.
    fn peak(&self, weight: impl Fn(&Wave) -> f64) -> ([f64; 2], f64) {
        let [width, height] = [self.fft.width, self.fft.height];
        let correlation = self.fft.inverse(self.waves.iter().map(|wave| wave.cross * weight(wave)).collect());
        let at = |x: usize, y: usize| {
            let place = y % height * width + x % width;
            if self.overlap[place] < LEAST_OVERLAP { 0.0 } else { correlation[place] / self.overlap[place] }
        };
        let places = (0..width * height).map(|i| (i % width, i / width));
        let (x, y) = places.max_by(|a, b| at(a.0, a.1).total_cmp(&at(b.0, b.1))).expect("there are pixels");
        let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
        let along_x = vertex([at(x + width - 1, y), at(x, y), at(x + 1, y)]);
        let along_y = vertex([at(x, y + height - 1), at(x, y), at(x, y + 1)]);
        ([signed(x, width) + along_x, signed(y, height) + along_y], at(x, y) * (width * height) as f64)
    }
}

/// Cosine taper at pixel `i` of `n`.
fn taper(i: usize, n: usize) -> f64 {
    let from_end = (i.min(n - 1 - i) as f64 + 0.5) / (TAPER * n as f64);
    if from_end < 1.0 { 0.5 - 0.5 * (PI * from_end).cos() } else { 1.0 }
}

/// Where the parabola through three values one step apart is highest, in steps from the middle one, which is the largest.
fn vertex([before, middle, after]: [f64; 3]) -> f64 {
    0.5 * (after - before) * inverse(2.0 * middle - before - after)
}

/// 1/x, 0 for what is not positive.
fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}
