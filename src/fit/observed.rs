//! Renders against one observed scene: gain and veil solved for, residuals, noise.
//!
//! The model of a pixel is gain · I + veil. Both enter linearly, so where they are free they take the values that fit
//! a render best.

use super::datum::{Datum, NoiseTerm, VeilTerm};
use super::equations::{Linear, NormalEquations, ONE, Products, RENDER};
use crate::error::{Error, Result, in_range};
use crate::filter::cpu::Rendering;
use crate::image::Image;
use crate::scene::Gain;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3, Vector6};

/// Relative error of a render: an observation without noise cannot be known better than that.
const RENDER_ERROR: f64 = 1e-5;
/// Variance of an image, relative to its mean square, below which it is flat to rounding.
const FLAT: f64 = 1e-10;
/// Share of the pixels by which what hidden light leaves out may still change.
const HIDDEN_SETTLED: f64 = 0.002;
/// With fewer pixels whose neighbours all count, the noise is taken from the residuals themselves.
const FEWEST_LAPLACIANS: i32 = 100;

/// A pixel that counts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted {
    /// Index in the view.
    pub index: u32,
    /// Observed, known veil taken off.
    pub value: f32,
    /// Of its squared residual, [`Observed::noise`] squared over its own variance.
    pub weight: f32,
}

/// A datum with its pixels gathered.
#[derive(Clone)]
pub(super) struct Observed<'a> {
    pub datum: Datum<'a>,
    /// Whether each pixel of the view counts.
    counts: Vec<bool>,
    /// Those that do.
    pixels: Vec<Counted>,
    /// Pixels that do not because of hidden light.
    pub hidden: usize,
    /// Standard deviation of a pixel of weight 1; where variances are given, the root of their harmonic mean.
    pub noise: f64,
}

