//! Renders against data: residuals, weights, normal equations; gain and veil eliminated.
//!
//! For one scene the model of a pixel is gain · I + veil. Its normal equations over the pixels that count are summed
//! in f64. Where gain or veil are free they are solved for first (they enter linearly), and their share is taken
//! out of the Gauss-Newton matrix by the Schur complement (variable projection in Kaufman's form, 1975).

use super::uncertainty::Uncertainty;
use crate::error::{Error, Result};
use crate::filter::Target;
use crate::filter::cpu::Rendering;
use crate::image::Image;
use crate::scene::Gain;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};
use rayon::prelude::*;

/// The veil of one channel, in units of the observation.
#[derive(Debug, Clone, Copy)]
pub enum VeilTerm<'a> {
    /// A known number.
    Fixed(f64),
    /// A known image, of the view's size.
    Image(&'a Image),
    /// One constant, fitted.
    Free,
}

/// One channel of one scene, with its observation.
#[derive(Debug, Clone, Copy)]
pub struct Datum<'a> {
    /// The object and its view.
    pub target: Target<'a>,
    /// The observed image, of the view's size.
    pub observed: &'a Image,
    /// Pixels above 0 count.
    pub mask: Option<&'a Image>,
    /// Standard deviation of a pixel's noise, if known.
    pub noise: Option<f64>,
    /// Exposure.
    pub gain: Gain,
    /// Veil.
    pub veil: VeilTerm<'a>,
}

impl Datum<'_> {
    /// How many of gain and veil are free.
    pub(super) fn free_exposure(&self) -> usize {
        usize::from(self.gain == Gain::Free) + usize::from(matches!(self.veil, VeilTerm::Free))
    }
}

/// Gain, veil, noise and misfit of one scene after a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Exposure: observed = gain · object light + veil.
    pub gain: f64,
    /// Standard error of the gain; `None` if it was given or the data leave it undetermined.
    pub gain_error: Option<f64>,
    /// Veil, the constant part.
    pub veil: f64,
    /// Standard error of the veil; `None` if it was given or the data leave it undetermined.
    pub veil_error: Option<f64>,
    /// Standard deviation of a pixel's noise, given or estimated.
    pub noise: f64,
    /// Sum of squared residuals over noise².
    pub chi2: f64,
    /// Pixels that counted.
    pub pixels: usize,
}

impl Exposure {
    /// The image as observed: gain · `image` + veil.
    pub(super) fn apply(&self, mut image: Image, veil: VeilTerm) -> Image {
        let (gain, constant) = (self.gain as f32, self.veil as f32);
        for (i, v) in image.data.iter_mut().enumerate() {
            let veil = if let VeilTerm::Image(veil) = veil { veil.data[i] } else { constant };
            *v = gain * *v + veil;
        }
        image
    }
}

/// A datum with its pixels gathered: values of those that count, known veil taken off.
pub(super) struct Observed<'a> {
    datum: Datum<'a>,
    /// Index in the view and value of every pixel that counts.
    pixels: Vec<(u32, f32)>,
    pub noise: f64,
}

/// The values of gain and veil that fit best, and what is needed for their errors.
#[derive(Debug, Clone, Copy)]
struct Linear {
    gain: f64,
    veil: f64,
    chi2: f64,
    /// Inverse of the normal matrix of (gain, veil), rows of given ones 0.
    inverse: Matrix2<f64>,
    /// Change of (gain, veil) with the coordinates.
    coupling: Matrix2x3<f64>,
}

/// Cost ½ chi², its gradient and Gauss-Newton matrix in the solver's coordinates.
#[derive(Debug, Clone, Default)]
pub(crate) struct NormalEquations {
    pub cost: f64,
    /// Pixels, and the observation's sum of squares over noise²: what a change of cost is measured against.
    pub pixels: usize,
    pub signal: f64,
    pub gradient: Vector3<f64>,
    /// With gain and veil eliminated.
    pub matrix: Matrix3<f64>,
    /// Diagonal before they were: the scale against which a direction counts as lost.
    pub diagonal: Vector3<f64>,
    linear: Vec<Linear>,
}

