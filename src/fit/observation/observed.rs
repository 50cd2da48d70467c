//! One observed scene: which of its pixels count, with what weight, and how noisy they are.

use super::exposure::Linear;
use super::object_noise::ObjectNoise;
use super::pixel_noise::first_variance;
use super::{NoiseTerm, Observation, VeilTerm};
use crate::error::{Error, Result, in_range};
use crate::forward::{Exposure, Pixel, Pixels, Products, Veil};
use crate::image::Image;
use crate::scene::Gain;
use std::sync::Arc;

/// Relative error of a render: an observation without noise cannot be known better than that.
const RENDER_ERROR: f64 = 1e-5;
/// Share of the pixels by which what hidden light leaves out may still change.
const HIDDEN_SETTLED: f64 = 0.002;
/// With fewer pixels whose neighbours all count, the noise is taken from the residuals themselves.
const FEWEST_LAPLACIANS: i32 = 100;

/// Noises by which light from outside the clear image may change a pixel that counts.
const SHOWN: f64 = 0.5;
/// Share of the pixels that stay, those that see the least of such light, whatever the noise shows: where kernels are as wide as the
/// view, all of it sees some, and the error of the extrapolation is stated.
const KEPT: f64 = 0.25;
/// Bounds of the share of such light.
const OUTSIDE_SHARES: [f64; 2] = [0.002, 0.1];

/// Why a pixel that is not masked counts, or does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sight {
    Clear,
    Hidden,
    Outside,
}

/// Shares of each pixel's light that no image shows; `None` where there is none.
#[derive(Debug, Clone, Default)]
pub(crate) struct Unseen {
    /// Hidden behind near surfaces.
    pub hidden: Option<Image>,
    /// From outside the clear image.
    pub outside: Option<Image>,
}

/// An observation with its pixels gathered.
#[derive(Clone)]
pub(crate) struct Observed<'a> {
    pub observation: Observation<'a>,
    /// Whether each pixel of the view counts.
    counts: Vec<bool>,
    /// Those that do. Each has the weight [`noise`](Self::noise) squared over its own variance.
    pixels: Pixels,
    /// Pixels that do not because of hidden light.
    pub hidden: usize,
    /// Pixels that do not because of light from outside the clear image.
    pub outside: usize,
    /// Standard deviation of a pixel of weight 1; where pixels have variances of their own, the root of their harmonic mean.
    pub noise: f64,
    /// The variance of each pixel, if not all have the same.
    variance: Option<Arc<Image>>,
    /// The noise of the clear image, if it has some.
    pub object_noise: Option<ObjectNoise>,
}

impl<'a> Observed<'a> {
    pub(crate) fn new(observation: &Observation<'a>) -> Result<Self> {
        let gain = if let Gain::Fixed(gain) = observation.gain { gain } else { 1.0 };
        let reference = Exposure { gain, veil: Veil::default() };
        let mut observed = Self {
            observation: *observation,
            counts: Vec::new(),
            pixels: Pixels {
                counted: Vec::new(),
                places: observation.places(),
                reference,
                veil_terms: observation.veil.free_terms().max(1),
            },
            hidden: 0,
            outside: 0,
            noise: match observation.noise {
                Some(NoiseTerm::Level(noise)) => noise,
                _ => 1.0,
            },
            variance: None,
            object_noise: ObjectNoise::new(observation),
        };
        observed.gather(|_| Sight::Clear);
        if observed.count() == 0 {
            return Err(Error::NothingToFit("the mask leaves no pixel".into()));
        }
        if let Some(variance) = first_variance(observation) {
            check_variances(&variance, &observed.pixels)?;
            observed.set_variance(variance);
        }
        Ok(observed)
    }

    /// Weighs each pixel by its `variance` from now on.
    pub(super) fn set_variance(&mut self, variance: Image) {
        let inverse = |p: &Pixel| 1.0 / f64::from(variance.data[p.index as usize]);
        let sum: f64 = self.counted().iter().map(inverse).sum();
        self.noise = (self.count() as f64 / sum).sqrt();
        self.variance = Some(Arc::new(variance));
        self.gather_again();
    }

