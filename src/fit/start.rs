//! Starting values from the images themselves.
//!
//! Fine detail survives only in the direct light, so the regression of the observation's Laplacian on the object's
//! gives the direct share T; the ratio of the mean levels gives what was not absorbed. Hence sigma_t and sigma_a,
//! and sigma_s between them. The lobe's width is the best of a few tried with the real renderer, and so is the split
//! itself: in thick media the blurred light is taken for direct light, so larger depths are tried too. Light that a
//! wide kernel carries out of the view lowers the level as absorption does, so each trial has its own absorption.

use super::comparison::Comparison;
use super::datum::{Datum, VeilTerm};
use super::equations::Products;
use super::observed::Observed;
use super::{Parameters, Settings, with_optics};
use crate::error::Result;
use crate::filter::{Optics, Target};
use crate::scene::{FitOptions, Gain};

/// Blur widths tried, as shares of the view's smaller side.
const WIDTHS: [f64; 5] = [0.01, 0.025, 0.06, 0.14, 0.3];
/// Factors on the scattering depth tried.
const DEPTHS: [f64; 2] = [1.0, 2.5];
/// Range of scattering depths to begin from.
const TAU: (f64, f64) = (0.1, 8.0);
/// Slices are few and padding half an image: a start need not be exact.
const SLICES: usize = 5;

/// Chooses the values that the user has neither fixed nor started; returns the number of renders.
pub(super) fn choose<'a>(
    parameters: &mut Parameters,
    options: &FitOptions,
    data: &[Datum<'a>],
    observed: &[Observed],
    settings: &Settings<'a>,
    median_z: f64,
) -> Result<u64> {
    let mut scenes = Vec::new();
    let split = Split::mean(data, median_z);
    let scan = Scan { data, observed, split: &split, settings, median_z };
    scan.best(parameters, options, (&WIDTHS, &DEPTHS), |i, optics| {
        if scenes.is_empty() {
            for (d, o) in data.iter().zip(observed) {
                let target = Target { relief: None, ..d.target };
                let filter = settings.backend.prepare_slices(target, SLICES, 0.5 * view_side_px(d))?;
                scenes.push(Comparison::new(filter, o)?);
            }
        }
        let products = scenes[i].levels(optics, &observed[i])?;
        (settings.progress)();
        Ok(products)
    })
}

/// What trial media are compared with.
pub(super) struct Scan<'s> {
    pub data: &'s [Datum<'s>],
    pub observed: &'s [Observed<'s>],
    pub split: &'s Split,
    pub settings: &'s Settings<'s>,
    pub median_z: f64,
}

impl Scan<'_> {
    /// Sets the values that the user has neither fixed nor started to the best of all trials of `widths` and `depths`;
    /// `products` tells what a scene makes of a trial. Returns how often it was asked.
    pub(super) fn best(
        &self,
        parameters: &mut Parameters,
        options: &FitOptions,
        (widths, depths): (&[f64], &[f64]),
        mut products: impl FnMut(usize, &Optics) -> Result<Products>,
    ) -> Result<u64> {
        let Self { data, observed, split: &Split { sigma_s, sigma_a }, settings, median_z } = *self;
        let open: [bool; 3] = std::array::from_fn(|i| options.start[i].is_none() && !parameters.is_fixed(i));
        let (scan_depth, scan_width) = (open[0] && settings.model.spreads(), open[2]);
        for (i, value) in [(0, sigma_s), (1, sigma_a)] {
            if open[i] {
                parameters.set(i, value);
            }
        }
        if !scan_width && !scan_depth {
            return Ok(0);
        }
        let widths: Vec<f64> = if scan_width {
            let family = parameters.family();
            widths.iter().map(|&share| family.of_width(view_share(share, &data[0], median_z))).collect()
        } else {
            vec![parameters.values()[2]]
        };
        let depths = if scan_depth { depths } else { &[1.0] };
        let first = parameters.clone();
        let mut best = f64::INFINITY;
        let mut asked = 0;
        // Not what lies beyond the model's range: from its end a fit would not come back.
        let within = |depth: &&f64| **depth <= 1.0 || first.values()[0] * **depth <= first.bounds(0)[1];
        for &depth in depths.iter().filter(within) {
            for &shape in &widths {
                let mut trial = first.clone();
                trial.set(0, first.values()[0] * depth);
                trial.set(2, shape);
                let mut level = Level::default();
                for (i, (observed, datum)) in observed.iter().zip(data).enumerate() {
                    let products = with_optics(&trial, settings.model, |optics| products(i, optics))?;
                    level.add(observed.levels(&products), datum.gain);
                    asked += 1;
                }
                let brightest = if open[1] { (trial.values()[1] * median_z).exp() } else { 1.0 };
                let scale = if open[1] { level.best_scale().clamp(1.0 / DARKEST, brightest) } else { 1.0 };
                if level.cost(scale) < best {
                    best = level.cost(scale);
                    trial.set(1, trial.values()[1] - scale.ln() / median_z);
                    *parameters = trial;
                }
            }
        }
        Ok(asked)
    }
}

