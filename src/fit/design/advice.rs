//! Which measurement would free what the data leave undetermined: not guessed but computed, from the Fisher information that
//! the measurement would add at the medium found (see [`forecast`](super::forecast())).

use crate::error::Result;
use crate::filter::Target;
use crate::fit::Settings;
use crate::fit::inference::ChannelFit;
use crate::fit::observation::{NoiseTerm, Observation, VeilTerm};
use crate::fit::parameters::{Id, Parameter, Parameters};
use crate::fit::report::{AdviceReport, suffix};
use crate::fit::select::{Planned, PlannedExposure, Prospect, seen};
use crate::geometry::{FARTHEST, Field, Geometry};
use crate::image::Image;
use crate::relief::Relief;
use crate::scene::Gain;

/// Cells of the target of sharp edges, px.
const CELL_PX: usize = 8;
/// Share of the light in its dark cells: prints are not black.
const DARK: f32 = 0.1;
/// Share of the noise that four exposures leave.
const HALF: f64 = 0.5;

/// A measurement, and what would be known with it if the medium is as estimated.
#[derive(Debug, Clone, PartialEq)]
pub struct Advice {
    /// What would be measured or known besides.
    pub measurement: &'static str,
    /// Whether every free parameter would be determined.
    pub frees: bool,
    /// Name and standard error of each parameter of the medium; `None` where fixed or still undetermined.
    pub std_errors: Vec<(String, Option<f64>)>,
    /// The same for people, without the measurement.
    known: Vec<String>,
    /// The largest of the errors, in natural scales of the coordinates; infinite unless all is determined.
    worst: f64,
}

/// What would be fitted: scenes, the exposure of each, and the noise in units of today's.
struct Plan<'a> {
    measurement: &'static str,
    observations: Vec<Observation<'a>>,
    exposures: Vec<PlannedExposure>,
    noise: f64,
}

/// Tries what could be done besides `observations`, whose `fit` leaves something undetermined; the best first. Empty if nothing is
/// undetermined, or the model sees direct light alone, to which no measurement adds.
///
/// For a traced model kernels stand in: it is the same light, and the noise of few paths would pass for want of information.
/// Empty where it has none.
///
/// # Errors
/// As [`fit_channel`](crate::fit::fit_channel).
pub fn advise(
    observations: &[Observation],
    fit: &ChannelFit,
    settings: &Settings,
    progress: &dyn Fn(),
) -> Result<Vec<Advice>> {
    if !(fit.model.spreads() && fit.covariance.leaves_open()) {
        return Ok(Vec::new());
    }
    let engine = Settings { model: fit.model, ..*settings }.engine();
    let stands_in = engine.without_noise();
    let exposures = PlannedExposure::of(fit);
    let measured = observations
        .iter()
        .zip(&exposures)
        .map(|(o, e)| Observation { noise: o.noise.or(Some(NoiseTerm::Level(e.noise))), ..*o });
    let study = Study { fit, exposures: &exposures, settings: &settings.with(stands_in), progress };
    match study.all(&measured.collect::<Vec<_>>()) {
        Err(error) if stands_in.model != fit.model && error.is_about_model() => Ok(Vec::new()),
        advice => advice,
    }
}

/// A fit beside which measurements are planned.
struct Study<'x> {
    fit: &'x ChannelFit,
    exposures: &'x [PlannedExposure],
    settings: &'x Settings<'x>,
    progress: &'x dyn Fn(),
}

