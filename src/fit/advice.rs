//! Which measurement would free what the data leave undetermined: not guessed but reckoned, by the Fisher information that the
//! measurement would add at the medium found (see [`forecast`](super::forecast)).

use super::foresee::known_at;
use super::{ChannelFit, Datum, Exposure, NoiseTerm, Parameters, Settings, Status, VeilTerm, with_optics};
use crate::error::Result;
use crate::filter::Target;
use crate::geometry::{FARTHEST, Field, Geometry};
use crate::image::Image;
use crate::relief::Relief;
use crate::scene::Gain;
use crate::spread::Model;
use nalgebra::Vector3;
use serde::Serialize;

/// Cells of the target of sharp edges, px.
const CELL_PX: usize = 8;
/// Share of the light in its dark cells: prints are not black.
const DARK: f32 = 0.1;
/// Share of the noise that four exposures leave.
const HALF: f64 = 0.5;

/// A measurement, and what would be known with it if the medium is as estimated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Advice {
    /// What would be measured or known besides.
    pub measurement: &'static str,
    /// Whether every free parameter would be determined.
    pub frees: bool,
    /// Standard errors of sigma_s, sigma_a and B or g; `None` where fixed or still undetermined.
    pub std_errors: [Option<f64>; 3],
}

/// What would be fitted: scenes, the exposure of each, and the noise in units of today's.
struct Plan<'a> {
    measurement: &'static str,
    data: Vec<Datum<'a>>,
    exposures: Vec<Exposure>,
    noise: f64,
}

/// Tries what could be done besides `data`, whose `fit` leaves something undetermined; the best first. Empty if nothing is
/// undetermined, or the model sees direct light alone, to which no measurement adds.
///
/// For the model `traced` kernels of `wide-angle` stand in: it is the same light, and the noise of few paths would pass for want
/// of information. Empty where it has none.
///
/// # Errors
/// As [`fit_channel`](super::fit_channel).
pub fn advise(data: &[Datum], fit: &ChannelFit, settings: &Settings) -> Result<Vec<Advice>> {
    if !(fit.model.spreads() && (0..3).any(|i| fit.uncertainty.status(i) == Status::Undetermined)) {
        return Ok(Vec::new());
    }
    let traced = fit.model == Model::Traced;
    let model = if traced { Model::WideAngle } else { fit.model };
    match foreseen(data, fit, &Settings { model, ..*settings }) {
        Err(error) if traced && error.is_about_model() => Ok(Vec::new()),
        advice => advice,
    }
}

/// What each measurement would tell, the best first.
fn foreseen(data: &[Datum], fit: &ChannelFit, settings: &Settings) -> Result<Vec<Advice>> {
    let level = |e: &Exposure| Some(NoiseTerm::Level(e.noise));
    let measured: Vec<Datum> = data
        .iter()
        .zip(&fit.exposures)
        .map(|(d, e)| Datum { noise: d.noise.or_else(|| level(e)), ..*d })
        .collect();
    let same_scenes = |measurement, data: Vec<Datum>, noise| {
        let plan = Plan { measurement, data, exposures: fit.exposures.clone(), noise };
        plan.advice(fit, settings)
    };
    let with = |change: &dyn Fn(&mut Datum, &Exposure)| {
        let mut data = measured.clone();
        data.iter_mut().zip(&fit.exposures).for_each(|(d, e)| change(d, e));
        data
    };
    let mut all = vec![second_depth(&measured, fit, settings)?, sharp_target(&measured, fit, settings)?];
    all.push(same_scenes("half the noise (four times the exposure)", measured.clone(), HALF)?);
    if data.iter().any(|d| d.gain == Gain::Free) {
        let known = with(&|d, e| d.gain = Gain::Fixed(e.gain));
        all.push(same_scenes("a known gain", known, 1.0)?);
        all.push(two_depths_at_once(&measured, fit, settings)?);
    }
    if data.iter().any(|d| matches!(d.veil, VeilTerm::Free)) {
        let known = with(&|d, e| {
            if matches!(d.veil, VeilTerm::Free) {
                d.veil = VeilTerm::Fixed(e.veil);
            }
        });
        all.push(same_scenes("a known veil", known, 1.0)?);
    }
    let worst = |advice: &Advice| {
        let z = fit.median_z;
        let share = |i: usize| {
            advice.std_errors[i].map(|e| if i == 1 { e * z } else { e / fit.parameters.slope(i).abs() })
        };
        if advice.frees { (0..3).filter_map(share).fold(0.0, f64::max) } else { f64::INFINITY }
    };
    all.sort_by(|a, b| worst(a).total_cmp(&worst(b)));
    Ok(all)
}

