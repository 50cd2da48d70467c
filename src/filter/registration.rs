//! A first guess of the shift between a clear image and what is observed of it through a medium.
//!
//! The medium blurs, dims and veils, but its kernel is symmetric: it changes the size of the two images' cross-spectrum,
//! not its phase, which a shift d turns by exp(-i w·d). So the cross-correlation has its peak at d, however its frequencies
//! are weighted.
//!
//! First each ring of frequencies |w| is whitened as a whole, so that the waves that are in the image count more than
//! what leaks beside them (generalised cross-correlation; Knapp and Carter 1976). What the medium leaves of the fine
//! frequencies may lie below the noise, so several cut-offs are tried, and the one is taken whose peak stands out most
//! from what random phases give.
//!
//! Then windows of the two images are cut that show the same part of the scene: tapers that stand still pull towards no
//! shift. On them the least-squares fit of B = h(|w|) A exp(-i w·d) is solved by Gauss-Newton steps, each ring weighted
//! by h over the variance that its fit leaves. A texture that almost repeats itself has several peaks: the one whose fit
//! explains most is taken.

use super::fft2::{Fft2, fast_size};
use crate::image::{Image, View};
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// The middle of larger images is looked at, px.
const LARGEST: usize = 1024;
/// Share of a window's side over which each end is tapered.
const TAPER: f64 = 0.25;
/// Shifts at which the tapered windows overlap by less than this are not looked at.
const LEAST_OVERLAP: f64 = 0.4;
/// Waves per window side in a ring's width.
const RING: f64 = 2.0;
/// Cut-offs that are tried, rad/px; the first keeps all.
const CUT_OFFS: [f64; 4] = [5.0, 1.2, 0.5, 0.2];
/// Peaks of at least this share of the highest are its rivals, and how many are looked at.
const RIVAL: f64 = 0.6;
const MOST_RIVALS: usize = 8;
/// Steps before rivals are compared, and after.
const STEPS: [usize; 2] = [2, 3];
/// Longest step, px.
const LONGEST_STEP: f64 = 0.5;
/// Least share of its power that the noise of a ring is taken for.
const LEAST_NOISE: f64 = 1e-3;
/// Share of the mean that rounding of f32 may make of a constant image.
const ROUNDING: f64 = 1e-7;

/// Shift of `observed` against `object`, px, +x to the right and +y down: what the clear image `object` has at x is seen
/// in `observed` at x + shift. Both are of one size and show the same view; pixels of `observed` where `mask` is 0 are
/// left out.
///
/// Good to some tenths of a pixel up to a quarter of the image; no shift for images without detail. Of a texture that
/// repeats itself it may find the shift up to a period. Panics if the images differ in size.
pub fn coarse_shift(object: &Image, observed: &Image, mask: Option<&Image>) -> [f64; 2] {
    let size = (object.width, object.height);
    let same = |image: &Image| (image.width, image.height) == size;
    assert!(same(observed) && mask.is_none_or(same), "the images differ in size");
    let middle = View::centred(size, (size.0.min(LARGEST), size.1.min(LARGEST)));
    let pair = Pair {
        object: object.crop(middle),
        observed: observed.crop(middle),
        mask: mask.map(|mask| mask.crop(middle)),
    };
    let refined = |start: [f64; 2]| {
        let moved = (0..STEPS[0]).fold(start, |d, _| pair.fit(d).shift);
        (pair.fit(moved).explained, moved)
    };
    let rivals = pair.windows([0; 2]).peaks().into_iter().map(refined);
    let best = rivals.max_by(|a, b| a.0.total_cmp(&b.0)).map_or([0.0; 2], |(_, shift)| shift);
    (0..STEPS[1]).fold(best, |d, _| pair.fit(d).shift)
}

/// A clear image and what is observed of it, of one size.
pub(super) struct Pair {
    pub object: Image,
    pub observed: Image,
    pub mask: Option<Image>,
}

/// A step of a fit.
struct Fit {
    /// The shift after it.
    shift: [f64; 2],
    /// Mean of ln(power / power unexplained) over the observed waves, before it.
    explained: f64,
}