    /// Gathers the same pixels again.
    fn gather_again(&mut self) {
        let (counts, left_out) = (std::mem::take(&mut self.counts), (self.hidden, self.outside));
        self.gather(|i| if counts[i] { Sight::Clear } else { Sight::Hidden });
        (self.hidden, self.outside) = left_out;
    }

    /// Gathers the pixels that the mask lets count, where `sight` is clear.
    fn gather(&mut self, sight: impl Fn(usize) -> Sight) {
        let observation = self.observation;
        let veil = |i: usize| match observation.veil {
            VeilTerm::Fixed(v) => v as f32,
            VeilTerm::Image(image) => image.data[i],
            VeilTerm::Free(_) => 0.0,
        };
        let unit = self.noise * self.noise;
        let variance = self.variance.clone();
        let weight = |i: usize| match &variance {
            Some(image) => (unit / f64::from(image.data[i])) as f32,
            None => 1.0,
        };
        let all = &observation.observed.data;
        let unmasked = |i: &usize| observation.is_unmasked(*i);
        self.counts = (0..all.len()).map(|i| unmasked(&i) && sight(i) == Sight::Clear).collect();
        let left_out = |why: Sight| (0..all.len()).filter(unmasked).filter(|&i| sight(i) == why).count();
        (self.hidden, self.outside) = (left_out(Sight::Hidden), left_out(Sight::Outside));
        let pixel = |i: usize| Pixel { index: i as u32, value: all[i] - veil(i), weight: weight(i) };
        self.pixels.counted = (0..all.len()).filter(|&i| self.counts[i]).map(pixel).collect();
        if let Some(noise) = &mut self.object_noise {
            noise.observe(&self.pixels.counted);
        }
    }

    /// Leaves out the pixels that see too much that no image shows; returns whether that differs from what was left out before by
    /// enough to matter.
    ///
    /// # Errors
    /// [`Error::NothingToFit`] if no pixel is left.
    pub(crate) fn leave_out(&mut self, unseen: &Unseen) -> Result<bool> {
        let most = self.observation.hidden_share_max;
        let most_outside = self.visible_share().max(unseen.outside.as_ref().map_or(0.0, least_share));
        let above = |share: &Option<Image>, most: f64, i: usize| {
            share.as_ref().is_some_and(|share| f64::from(share.data[i]) > most)
        };
        let sight = |i: usize| match () {
            () if above(&unseen.hidden, most, i) => Sight::Hidden,
            () if above(&unseen.outside, most_outside, i) => Sight::Outside,
            () => Sight::Clear,
        };
        let changed = (0..self.counts.len())
            .filter(|&i| self.observation.is_unmasked(i) && (sight(i) == Sight::Clear) != self.counts[i])
            .count();
        if changed as f64 <= HIDDEN_SETTLED * self.count() as f64 {
            return Ok(false);
        }
        self.gather(sight);
        if self.count() == 0 {
            let why = if self.hidden >= self.outside {
                format!(
                    "more than {most} of the light of every pixel may be hidden behind near surfaces; give what lies there as a \
                     further layer of the object, or raise hidden_share_max"
                )
            } else {
                "every pixel sees light from outside the clear image; take one that is larger than the view"
                    .into()
            };
            return Err(Error::NothingToFit(why));
        }
        Ok(true)
    }

    /// The share of a pixel's light that may come from outside the clear image before the noise shows it: what is there differs from
    /// what is taken for it by as much as the clear image varies.
    fn visible_share(&self) -> f64 {
        let clear = self.observation.target.radiance;
        let mean = clear.mean();
        let variance =
            clear.data.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / clear.data.len() as f64;
        let level = self.counted().iter().map(|p| f64::from(p.value)).sum::<f64>() / self.count() as f64;
        let visible = SHOWN * self.noise * mean / (level.abs() * variance.sqrt());
        let [least, most] = OUTSIDE_SHARES;
        if visible.is_finite() { visible.clamp(least, most) } else { most }
    }