/// A further image of the first scene from half as far.
fn second_depth(data: &[Datum], fit: &ChannelFit, settings: &Settings) -> Result<Advice> {
    let first = data[0];
    let geometry = nearer(first.target.geometry);
    let relief = first.target.relief.map(|_| Relief::new(&geometry));
    let target = Target { geometry: &geometry, relief: relief.as_ref(), ..first.target };
    let observed = seen(target, first.veil, &fit.exposures[0], &fit.parameters, settings)?;
    let second = Datum { target, observed: &observed, ..first };
    let plan = Plan {
        measurement: "a second scene at half the depth",
        data: data.iter().copied().chain([second]).collect(),
        exposures: fit.exposures.iter().copied().chain([fit.exposures[0]]).collect(),
        noise: 1.0,
    };
    plan.advice(fit, settings)
}

/// The first scene with the left half of its object half as far, in one exposure. The edge between them is as in eq. 29.
fn two_depths_at_once(data: &[Datum], fit: &ChannelFit, settings: &Settings) -> Result<Advice> {
    let first = data[0];
    let (far, near) = (first.target.geometry, nearer(first.target.geometry));
    let halves = |far: &Field, near: &Field| {
        Field::Map(Image::from_fn(first.target.radiance.width, first.target.radiance.height, |x, y| {
            let left = 2 * x < first.target.radiance.width;
            (if left { near.at(x, y) } else { far.at(x, y) }) as f32
        }))
    };
    let geometry = Geometry {
        depth: halves(&far.depth, &near.depth),
        surface: halves(&far.surface, &near.surface),
        behind: far.behind.iter().zip(&near.behind).map(|(far, near)| halves(far, near)).collect(),
        ..far.clone()
    };
    let target = Target { geometry: &geometry, relief: None, ..first.target };
    let observed = seen(target, first.veil, &fit.exposures[0], &fit.parameters, settings)?;
    let mut both = data.to_vec();
    both[0] = Datum { target, observed: &observed, ..first };
    let plan = Plan {
        measurement: "an object half of which is at half the depth, in one exposure",
        data: both,
        exposures: fit.exposures.clone(),
        noise: 1.0,
    };
    plan.advice(fit, settings)
}

/// The same scenes with sharp edges in place of what the object shows.
fn sharp_target(data: &[Datum], fit: &ChannelFit, settings: &Settings) -> Result<Advice> {
    let checkers: Vec<Image> = data.iter().map(|d| checker(d.target.radiance)).collect();
    let observed: Vec<Image> = data
        .iter()
        .zip(&checkers)
        .zip(&fit.exposures)
        .map(|((d, radiance), e)| seen(Target { radiance, ..d.target }, d.veil, e, &fit.parameters, settings))
        .collect::<Result<_>>()?;
    let sharp = data.iter().zip(&checkers).zip(&observed).map(|((d, radiance), observed)| Datum {
        target: Target { radiance, ..d.target },
        observed,
        ..*d
    });
    let plan = Plan {
        measurement: "a target of sharp edges (a checkerboard of the same mean)",
        data: sharp.collect(),
        exposures: fit.exposures.clone(),
        noise: 1.0,
    };
    plan.advice(fit, settings)
}

impl Plan<'_> {
    fn advice(self, fit: &ChannelFit, settings: &Settings) -> Result<Advice> {
        let Self { measurement, data, exposures, noise } = self;
        let parameters = &fit.parameters;
        let inflation = fit.uncertainty.inflation() * noise * noise;
        let scale = (fit.median_z, inflation);
        let (mut uncertainty, error) =
            known_at(&data, &exposures, &fit.hidden_shares, parameters, scale, settings)?;
        if let Some(error) = error {
            uncertainty.distrust(|i| error.reference_of(&Vector3::ith(i, 1.0)), fit.median_z);
        }
        let std_error = |i: usize| uncertainty.std_error(i).map(|e| e * parameters.slope(i).abs());
        let frees = (0..3).all(|i| uncertainty.status(i) != Status::Undetermined);
        Ok(Advice { measurement, frees, std_errors: std::array::from_fn(std_error) })
    }
}

impl Advice {
    /// A line for people; names of parameters end in `suffix`.
    pub(super) fn line(&self, parameters: &Parameters, suffix: &str) -> String {
        let names = parameters.names();
        let known = |i: usize| {
            let (error, value) = (self.std_errors[i]?, parameters.values()[i]);
            Some(if Parameters::is_logarithmic(i) {
                format!("{}{suffix} ± {:.2} %", names[i], 100.0 * error / value)
            } else {
                format!("{}{suffix} ± {error:.2e}", names[i])
            })
        };
        let known: Vec<String> = (0..3).filter_map(known).collect();
        match (self.frees, known.is_empty()) {
            (true, _) => format!("{} would determine all: {}", self.measurement, known.join(", ")),
            (false, true) => format!("{} would determine nothing", self.measurement),
            (false, false) => format!("{} would not: only {}", self.measurement, known.join(", ")),
        }
    }
}

/// What `target` would look like through the medium found.
fn seen(
    target: Target,
    veil: VeilTerm,
    exposure: &Exposure,
    parameters: &Parameters,
    settings: &Settings,
) -> Result<Image> {
    let image = with_optics(parameters, settings.model, |optics| {
        settings.backend.prepare(target, optics, 1.0)?.render(optics)
    })?;
    Ok(exposure.apply(image, veil))
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
