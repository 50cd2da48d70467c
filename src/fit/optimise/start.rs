//! Starting values from the images themselves.
//!
//! Fine detail survives only in the direct light, so the regression of the observation's Laplacian on the object's
//! gives the direct share T; the ratio of the mean levels gives what was not absorbed. Hence sigma_t and sigma_a,
//! and sigma_s between them. The width of the phase function is the best of a few tried with the real renderer, and so is the split
//! itself: in thick media the blurred light is taken for direct light, so larger depths are tried too. Light that a
//! wide kernel carries out of the view lowers the level as absorption does, so each trial has its own absorption.

use super::scene_models::SceneModels;
use super::split::Split;
use crate::error::Result;
use crate::fit::observation::{Levels, Observation, Observed};
use crate::fit::parameters::Parameters;
use crate::forward::{Engine, Quantity};
use crate::scene::{FitOptions, Gain};
use std::borrow::Borrow;

/// Blur widths tried, as shares of the view's smaller side.
const WIDTHS: [f64; 5] = [0.01, 0.025, 0.06, 0.14, 0.3];
/// Factors on the scattering depth tried.
const DEPTHS: [f64; 2] = [1.0, 2.5];
/// Slices are few and padding half an image: a start need not be exact.
const SLICES: usize = 5;

/// What is fitted, for the choice of a start.
#[derive(Clone, Copy)]
pub(crate) struct Start<'s, 'a> {
    observed: &'s [Observed<'a>],
    options: &'s FitOptions,
    engine: &'s Engine<'a>,
    median_z: f64,
    split: Split,
}

/// Widths and depths that are tried.
#[derive(Clone, Copy)]
pub(crate) struct Trials<'s> {
    /// Blur widths, as shares of the view's smaller side.
    pub widths: &'s [f64],
    /// Factors on the scattering depth.
    pub depths: &'s [f64],
}