    /// The same pixels and noise with another image in place of the observation: a render of the object as it stands, whose noise
    /// is no error there.
    pub(crate) fn seen_as<'b>(&self, image: &'b Image) -> Observed<'b>
    where
        'a: 'b,
    {
        let mut other: Observed<'b> = self.clone();
        other.observation.observed = image;
        other.object_noise = None;
        other.gather_again();
        other
    }

    /// Number of pixels that count.
    pub(crate) fn count(&self) -> usize {
        self.counted().len()
    }

    /// The pixels that count.
    pub(crate) fn counted(&self) -> &[Pixel] {
        &self.pixels.counted
    }

    /// The same with the size of the view and the exposure at which residuals are formed.
    pub(crate) fn pixels(&self) -> &Pixels {
        &self.pixels
    }

    /// Gain and veil that fit a render best: given, or by linear least squares.
    pub(crate) fn linear(&self, products: &Products) -> Linear {
        Linear::solve(&self.observation, products, self.pixels.reference)
    }

    /// 1 over the variance of a pixel of weight 1.
    pub(crate) fn precision(&self) -> f64 {
        1.0 / (self.noise * self.noise)
    }

    /// Standard deviation of a pixel's noise, from the fine structure of the residual observation - render (already
    /// exposed and veiled): the Laplacian of white noise has 20 times its variance, while a misfit, being blurred as
    /// the object's light is, has little there. So a misfit shows in chi² and does not pass for noise. Of two `renders` the
    /// noise that is not in both has no part but for the error of this estimate, twice which is its least value.
    pub(crate) fn fine_noise(&self, renders: [&Image; 2]) -> f64 {
        let (observed, width) = (self.observation.observed, self.observation.observed.width);
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
        let square = |p: &Pixel| residual(0, p.index as usize) * residual(1, p.index as usize);
        let all = self.counted().iter().map(square).sum::<f64>();
        let variance = if number >= FEWEST_LAPLACIANS {
            // Neighbouring Laplacians share pixels: as if half of them were independent.
            let error = apart * (2.0 / f64::from(number)).sqrt();
            sum.max(2.0 * error) / f64::from(20 * number)
        } else {
            all / self.count() as f64
        };
        let level =
            self.counted().iter().map(|p| f64::from(p.value).powi(2)).sum::<f64>() / self.count() as f64;
        variance.max(0.0).sqrt().max(RENDER_ERROR * level.sqrt()).max(1e-30)
    }

    /// The products of m with m, of m with y and of y with y over noise², of the render m and the observation y; a free veil
    /// is taken off both.
    pub(crate) fn levels(&self, products: &Products) -> Levels {
        let (render, one, y) = (products.render(), products.veil(0), products.observation());
        let free_veil = matches!(self.observation.veil, VeilTerm::Free(_));
        let n = if free_veil { products.of(&one, &one) } else { f64::INFINITY };
        let w = self.precision();
        let spread = |a, b| (products.of(a, b) - products.of(a, &one) * products.of(b, &one) / n) * w;
        Levels { mm: spread(&render, &render), my: spread(&render, &y), yy: spread(&y, &y) }
    }
}

/// The share that the pixels of [`KEPT`] do not exceed, which see the least.
fn least_share(outside: &Image) -> f64 {
    let mut shares = outside.data.clone();
    let last = ((KEPT * shares.len() as f64) as usize).min(shares.len() - 1);
    f64::from(*shares.select_nth_unstable_by(last, f32::total_cmp).1)
}

/// Products of a render m and an observation y.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Levels {
    pub mm: f64,
    pub my: f64,
    pub yy: f64,
}

/// Refuses a variance that is none, of a pixel that counts.
fn check_variances(variance: &Image, pixels: &Pixels) -> Result<()> {
    for pixel in &pixels.counted {
        let (i, width) = (pixel.index as usize, variance.width);
        let name = format!("variance of pixel ({}, {})", i % width, i / width);
        let value = variance.data[i];
        in_range(&name, f64::from(value), value > 0.0 && value.is_finite(), "finite and above 0")?;
    }
    Ok(())
}