/// Widths of kernels, in views, to begin from apart from the automatic start: where that ends in a false minimum, mostly in
/// thick media, in which blurred light passes for direct light.
pub(super) const OTHER_WIDTHS: [f64; 4] = [0.04, 0.15, 0.7, 2.5];

/// Begins from a kernel of `width` views, and light dimmed half by scattering out of the view, half by absorption.
pub(super) fn place(
    parameters: &mut Parameters,
    (data, split): (&[Datum], &Split),
    width: f64,
    median_z: f64,
) {
    let dimmed = split.sigma_s + split.sigma_a;
    parameters.set(0, 0.5 * dimmed);
    parameters.set(1, 0.5 * dimmed);
    parameters.set(2, parameters.family().of_width(view_share(width, &data[0], median_z)));
}

/// Smaller side of the view, px.
fn view_side_px(datum: &Datum) -> f64 {
    datum.target.view.width.min(datum.target.view.height) as f64
}

/// Planar width, rad, of the lobe whose kernel is `share` of the view's smaller side wide.
fn view_share(share: f64, datum: &Datum, median_z: f64) -> f64 {
    share * view_side_px(datum) * datum.target.geometry.median_pixel_pitch() / median_z
}

/// Most that absorption may dim the first guess further.
const DARKEST: f64 = 1e3;

/// How renders compare with observations if all of them may be scaled together, as absorption would.
#[derive(Default)]
struct Level {
    mm: f64,
    my: f64,
    yy: f64,
    /// Of scenes with a free gain, which scale by themselves.
    settled: f64,
}

impl Level {
    fn add(&mut self, [mm, my, yy]: [f64; 3], gain: Gain) {
        match gain {
            Gain::Free => self.settled += yy - if mm > 0.0 { my * my / mm } else { 0.0 },
            Gain::Fixed(gain) => {
                self.mm += gain * gain * mm;
                self.my += gain * my;
                self.yy += yy;
            }
        }
    }

    fn best_scale(&self) -> f64 {
        if self.mm > 0.0 { self.my / self.mm } else { 1.0 }
    }

    fn cost(&self, scale: f64) -> f64 {
        self.settled + self.yy - 2.0 * scale * self.my + scale * scale * self.mm
    }
}

/// Coefficients from one scene's direct share and mean level.
pub(super) struct Split {
    sigma_s: f64,
    sigma_a: f64,
}

impl Split {
    pub(super) fn mean(data: &[Datum], median_z: f64) -> Self {
        let splits: Vec<Split> = data.iter().map(|d| Split::of(d, median_z)).collect();
        let mean = |f: fn(&Split) -> f64| splits.iter().map(f).sum::<f64>() / splits.len() as f64;
        Self { sigma_s: mean(|s| s.sigma_s), sigma_a: mean(|s| s.sigma_a) }
    }