impl Study<'_> {
    /// What each measurement would determine, the best first.
    fn all(&self, measured: &[Observation]) -> Result<Vec<Advice>> {
        let same_scenes = |measurement, observations: Vec<Observation>, noise| {
            self.advice(Plan { measurement, observations, exposures: self.exposures.to_vec(), noise })
        };
        let with = |change: &dyn Fn(&mut Observation, &PlannedExposure)| {
            let mut changed = measured.to_vec();
            changed.iter_mut().zip(self.exposures).for_each(|(o, e)| change(o, e));
            changed
        };
        let is_veil_free = |o: &Observation| matches!(o.veil, VeilTerm::Free(_));
        let mut all = vec![self.second_depth(measured)?, self.sharp_target(measured)?];
        all.push(same_scenes("half the noise (four times the exposure)", measured.to_vec(), HALF)?);
        if measured.iter().any(|o| o.gain == Gain::Free) {
            let known = with(&|o, e| o.gain = Gain::Fixed(e.exposure.gain));
            all.push(same_scenes("a known gain", known, 1.0)?);
            all.push(self.two_depths_at_once(measured)?);
        }
        if measured.iter().any(is_veil_free) {
            let known = with(&|o, e| {
                if is_veil_free(o) {
                    o.veil = VeilTerm::Fixed(e.exposure.veil.0[0]);
                }
            });
            all.push(same_scenes("a known veil", known, 1.0)?);
        }
        all.sort_by(|a, b| a.worst.total_cmp(&b.worst));
        Ok(all)
    }

    /// What `target` in place of that of `observation` would look like through the medium found.
    fn seen(&self, target: Target, observation: &Observation, scene: usize) -> Result<Image> {
        seen(target, observation, self.exposures[scene], &self.fit.parameters, self.settings, scene)
    }

    /// A further image of the first scene from half as far.
    fn second_depth(&self, measured: &[Observation]) -> Result<Advice> {
        let first = measured[0];
        let geometry = nearer(first.target.geometry);
        let relief = first.target.relief.map(|_| Relief::new(&geometry));
        let target = Target { geometry: &geometry, relief: relief.as_ref(), ..first.target };
        let observed = self.seen(target, &first, 0)?;
        let second = Observation { target, observed: &observed, ..first };
        self.advice(Plan {
            measurement: "a second scene at half the depth",
            observations: measured.iter().copied().chain([second]).collect(),
            exposures: self.exposures.iter().copied().chain([self.exposures[0]]).collect(),
            noise: 1.0,
        })
    }

    /// The first scene with the left half of its object half as far, in one exposure. The edge between them is as in eq. 29.
    fn two_depths_at_once(&self, measured: &[Observation]) -> Result<Advice> {
        let first = measured[0];
        let geometry = half_nearer(first.target.geometry);
        let target = Target { geometry: &geometry, relief: None, ..first.target };
        let observed = self.seen(target, &first, 0)?;
        let mut both = measured.to_vec();
        both[0] = Observation { target, observed: &observed, ..first };
        self.advice(Plan {
            measurement: "an object half of which is at half the depth, in one exposure",
            observations: both,
            exposures: self.exposures.to_vec(),
            noise: 1.0,
        })
    }

    /// The same scenes with sharp edges in place of what the object shows.
    fn sharp_target(&self, measured: &[Observation]) -> Result<Advice> {
        let checkers: Vec<Image> = measured.iter().map(|o| checker(o.target.radiance)).collect();
        let seen = |(scene, (o, radiance)): (usize, (&Observation, &Image))| {
            self.seen(Target { radiance, ..o.target }, o, scene)
        };
        let observed = measured.iter().zip(&checkers).enumerate().map(seen).collect::<Result<Vec<_>>>()?;
        let sharp = measured.iter().zip(&checkers).zip(&observed).map(|((o, radiance), observed)| {
            Observation { target: Target { radiance, ..o.target }, observed, ..*o }
        });
        self.advice(Plan {
            measurement: "a target of sharp edges (a checkerboard of the same mean)",
            observations: sharp.collect(),
            exposures: self.exposures.to_vec(),
            noise: 1.0,
        })
    }

    fn advice(&self, plan: Plan) -> Result<Advice> {
        let planned = Planned {
            observations: &plan.observations,
            exposures: &plan.exposures,
            unseen: &self.fit.unseen,
            variance_scale: self.fit.covariance.variance_scale() * plan.noise * plan.noise,
        };
        let parameters = self.fit.parameters.clone();
        let mut prospect = Prospect::new(&planned, parameters, self.settings, self.progress)?;
        if let Some(error) = &prospect.model_error {
            prospect.covariance.mark_undetermined(&prospect.parameters, |g| error.reference_of(g));
        }
        Ok(Advice::of(plan.measurement, &prospect))
    }
}

