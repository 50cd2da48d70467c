//! Renders against one observed scene: gain and veil solved for, residuals, noise.
//!
//! The model of a pixel is gain · I + veil. Both enter linearly, so where they are free they take the values that fit
//! a render best.

use super::datum::{Datum, VeilTerm};
use super::equations::{CHUNK, Linear, NormalEquations, Sums};
use crate::error::{Error, Result};
use crate::filter::cpu::Rendering;
use crate::image::Image;
use crate::scene::Gain;
use nalgebra::{Matrix2, Vector2, Vector3};
use rayon::prelude::*;

/// Relative error of a render: an observation without noise cannot be known better than that.
const RENDER_ERROR: f64 = 1e-5;
/// Variance of an image, relative to its mean square, below which it is flat to rounding.
const FLAT: f64 = 1e-10;
/// Share of the pixels by which what hidden light leaves out may still change.
const HIDDEN_SETTLED: f64 = 0.002;
/// With fewer pixels whose neighbours all count, the noise is taken from the residuals themselves.
const FEWEST_LAPLACIANS: i32 = 100;

/// A datum with its pixels gathered: values of those that count, known veil taken off.
pub(super) struct Observed<'a> {
    pub datum: Datum<'a>,
    /// Whether each pixel of the view counts.
    counts: Vec<bool>,
    /// Index in the view and value of those that do.
    pixels: Vec<(u32, f32)>,
    /// Pixels that do not because of hidden light.
    pub hidden: usize,
    pub noise: f64,
}

impl<'a> Observed<'a> {
    pub(super) fn new(datum: &Datum<'a>) -> Result<Self> {
        let mut observed = Self {
            datum: *datum,
            counts: Vec::new(),
            pixels: Vec::new(),
            hidden: 0,
            noise: datum.noise.unwrap_or(1.0),
        };
        observed.gather(|_| true);
        if observed.pixels.is_empty() {
            return Err(Error::NothingToFit("the mask leaves no pixel".into()));
        }
        Ok(observed)
    }

    /// Gathers the pixels that the mask lets count, if they are `shown`.
    fn gather(&mut self, shown: impl Fn(usize) -> bool) {
        let datum = self.datum;
        let masked = |i: usize| datum.mask.is_none_or(|m| m.data[i] > 0.0);
        let veil = |i: usize| match datum.veil {
            VeilTerm::Fixed(v) => v as f32,
            VeilTerm::Image(image) => image.data[i],
            VeilTerm::Free => 0.0,
        };
        let all = &datum.observed.data;
        self.counts = (0..all.len()).map(|i| masked(i) && shown(i)).collect();
        self.hidden = (0..all.len()).filter(|&i| masked(i) && !shown(i)).count();
        self.pixels =
            (0..all.len()).filter(|&i| self.counts[i]).map(|i| (i as u32, all[i] - veil(i))).collect();
    }

    /// Leaves out the pixels of which more than the datum's share of light may be hidden; returns whether that
    /// differs from what was left out before by enough to matter.
    ///
    /// # Errors
    /// [`Error::NothingToFit`] if no pixel is left.
    pub(super) fn leave_out_hidden(&mut self, share: &Image) -> Result<bool> {
        let most = self.datum.hidden_share_max;
        let shown = |i: usize| f64::from(share.data[i]) <= most;
        let changed = (0..share.data.len())
            .filter(|&i| self.datum.mask.is_none_or(|m| m.data[i] > 0.0) && shown(i) != self.counts[i])
            .count();
        if changed as f64 <= HIDDEN_SETTLED * self.pixels.len() as f64 {
            return Ok(false);
        }
        self.gather(shown);
        if self.pixels.is_empty() {
            return Err(Error::NothingToFit(format!(
                "more than {most} of the light of every pixel may be hidden behind near surfaces; give what lies \
                 there as [[object.layer]], or raise [observation] hidden_share_max"
            )));
        }
        Ok(true)
    }

    pub(super) fn pixels(&self) -> usize {
        self.pixels.len()
    }

    /// Sums of m², m y, y², m and y over the pixels, of an image m and the observation y.
    fn sums(&self, image: &Image) -> [f64; 5] {
        let mut sums = [0.0; 5];
        for &(i, y) in &self.pixels {
            let (m, y) = (f64::from(image.data[i as usize]), f64::from(y));
            sums = [sums[0] + m * m, sums[1] + m * y, sums[2] + y * y, sums[3] + m, sums[4] + y];
        }
        sums
    }