impl Pair {
    /// Windows that show the same part of the scene if the observation is shifted by `shift`.
    fn windows(&self, shift: [i64; 2]) -> Windows {
        let whole = [self.object.width, self.object.height];
        let moved = shift.map(|d| d.unsigned_abs() as usize);
        let [width, height] = [0, 1].map(|axis| whole[axis].saturating_sub(moved[axis]).max(1));
        let corner = |sign: i64| [0, 1].map(|axis| (sign * shift[axis]).max(0) as usize % whole[axis]);
        let view = |[x, y]: [usize; 2]| View { x, y, width, height };
        let (sent, seen) = (view(corner(-1)), view(corner(1)));
        let [across, down] = [width, height].map(|n| (0..n).map(|i| taper(i, n)).collect::<Vec<_>>());
        let mut weights: Vec<f64> = down.iter().flat_map(|y| across.iter().map(move |x| x * y)).collect();
        if let Some(mask) = &self.mask {
            let counts = mask.crop(seen).data.into_iter().map(|v| f64::from(u8::from(v != 0.0)));
            weights.iter_mut().zip(counts).for_each(|(weight, counts)| *weight *= counts);
        }
        Windows::new([&self.object.crop(sent), &self.observed.crop(seen)], weights)
    }

    /// How much of the observation is explained by the object moved to the highest peak of their correlation, after one step from there.
    pub(super) fn explained(&self) -> f64 {
        let peak = self.windows([0; 2]).peaks().first().copied().unwrap_or([0.0; 2]);
        self.fit(self.fit(peak).shift).explained
    }

    /// A step from `shift`.
    fn fit(&self, shift: [f64; 2]) -> Fit {
        let whole = shift.map(f64::round);
        let left = [0, 1].map(|axis| shift[axis] - whole[axis]);
        let (step, explained) = self.windows(whole.map(|d| d as i64)).step(left);
        Fit { shift: [0, 1].map(|axis| shift[axis] + step[axis]), explained }
    }
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
    /// Frequencies of the whole spectrum that it stands for.
    count: f64,
    /// Of the clear window and of the observed one.
    powers: [f64; 2],
    cross: Complex<f64>,
}

impl Windows {
    fn new(images: [&Image; 2], weights: Vec<f64>) -> Self {
        let size = [images[0].width, images[0].height];
        // Up to a shift of half a side nothing comes back on the other side.
        let [width, height] = size.map(|n| fast_size(n + n / 2));
        let fft = Fft2::<f64>::new(width, height);
        let spectrum = |values: Vec<f64>| {
            let mut plane = vec![0.0; width * height];
            let rows = plane.chunks_mut(width).zip(values.chunks(size[0]));
            rows.for_each(|(row, values)| row[..size[0]].copy_from_slice(values));
            fft.forward(plane)
        };
        let total: f64 = weights.iter().sum();
        let [clear, observed] = images.map(|image| {
            let weighted = || image.data.iter().zip(&weights).map(|(v, weight)| (f64::from(*v), weight));
            let mean = weighted().map(|(v, weight)| v * weight).sum::<f64>() * inverse(total);
            // A constant image is its mean but for rounding.
            let detail = |v: f64| if (v - mean).abs() > ROUNDING * mean.abs() { v - mean } else { 0.0 };
            spectrum(weighted().map(|(v, weight)| detail(v) * weight).collect())
        });
        let mut overlap = fft.inverse(spectrum(weights).iter().map(|v| v.norm_sqr().into()).collect());
        let whole = inverse(overlap[0]);
        overlap.iter_mut().for_each(|v| *v *= whole);

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
        let waves: Vec<Wave> = clear.iter().zip(&observed).enumerate().map(wave).collect();
        let rings = waves.iter().map(|wave| wave.ring).max().map_or(0, |last| last + 1);
        Self { fft, waves, rings, overlap }
    }