impl<'s, 'a> Start<'s, 'a> {
    /// The start of a fit by `engine` to `observed`, registered already, whose median path length is `median_z`.
    pub(crate) fn new(
        observed: &'s [Observed<'a>],
        options: &'s FitOptions,
        engine: &'s Engine<'a>,
        median_z: f64,
    ) -> Self {
        Self { observed, options, engine, median_z, split: Split::mean(observed, median_z) }
    }

    /// Chooses by renders the values that the user has neither fixed nor started; `progress` is called after each. Returns
    /// their number.
    pub(crate) fn choose(&self, parameters: &mut Parameters, progress: &dyn Fn()) -> Result<u64> {
        let trials = Trials { widths: &WIDTHS, depths: &DEPTHS };
        let reach_px = |observation: &Observation| 0.5 * view_side_px(observation);
        let roughly = || SceneModels::prepare_roughly(self.observed, self.engine, SLICES, reach_px);
        self.scan(parameters, trials, progress, roughly)
    }

    /// Sets the values that the user has neither fixed nor started to the best of all trials by the models that `prepare`
    /// makes. Returns how often they were asked.
    pub(crate) fn scan<M: Borrow<SceneModels<'a>>>(
        &self,
        parameters: &mut Parameters,
        trials: Trials,
        progress: &dyn Fn(),
        prepare: impl FnOnce() -> Result<M>,
    ) -> Result<u64> {
        let Split { sigma_s, sigma_a } = self.split;
        for (quantity, value) in [(Quantity::SigmaS, sigma_s), (Quantity::SigmaA, sigma_a)] {
            if self.is_open(parameters, quantity) {
                parameters.set(quantity, value);
            }
        }
        if !self.scans(parameters) {
            return Ok(0);
        }
        let models = prepare()?;
        let open_level = self.is_open(parameters, Quantity::SigmaA);
        let (mut best, mut asked) = (f64::INFINITY, 0);
        for trial in self.trials(parameters, trials) {
            let mut level = Level::default();
            for (scene, (observed, model)) in self.observed.iter().zip(models.borrow().iter()).enumerate() {
                let products = model.levels(&trial.state(scene)?, observed.pixels())?;
                progress();
                level.add(observed.levels(&products), observed.observation.gain);
                asked += 1;
            }
            let sigma_a = trial.value(Quantity::SigmaA);
            let brightest = if open_level { (sigma_a * self.median_z).exp() } else { 1.0 };
            let scale = if open_level { level.best_scale().clamp(1.0 / DARKEST, brightest) } else { 1.0 };
            if level.cost(scale) < best {
                best = level.cost(scale);
                *parameters = trial;
                parameters.set(Quantity::SigmaA, sigma_a - scale.ln() / self.median_z);
            }
        }
        Ok(asked)
    }

    /// Whether the user has started nothing, and the model has kernels whose width is to be found.
    pub(crate) fn is_automatic(&self) -> bool {
        self.engine.model.spreads() && self.options.is_unstarted()
    }

    /// Whether something is to be chosen by trials.
    fn scans(&self, parameters: &Parameters) -> bool {
        self.is_open(parameters, Quantity::Phase) || self.scans_depth(parameters)
    }

    fn scans_depth(&self, parameters: &Parameters) -> bool {
        self.is_open(parameters, Quantity::SigmaS) && self.engine.model.spreads()
    }

    /// Whether the user has neither fixed nor started `quantity`.
    fn is_open(&self, parameters: &Parameters, quantity: Quantity) -> bool {
        self.options.of(quantity).start.is_none() && parameters.of(quantity).is_free()
    }

    /// The media that are tried, from the values that `first` has.
    fn trials(&self, first: &Parameters, Trials { widths, depths }: Trials) -> Vec<Parameters> {
        let phases: Vec<f64> = if self.is_open(first, Quantity::Phase) {
            let family = first.family();
            widths.iter().map(|&share| family.of_width(self.view_share(share))).collect()
        } else {
            vec![first.value(Quantity::Phase)]
        };
        let depths = if self.scans_depth(first) { depths } else { &[1.0] };
        let (sigma_s, [_, most]) = (first.value(Quantity::SigmaS), first.of(Quantity::SigmaS).bounds());
        // Not what lies beyond the model's range: from its end a fit would not come back.
        let within = |depth: &&f64| **depth <= 1.0 || sigma_s * **depth <= most;
        let trial = |depth: f64, phase: f64| {
            let mut trial = first.clone();
            trial.set(Quantity::SigmaS, sigma_s * depth);
            trial.set(Quantity::Phase, phase);
            trial
        };
        let deep = depths.iter().filter(within);
        deep.flat_map(|&depth| phases.iter().map(move |&phase| (depth, phase)))
            .map(|(depth, phase)| trial(depth, phase))
            .collect()
    }

    /// Begins from a kernel of `width` views, and light dimmed half by scattering out of the view, half by absorption.
    pub(crate) fn place(&self, parameters: &mut Parameters, width: f64) {
        let dimmed = self.split.sigma_s + self.split.sigma_a;
        parameters.set(Quantity::SigmaS, 0.5 * dimmed);
        parameters.set(Quantity::SigmaA, 0.5 * dimmed);
        let phase = parameters.family().of_width(self.view_share(width));
        parameters.set(Quantity::Phase, phase);
    }

    /// Planar width, rad, of the phase function whose kernel is `share` of the view's smaller side wide.
    fn view_share(&self, share: f64) -> f64 {
        let first = &self.observed[0].observation;
        share * view_side_px(first) * first.target.geometry.median_pixel_pitch() / self.median_z
    }
}

/// Widths of kernels, in views, to begin from apart from the automatic start: where that ends in a false minimum, mostly in
/// thick media, in which blurred light passes for direct light.
pub(crate) const OTHER_WIDTHS: [f64; 4] = [0.04, 0.15, 0.7, 2.5];

/// Smaller side of the view, px.
fn view_side_px(observation: &Observation) -> f64 {
    observation.target.view.width.min(observation.target.view.height) as f64
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
    fn add(&mut self, Levels { mm, my, yy }: Levels, gain: Gain) {
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