impl<'a> Observed<'a> {
    pub(super) fn new(datum: &Datum<'a>) -> Result<Self> {
        let counts = |i: &usize| datum.mask.is_none_or(|m| m.data[*i] > 0.0);
        let veil = |i: usize| match datum.veil {
            VeilTerm::Fixed(v) => v as f32,
            VeilTerm::Image(image) => image.data[i],
            VeilTerm::Free => 0.0,
        };
        let all = &datum.observed.data;
        let pixels: Vec<(u32, f32)> =
            (0..all.len()).filter(counts).map(|i| (i as u32, all[i] - veil(i))).collect();
        if pixels.is_empty() {
            return Err(Error::NothingToFit("the mask leaves no pixel".into()));
        }
        Ok(Self { datum: *datum, pixels, noise: datum.noise.unwrap_or(1.0) })
    }

    pub(super) fn pixels(&self) -> usize {
        self.pixels.len()
    }

    /// Gain and veil that fit `image` best, given or by linear least squares, and the inverse normal matrix.
    fn expose(&self, image: &Image) -> (Vector2<f64>, Matrix2<f64>) {
        let mut sums = [0.0; 5];
        for &(i, y) in &self.pixels {
            let (m, y) = (f64::from(image.data[i as usize]), f64::from(y));
            sums = [sums[0] + m * m, sums[1] + m, sums[2] + m * y, sums[3] + y, sums[4] + 1.0];
        }
        let [mm, m, my, y, n] = sums;
        let w = 1.0 / (self.noise * self.noise);
        let fixed_veil = 0.0;
        match (self.datum.gain, self.datum.veil) {
            (Gain::Fixed(gain), VeilTerm::Free) => {
                (Vector2::new(gain, (y - gain * m) / n), Matrix2::new(0.0, 0.0, 0.0, 1.0 / (n * w)))
            }
            (Gain::Fixed(gain), _) => (Vector2::new(gain, fixed_veil), Matrix2::zeros()),
            (Gain::Free, VeilTerm::Free) => {
                let inverse = Matrix2::new(mm, m, m, n).try_inverse().unwrap_or_else(Matrix2::zeros);
                (inverse * Vector2::new(my, y), inverse / w)
            }
            (Gain::Free, _) if mm > 0.0 => {
                (Vector2::new(my / mm, fixed_veil), Matrix2::new(1.0 / (mm * w), 0.0, 0.0, 0.0))
            }
            (Gain::Free, _) => (Vector2::new(1.0, fixed_veil), Matrix2::zeros()),
        }
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
        let mut sums = [0.0; 5];
        for &(i, y) in &self.pixels {
            let (m, y) = (f64::from(image.data[i as usize]), f64::from(y));
            sums = [sums[0] + m * m, sums[1] + m * y, sums[2] + y * y, sums[3] + m, sums[4] + y];
        }
        let [mm, my, yy, m, y] = sums;
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
        let coupling = -inverse * lj * w;
        // The residual is already orthogonal to free gain and veil, so the gradient needs no correction.
        NormalEquations {
            cost: 0.5 * rr * w,
            pixels: self.pixels.len(),
            signal: yy * w,
            gradient: jr * w,
            matrix: jj * w - lj.transpose() * inverse * lj * (w * w),
            diagonal: jj.diagonal() * w,
            linear: vec![Linear { gain: exposure[0], veil: exposure[1], chi2: rr * w, inverse, coupling }],
        }
    }
}

/// A decrease of chi² by this times its expectation a pixel moves the estimate by a hundredth of a standard error.
const SETTLED: f64 = 1e-4;
/// Renders are f32: what is below (1e-7)² of the signal is rounding.
const ROUNDING: f64 = 1e-14;