    /// The sum of a value over each ring.
    fn over_rings(&self, value: impl Fn(&Wave) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.rings];
        self.waves.iter().for_each(|wave| sums[wave.ring] += wave.count * value(wave));
        sums
    }

    /// The correlation's highest peak and its rivals, px, of the cut-off whose peak stands out most.
    fn peaks(&self) -> Vec<[f64; 2]> {
        let [clear, observed] = [0, 1].map(|which| self.over_rings(|wave| wave.powers[which]));
        let white: Vec<f64> = clear.iter().zip(&observed).map(|(a, b)| inverse((a * b).sqrt())).collect();
        let correlation = |cut_off: f64| {
            let weight =
                |wave: &Wave| if wave.w[0].hypot(wave.w[1]) < cut_off { white[wave.ring] } else { 0.0 };
            let power = |wave: &Wave| wave.count * (weight(wave) * wave.cross.norm()).powi(2);
            let random = inverse(self.waves.iter().map(power).sum::<f64>().sqrt());
            let spectrum = self.waves.iter().map(|wave| wave.cross * weight(wave)).collect();
            let values = self.fft.inverse(spectrum).into_iter().zip(&self.overlap);
            // Between the correlation itself, lower for large shifts, and that of what overlaps, noisier for them.
            let fair = |(v, overlap): (f64, &f64)| {
                if *overlap < LEAST_OVERLAP { 0.0 } else { v * random / overlap.sqrt() }
            };
            values.map(fair).collect::<Vec<f64>>()
        };
        let highest = |values: &Vec<f64>| values.iter().copied().fold(0.0, f64::max);
        let all = CUT_OFFS.map(correlation);
        let best = all.into_iter().max_by(|a, b| highest(a).total_cmp(&highest(b)));
        let values = best.expect("there are cut-offs");
        let least = RIVAL * highest(&values);
        let mut peaks: Vec<usize> = (0..values.len())
            .filter(|&i| values[i] > 0.0 && values[i] >= least && self.is_peak(&values, i))
            .collect();
        peaks.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        peaks.into_iter().take(MOST_RIVALS).map(|i| self.shift_at(i)).collect()
    }

    /// Whether no neighbour is higher.
    fn is_peak(&self, values: &[f64], i: usize) -> bool {
        let [width, height] = [self.fft.width, self.fft.height];
        let (x, y) = (i % width, i / width);
        let rows = [y + height - 1, y, y + 1].map(|y| y % height * width);
        let columns = [x + width - 1, x, x + 1].map(|x| x % width);
        rows.iter().all(|row| columns.iter().all(|column| values[row + column] <= values[i]))
    }

    /// The shift that pixel `i` of the correlation stands for.
    fn shift_at(&self, i: usize) -> [f64; 2] {
        let signed = |i: usize, n: usize| if 2 * i > n { i as f64 - n as f64 } else { i as f64 };
        [signed(i % self.fft.width, self.fft.width), signed(i / self.fft.width, self.fft.height)]
    }

    /// The Gauss-Newton step from windows that are `left` apart, and what the fit explains there.
    fn step(&self, left: [f64; 2]) -> ([f64; 2], f64) {
        let turned = |wave: &Wave| wave.cross * Complex::cis(wave.w[0] * left[0] + wave.w[1] * left[1]);
        let [clear, observed] = [0, 1].map(|which| self.over_rings(|wave| wave.powers[which]));
        let aligned = self.over_rings(|wave| turned(wave).re);
        let counts = self.over_rings(|_| 1.0);
        let (mut weights, mut explained) = (vec![0.0; self.rings], 0.0);
        for ring in (0..self.rings).filter(|&ring| observed[ring] > 0.0) {
            let share = aligned[ring].max(0.0) * inverse(clear[ring]);
            let noise = (observed[ring] - share * aligned[ring]).max(LEAST_NOISE * observed[ring]);
            weights[ring] = share * counts[ring] / noise;
            explained += counts[ring] * (observed[ring] / noise).ln();
        }
        let (mut slope, mut matrix) = ([0.0; 2], [0.0; 3]);
        for wave in &self.waves {
            let (weight, [x, y], cross) = (wave.count * weights[wave.ring], wave.w, turned(wave));
            let stiffness = weight * cross.re.max(0.0);
            [x, y].iter().zip(&mut slope).for_each(|(w, s)| *s -= weight * w * cross.im);
            [x * x, x * y, y * y].iter().zip(&mut matrix).for_each(|(w, m)| *m += stiffness * w);
        }
        // An image without detail along an axis does not move along it.
        let least = 1e-9 * (matrix[0] + matrix[2]);
        let [xx, xy, yy] = [matrix[0] + least, matrix[1], matrix[2] + least];
        let solved = inverse(xx * yy - xy * xy);
        let step = [solved * (yy * slope[0] - xy * slope[1]), solved * (xx * slope[1] - xy * slope[0])];
        let shorter = (LONGEST_STEP * inverse(step[0].hypot(step[1]))).min(1.0);
        (step.map(|d| shorter * d), explained / counts.iter().sum::<f64>())
    }
}

/// Cosine taper at pixel `i` of `n`.
fn taper(i: usize, n: usize) -> f64 {
    let from_end = (i.min(n - 1 - i) as f64 + 0.5) / (TAPER * n as f64);
    if from_end < 1.0 { 0.5 - 0.5 * (PI * from_end).cos() } else { 1.0 }
}

/// 1/x, 0 for what is not positive.
fn inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}