impl Advice {
    fn of(measurement: &'static str, prospect: &Prospect) -> Self {
        let Prospect { parameters, covariance, .. } = prospect;
        let error = |id: Id, p: &Parameter| covariance.std_error(id).map(|e| e * p.slope().abs());
        let in_scales =
            parameters.of_medium().filter_map(|(id, p)| Some(covariance.std_error(id)? / p.scale()));
        let frees = !covariance.leaves_open();
        Self {
            measurement,
            frees,
            std_errors: parameters.of_medium().map(|(id, p)| (p.name().into(), error(id, p))).collect(),
            known: known(parameters, error),
            worst: if frees { in_scales.fold(0.0, f64::max) } else { f64::INFINITY },
        }
    }

    /// What is reported of it for `channel`, one of `channels`.
    pub(super) fn report(&self, channel: &str, channels: usize) -> AdviceReport {
        AdviceReport {
            channel: channel.into(),
            measurement: self.measurement.into(),
            frees: self.frees,
            std_errors: self.std_errors.iter().cloned().collect(),
            message: self.line(&suffix(channel, channels)),
        }
    }

    /// A line for people; names of parameters end in `suffix`.
    fn line(&self, suffix: &str) -> String {
        let known: Vec<String> =
            self.known.iter().map(|text| text.replacen(' ', &format!("{suffix} "), 1)).collect();
        match (self.frees, known.is_empty()) {
            (true, _) => format!("{} would determine all: {}", self.measurement, known.join(", ")),
            (false, true) => format!("{} would determine nothing", self.measurement),
            (false, false) => format!("{} would not: only {}", self.measurement, known.join(", ")),
        }
    }
}

/// The parameters of the medium that have an `error`, as text.
fn known(parameters: &Parameters, error: impl Fn(Id, &Parameter) -> Option<f64>) -> Vec<String> {
    let text = |(id, parameter): (Id, &Parameter)| {
        let (error, name) = (error(id, parameter)?, parameter.name());
        Some(match parameter.is_logarithmic() {
            true => format!("{name} ± {:.2} %", 100.0 * error / parameter.value()),
            false => format!("{name} ± {error:.2e}"),
        })
    };
    parameters.of_medium().filter_map(text).collect()
}

/// `geometry` with its left half half as far.
fn half_nearer(far: &Geometry) -> Geometry {
    let near = nearer(far);
    let halves = |far_field: &Field, near: &Field| {
        Field::Map(Image::from_fn(far.width, far.height, |x, y| {
            (if 2 * x < far.width { near.at(x, y) } else { far_field.at(x, y) }) as f32
        }))
    };
    Geometry {
        depth: halves(&far.depth, &near.depth),
        surface: halves(&far.surface, &near.surface),
        behind: far.behind.iter().zip(&near.behind).map(|(far, near)| halves(far, near)).collect(),
        ..far.clone()
    }
}

/// Everything, the medium's surface too, at half its distance.
fn nearer(geometry: &Geometry) -> Geometry {
    let mut nearer = geometry.clone();
    for field in [&mut nearer.depth, &mut nearer.surface].into_iter().chain(&mut nearer.behind) {
        match field {
            Field::Uniform(distance) => *distance *= 0.5,
            // Beyond, a pixel is empty and has to stay so.
            Field::Map(map) => map
                .data
                .iter_mut()
                .filter(|distance| f64::from(**distance) <= FARTHEST)
                .for_each(|distance| *distance *= 0.5),
        }
    }
    nearer
}

/// A checkerboard of the mean radiance of `object`.
fn checker(object: &Image) -> Image {
    let mean = object.mean() as f32;
    Image::from_fn(object.width, object.height, |x, y| {
        if (x / CELL_PX + y / CELL_PX).is_multiple_of(2) { (2.0 - DARK) * mean } else { DARK * mean }
    })
}