    /// Gain and veil that fit `image` best, given or by linear least squares, and the inverse normal matrix: NaN if
    /// a flat image cannot tell the two apart.
    fn expose(&self, image: &Image) -> (Vector2<f64>, Matrix2<f64>) {
        let [mm, my, _, m, y] = self.sums(image);
        let n = self.pixels.len() as f64;
        let w = 1.0 / (self.noise * self.noise);
        let fixed_veil = 0.0;
        match (self.datum.gain, self.datum.veil) {
            (Gain::Fixed(gain), VeilTerm::Free) => {
                (Vector2::new(gain, (y - gain * m) / n), Matrix2::new(0.0, 0.0, 0.0, 1.0 / (n * w)))
            }
            (Gain::Fixed(gain), _) => (Vector2::new(gain, fixed_veil), Matrix2::zeros()),
            (Gain::Free, VeilTerm::Free) => {
                let variance = mm - m * m / n;
                if variance <= FLAT * mm {
                    return (Vector2::new(1.0, (y - m) / n), Matrix2::repeat(f64::NAN));
                }
                let inverse = Matrix2::new(n, -m, -m, mm) / (n * variance);
                (inverse * Vector2::new(my, y), inverse / w)
            }
            (Gain::Free, _) if mm > 0.0 => {
                (Vector2::new(my / mm, fixed_veil), Matrix2::new(1.0 / (mm * w), 0.0, 0.0, 0.0))
            }
            (Gain::Free, _) => (Vector2::new(1.0, fixed_veil), Matrix2::zeros()),
        }
    }

    /// Standard deviation of a pixel's noise, from the fine structure of the residual observation - `render` (already
    /// exposed and veiled): the Laplacian of white noise has 20 times its variance, while a misfit, being blurred as
    /// the object's light is, has little there. So a misfit shows in chi² and does not pass for noise.
    pub(super) fn fine_noise(&self, render: &Image) -> f64 {
        let (observed, width) = (self.datum.observed, self.datum.observed.width);
        let residual = |i: usize| f64::from(observed.data[i]) - f64::from(render.data[i]);
        let (mut sum, mut number) = (0.0, 0);
        for y in 1..observed.height.saturating_sub(1) {
            for i in y * width + 1..(y + 1) * width - 1 {
                let around = [i - 1, i + 1, i - width, i + width];
                if self.counts[i] && around.iter().all(|&n| self.counts[n]) {
                    let laplacian = 4.0 * residual(i) - around.iter().map(|&n| residual(n)).sum::<f64>();
                    sum += laplacian * laplacian;
                    number += 1;
                }
            }
        }
        let all = self.pixels.iter().map(|&(i, _)| residual(i as usize).powi(2)).sum::<f64>();
        let variance = if number >= FEWEST_LAPLACIANS {
            sum / f64::from(20 * number)
        } else {
            all / self.pixels() as f64
        };
        let level =
            self.pixels.iter().map(|&(_, y)| f64::from(y).powi(2)).sum::<f64>() / self.pixels() as f64;
        variance.sqrt().max(RENDER_ERROR * level.sqrt()).max(1e-30)
    }

    /// ½ chi² of a rendered image.
    pub(super) fn cost(&self, image: &Image) -> f64 {
        let (exposure, _) = self.expose(image);
        let residual = |&(i, y): &(u32, f32)| {
            let r = exposure[0] * f64::from(image.data[i as usize]) + exposure[1] - f64::from(y);
            r * r
        };
        0.5 * self.pixels.iter().map(residual).sum::<f64>() / (self.noise * self.noise)
    }

    /// The sums of m², m y and y² over noise², of an image m and the observation y; a free veil is taken off both.
    pub(super) fn products(&self, image: &Image) -> [f64; 3] {
        let [mm, my, yy, m, y] = self.sums(image);
        let n =
            if matches!(self.datum.veil, VeilTerm::Free) { self.pixels.len() as f64 } else { f64::INFINITY };
        let w = 1.0 / (self.noise * self.noise);
        [(mm - m * m / n) * w, (my - m * y / n) * w, (yy - y * y / n) * w]
    }

    /// Normal equations of a rendering; `chain` is d value / d coordinate of each parameter.
    pub(super) fn compare(&self, rendering: &Rendering, chain: [f64; 3]) -> NormalEquations {
        let image = &rendering.image;
        let gradient = rendering.gradient.as_ref().expect("rendered with derivatives");
        let (exposure, inverse) = self.expose(image);
        let scale = Vector3::from(chain) * exposure[0];
        let Sums { rr, yy, jr, jj, lj } = self
            .pixels
            .par_chunks(CHUNK)
            .map(|pixels| Sums::over(pixels, image, gradient, (exposure, scale)))
            .collect::<Vec<_>>()
            .into_iter()
            .fold(Sums::default(), Sums::plus);
        let w = 1.0 / (self.noise * self.noise);
        let told_apart = inverse.iter().all(|v| v.is_finite());
        let projection = if told_apart { inverse } else { Matrix2::zeros() };
        let coupling = -projection * lj * w;
        // The residual is already orthogonal to free gain and veil, so the gradient needs no correction.
        NormalEquations {
            cost: 0.5 * rr * w,
            pixels: self.pixels.len(),
            signal: yy * w,
            gradient: jr * w,
            matrix: jj * w - lj.transpose() * projection * lj * (w * w),
            diagonal: jj.diagonal() * w,
            linear: vec![Linear { gain: exposure[0], veil: exposure[1], chi2: rr * w, inverse, coupling }],
        }
    }
}