/// Pixels summed together; the chunks are added in order, so that the result does not depend on the threads.
const CHUNK: usize = 8192;

/// Sums over pixels of products of residual r, observation y, derivatives j and the linear terms (image, 1).
#[derive(Default)]
struct Sums {
    rr: f64,
    yy: f64,
    jr: Vector3<f64>,
    jj: Matrix3<f64>,
    lj: Matrix2x3<f64>,
}

impl Sums {
    fn over(
        pixels: &[(u32, f32)],
        image: &Image,
        gradient: &[Image; 3],
        (exposure, scale): (Vector2<f64>, Vector3<f64>),
    ) -> Self {
        let mut sums = Self::default();
        for &(i, y) in pixels {
            let (i, y) = (i as usize, f64::from(y));
            let m = f64::from(image.data[i]);
            let r = exposure[0] * m + exposure[1] - y;
            let j = Vector3::from_fn(|c, _| f64::from(gradient[c].data[i])).component_mul(&scale);
            sums.rr += r * r;
            sums.yy += y * y;
            sums.jr += j * r;
            sums.jj += j * j.transpose();
            sums.lj += Vector2::new(m, 1.0) * j.transpose();
        }
        sums
    }

    fn plus(self, other: Self) -> Self {
        Self {
            rr: self.rr + other.rr,
            yy: self.yy + other.yy,
            jr: self.jr + other.jr,
            jj: self.jj + other.jj,
            lj: self.lj + other.lj,
        }
    }
}

impl NormalEquations {
    /// The decrease of the cost that no longer matters.
    pub(super) fn negligible(&self) -> f64 {
        SETTLED * self.cost / self.pixels as f64 + ROUNDING * self.signal
    }

    pub(super) fn add(&mut self, other: NormalEquations) {
        self.cost += other.cost;
        self.pixels += other.pixels;
        self.signal += other.signal;
        self.gradient += other.gradient;
        self.matrix += other.matrix;
        self.diagonal += other.diagonal;
        self.linear.extend(other.linear);
    }

    pub(super) fn is_finite(&self) -> bool {
        self.cost.is_finite() && self.gradient.iter().chain(self.matrix.iter()).all(|v| v.is_finite())
    }

    /// Gain and veil of every scene with their errors.
    pub(super) fn exposures(&self, observed: &[Observed], uncertainty: &Uncertainty) -> Vec<Exposure> {
        let error = |l: &Linear, row: usize, free: bool| {
            let shared = uncertainty.variance_of(&l.coupling.row(row).transpose())?;
            free.then(|| (l.inverse[(row, row)] + shared).sqrt())
        };
        let exposure = |(l, o): (&Linear, &Observed)| Exposure {
            gain: l.gain,
            gain_error: error(l, 0, o.datum.gain == Gain::Free),
            veil: match o.datum.veil {
                VeilTerm::Fixed(v) => v,
                _ => l.veil,
            },
            veil_error: error(l, 1, matches!(o.datum.veil, VeilTerm::Free)),
            noise: o.noise,
            chi2: l.chi2,
            pixels: o.pixels(),
        };
        self.linear.iter().zip(observed).map(exposure).collect()
    }
}

/// Estimates from their residuals the noise of the scenes that do not give it; returns the largest relative change.
pub(super) fn estimate_noise(observed: &mut [Observed], data: &[Datum], equations: &NormalEquations) -> f64 {
    let mut change: f64 = 0.0;
    for ((o, datum), linear) in observed.iter_mut().zip(data).zip(&equations.linear) {
        if datum.noise.is_none() {
            // Three shared parameters at most, plus the scene's own.
            let freedom = o.pixels().saturating_sub(3 + datum.free_exposure()).max(1);
            let noise =
                (linear.chi2 * o.noise * o.noise / freedom as f64).sqrt().max(f64::MIN_POSITIVE.sqrt());
            change = change.max((noise / o.noise - 1.0).abs());
            o.noise = noise;
        }
    }
    change
}