impl<'a> Observed<'a> {
    pub(super) fn new(datum: &Datum<'a>) -> Result<Self> {
        let mut observed = Self {
            datum: *datum,
            counts: Vec::new(),
            pixels: Vec::new(),
            hidden: 0,
            noise: match datum.noise {
                Some(NoiseTerm::Level(noise)) => noise,
                _ => 1.0,
            },
        };
        observed.gather(|_| true);
        if observed.pixels.is_empty() {
            return Err(Error::NothingToFit("the mask leaves no pixel".into()));
        }
        if let Some(NoiseTerm::Variance(variance)) = datum.noise {
            for pixel in &observed.pixels {
                let (i, width) = (pixel.index as usize, variance.width);
                let (name, value) =
                    (format!("variance of pixel ({}, {})", i % width, i / width), variance.data[i]);
                in_range(&name, f64::from(value), value > 0.0 && value.is_finite(), "finite and above 0")?;
            }
            let sum: f64 = observed.pixels.iter().map(|p| f64::from(p.weight)).sum();
            observed.noise = (observed.pixels() as f64 / sum).sqrt();
            observed.gather(|_| true);
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
        let unit = self.noise * self.noise;
        let weight = |i: usize| match datum.noise {
            Some(NoiseTerm::Variance(image)) => (unit / f64::from(image.data[i])) as f32,
            _ => 1.0,
        };
        let all = &datum.observed.data;
        self.counts = (0..all.len()).map(|i| masked(i) && shown(i)).collect();
        self.hidden = (0..all.len()).filter(|&i| masked(i) && !shown(i)).count();
        let counted = |i: usize| Counted { index: i as u32, value: all[i] - veil(i), weight: weight(i) };
        self.pixels = (0..all.len()).filter(|&i| self.counts[i]).map(counted).collect();
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

    /// The same pixels and noise with another image in place of the observation.
    pub(super) fn seen_as<'b>(&self, image: &'b Image) -> Observed<'b>
    where
        'a: 'b,
    {
        let mut other: Observed<'b> = self.clone();
        other.datum.observed = image;
        other.gather(|i| self.counts[i]);
        other
    }

    pub(super) fn pixels(&self) -> usize {
        self.pixels.len()
    }

    /// The pixels that count.
    pub(super) fn counted(&self) -> &[Counted] {
        &self.pixels
    }

    /// The observed value of every pixel of the view, known veil taken off, and its weight; both 0 where it does not count.
    pub(super) fn values(&self) -> Vec<(f32, f32)> {
        let mut values = vec![(0.0, 0.0); self.counts.len()];
        self.pixels.iter().for_each(|p| values[p.index as usize] = (p.value, p.weight));
        values
    }

    /// Gain and veil as given, 1 and 0 where they are free.
    pub(super) fn given_exposure(&self) -> Vector2<f64> {
        let Gain::Fixed(gain) = self.datum.gain else { return Vector2::new(1.0, 0.0) };
        Vector2::new(gain, 0.0)
    }

    /// What a fit needs of an image that two independent renders with derivatives agree on but for their noise: the mean
    /// products of one with the other, in which the noise has no part.
    pub(super) fn products_between(&self, renders: [&Rendering; 2]) -> Products {
        Products::between(&self.pixels, renders, self.given_exposure())
    }

    /// What a fit needs of `image`, rendered with or without `gradient`.
    pub(super) fn products(&self, image: &Image, gradient: Option<&[Image; 3]>) -> Products {
        Products::over(&self.pixels, image, gradient, self.given_exposure())
    }

    /// Gain and veil that fit best.
    #[cfg(feature = "gpu")]
    pub(super) fn exposure(&self, products: &Products) -> Vector2<f64> {
        self.expose(products).0
    }

    /// Gain and veil that fit best, given or by linear least squares, and the inverse normal matrix: NaN if a flat
    /// image cannot tell the two apart.
    fn expose(&self, products: &Products) -> (Vector2<f64>, Matrix2<f64>) {
        let at = |i, j| products.sums[(i, j)];
        let (mm, m, n) = (at(RENDER, RENDER), at(RENDER, ONE), at(ONE, ONE));
        let w = 1.0 / (self.noise * self.noise);
        let given = self.given_exposure();
        // The residual at what is given, times the render and times 1.
        let residual = products.sums * products.residual(&given);
        let (rm, r) = (residual[RENDER], residual[ONE]);
        match (self.datum.gain, self.datum.veil) {
            (Gain::Fixed(_), VeilTerm::Free) => {
                (given - Vector2::new(0.0, r / n), Matrix2::new(0.0, 0.0, 0.0, 1.0 / (n * w)))
            }
            (Gain::Fixed(_), _) => (given, Matrix2::zeros()),
            (Gain::Free, VeilTerm::Free) => {
                let variance = mm - m * m / n;
                if variance <= FLAT * mm {
                    return (given - Vector2::new(0.0, r / n), Matrix2::repeat(f64::NAN));
                }
                let inverse = Matrix2::new(n, -m, -m, mm) / (n * variance);
                (given - inverse * Vector2::new(rm, r), inverse / w)
            }
            (Gain::Free, _) if mm > 0.0 => {
                (given - Vector2::new(rm / mm, 0.0), Matrix2::new(1.0 / (mm * w), 0.0, 0.0, 0.0))
            }
            (Gain::Free, _) => (given, Matrix2::zeros()),
        }
    }

    /// Standard deviation of a pixel's noise, from the fine structure of the residual observation - render (already
    /// exposed and veiled): the Laplacian of white noise has 20 times its variance, while a misfit, being blurred as
    /// the object's light is, has little there. So a misfit shows in chi² and does not pass for noise. Of two `renders` the
    /// noise that is not in both has no part but for the error of this estimate, twice which is its least value.
    pub(super) fn fine_noise(&self, renders: [&Image; 2]) -> f64 {
        let (observed, width) = (self.datum.observed, self.datum.observed.width);
        let residual = |r: usize, i: usize| f64::from(observed.data[i]) - f64::from(renders[r].data[i]);
        let (mut sum, mut apart, mut number) = (0.0, 0.0, 0);
        for y in 1..observed.height.saturating_sub(1) {
            for i in y * width + 1..(y + 1) * width - 1 {
                let around = [i - 1, i + 1, i - width, i + width];
                if self.counts[i] && around.iter().all(|&n| self.counts[n]) {
                    let laplacian =
                        |r: usize| 4.0 * residual(r, i) - around.iter().map(|&n| residual(r, n)).sum::<f64>();
                    sum += laplacian(0) * laplacian(1);
                    apart += 0.5 * (laplacian(0) - laplacian(1)).powi(2);
                    number += 1;
                }
            }
        }
        let square = |p: &Counted| residual(0, p.index as usize) * residual(1, p.index as usize);
        let all = self.pixels.iter().map(square).sum::<f64>();
        let variance = if number >= FEWEST_LAPLACIANS {
            // Neighbouring Laplacians share pixels: as if half of them were independent.
            let error = apart * (2.0 / f64::from(number)).sqrt();
            sum.max(2.0 * error) / f64::from(20 * number)
        } else {
            all / self.pixels() as f64
        };
        let level =
            self.pixels.iter().map(|p| f64::from(p.value).powi(2)).sum::<f64>() / self.pixels() as f64;
        variance.max(0.0).sqrt().max(RENDER_ERROR * level.sqrt()).max(1e-30)
    }

    /// The sums of m², m y and y² over noise², of the render m and the observation y; a free veil is taken off both.
    pub(super) fn levels(&self, products: &Products) -> [f64; 3] {
        let (render, one, y) = (Vector6::ith(RENDER, 1.0), Vector6::ith(ONE, 1.0), products.observation());
        let free_veil = matches!(self.datum.veil, VeilTerm::Free);
        let n = if free_veil { products.of(&one, &one) } else { f64::INFINITY };
        let w = 1.0 / (self.noise * self.noise);
        let spread = |a, b| (products.of(a, b) - products.of(a, &one) * products.of(b, &one) / n) * w;
        [spread(&render, &render), spread(&render, &y), spread(&y, &y)]
    }

    /// Normal equations of what was rendered; `chain` is d value / d coordinate of each parameter.
    pub(super) fn compare(&self, products: &Products, chain: [f64; 3]) -> NormalEquations {
        let (exposure, inverse) = self.expose(products);
        let residual = products.sums * products.residual(&exposure);
        let rr = products.residual(&exposure).dot(&residual);
        let scale = Vector3::from(chain) * exposure[0];
        let derivatives = products.sums.columns(1, 3) * Matrix3::from_diagonal(&scale);
        let jr = residual.fixed_rows::<3>(1).component_mul(&scale);
        let jj = Matrix3::from_diagonal(&scale) * derivatives.fixed_rows::<3>(1);
        let lj = Matrix2x3::from_rows(&[derivatives.row(RENDER), derivatives.row(ONE)]);
        let w = 1.0 / (self.noise * self.noise);
        let told_apart = inverse.iter().all(|v| v.is_finite());
        let projection = if told_apart { inverse } else { Matrix2::zeros() };
        let coupling = -projection * lj * w;
        let y = products.observation();
        // The residual is already orthogonal to free gain and veil, so the gradient needs no correction.
        NormalEquations {
            cost: 0.5 * rr * w,
            pixels: self.pixels(),
            signal: products.of(&y, &y) * w,
            gradient: jr * w,
            matrix: jj * w - lj.transpose() * projection * lj * (w * w),
            diagonal: jj.diagonal() * w,
            linear: vec![Linear { gain: exposure[0], veil: exposure[1], chi2: rr * w, inverse, coupling }],
        }
    }
}