    fn of(datum: &Datum, median_z: f64) -> Self {
        let gain = match datum.gain {
            Gain::Fixed(gain) => gain,
            Gain::Free => 1.0,
        };
        let (level, detail) = rayon::join(|| level_ratio(datum), || detail_ratio(datum));
        let level = (level / gain).clamp(1e-6, 1e6);
        let direct = detail.map_or(0.4 * level, |d| (d / gain).clamp(1e-6, level));
        let tau = (level / direct).ln().clamp(TAU.0, TAU.1);
        // With a free gain the level says nothing of the absorption.
        let absorbed = if datum.gain == Gain::Free { 0.0 } else { -level.min(1.0).ln() };
        Self { sigma_s: tau / median_z, sigma_a: absorbed / median_z }
    }
}

/// Pairs of (object, observation) over the view's pixels that count, for `f` of both images.
fn pixel_pairs(
    datum: &Datum,
    f: impl Fn(&dyn Fn(usize, usize) -> f64, usize, usize) -> f64,
) -> Vec<(f64, f64)> {
    let view = datum.target.view;
    let object = |x: usize, y: usize| f64::from(datum.target.radiance.at(view.x + x, view.y + y));
    let observed = |x: usize, y: usize| f64::from(datum.observed.at(x, y));
    let counts = |x: usize, y: usize| {
        let around = [(x, y), (x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
        around.iter().all(|&(x, y)| {
            datum.mask.is_none_or(|m| m.at(x, y) > 0.0)
                && datum.target.geometry.path_length(view.x + x, view.y + y).is_some()
        })
    };
    let inner = |n: usize| 1..n.saturating_sub(1);
    inner(view.height)
        .flat_map(|y| inner(view.width).map(move |x| (x, y)))
        .filter(|&(x, y)| counts(x, y))
        .map(|(x, y)| (f(&object, x, y), f(&observed, x, y)))
        .collect()
}

/// Regression of the observation's Laplacian on the object's: the direct share; `None` if the object has no detail.
fn detail_ratio(datum: &Datum) -> Option<f64> {
    let laplacian = |image: &dyn Fn(usize, usize) -> f64, x: usize, y: usize| {
        4.0 * image(x, y) - image(x - 1, y) - image(x + 1, y) - image(x, y - 1) - image(x, y + 1)
    };
    let (mut both, mut object) = (0.0, 0.0);
    for (o, y) in pixel_pairs(datum, laplacian) {
        both += o * y;
        object += o * o;
    }
    (object > 0.0).then(|| both / object)
}

/// Mean level of the observation over the object's; with a free veil, the slope between their means over blocks.
fn level_ratio(datum: &Datum) -> f64 {
    let pairs = pixel_pairs(datum, |image, x, y| image(x, y));
    let known_veil = match datum.veil {
        VeilTerm::Fixed(v) => v,
        VeilTerm::Image(image) => image.mean(),
        VeilTerm::Free => 0.0,
    };
    let mean =
        |f: fn(&(f64, f64)) -> f64, of: &[(f64, f64)]| of.iter().map(f).sum::<f64>() / of.len().max(1) as f64;
    if !matches!(datum.veil, VeilTerm::Free) {
        let object = mean(|p| p.0, &pairs);
        return if object > 0.0 { (mean(|p| p.1, &pairs) - known_veil) / object } else { 1.0 };
    }
    let blocks: Vec<(f64, f64)> =
        pairs.chunks((pairs.len() / 64).max(1)).map(|c| (mean(|p| p.0, c), mean(|p| p.1, c))).collect();
    let (x, y) = (mean(|p| p.0, &blocks), mean(|p| p.1, &blocks));
    let covariance: f64 = blocks.iter().map(|b| (b.0 - x) * (b.1 - y)).sum();
    let variance: f64 = blocks.iter().map(|b| (b.0 - x) * (b.0 - x)).sum();
    if variance > 0.0 { covariance / variance } else { 1.0 }
}
