//! What a model is known to err, as images.
//!
//! The reference is the `wide-angle` model, whose own error is measured. The model `traced` has no such error; its paths are a
//! sample, which [`ModelError`](super::ModelError) looks at by batches.

use super::displacement::Displacement;
use crate::error::Result;
use crate::filter::Target;
use crate::fit::observation::{Observation, Unseen};
use crate::fit::parameters::Parameters;
use crate::forward::{Engine, Parts, Quantity};
use crate::image::{Border, Image, Sampling};
use crate::medium::Medium;
use crate::phase::{Family, PhaseFunction};
use crate::spread::Model;
use serde::{Deserialize, Serialize};

/// What every other model is measured against.
const REFERENCE: Model = Model::WideAngle;
/// The bias of a model is of first order: it predicts errors of up to 10 % to a quarter (tests/it/select.rs).
const MARGIN: f64 = 1.25;
/// Squared planar widths (rad², B of a Gaussian) of the phase functions for which the error of a model without a width is computed, where
/// none is given: the worst counts.
const SQUARED_WIDTHS: [f64; 3] = [1e-3, 1e-2, 5e-2];

/// Error of the reference's scattered total: over 40 random media the largest that stands out of the noise of fresh tracing is 0.17 %,
/// at tau 7.2, for the Gaussian (with `--ignored`); 0.3 % for Henyey-Greenstein's phase function (`cargo test --release --test it wide_angle:: -- --nocapture`).
fn reference_error(family: Family) -> f64 {
    match family {
        Family::Gaussian => 0.002,
        Family::HenyeyGreenstein => 0.003,
    }
}

/// Second difference of the kernel in ln B by which its shape may be off: of a kernel like a Gaussian that moves 0.3 % of the scattered light,
/// as much as the encircled energy of the reference is known to (same command).
const SHAPE_ERROR: f64 = 0.01;
/// Step of that difference.
const SHAPE_STEP: f64 = 0.25;

/// Error of the composite filter over the hidden share of a pixel: 0.9 on the near side of an edge, and up to 3 with the radiance of what is
/// hidden, which is not known (docs/composite.md).
const HIDDEN_ERROR: f32 = 3.0;

/// Error beside an edge over the share of light that is scattered before it; it falls with the distance in units of the kernel's width. For half
/// planes in a medium of tau 0.8 it is 3.4, 1.9, 0.9 and 0.4 % on the first four pixels at a width of 1.7 px (docs/composite.md).
const EDGE_ERROR: f64 = 0.08;

/// A part of a model's error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum ErrorSource {
    /// What the model leaves out of the reference.
    Model,
    /// What the reference itself errs: its table.
    Table,
    /// What lies between the pixels of the clear image, where that is not known.
    Sampling,
    /// What the filter errs beside edges, and what it does not know behind them.
    Composite,
    /// What is taken for the light from outside the clear image.
    Frame,
    /// The noise of traced paths.
    Paths,
    /// What faults that the residual shows have added.
    Residual,
}

impl ErrorSource {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Table => "table",
            Self::Sampling => "sampling",
            Self::Composite => "composite",
            Self::Frame => "frame",
            Self::Paths => "paths",
            Self::Residual => "residual",
        }
    }

    /// How it adds to an interval.
    pub(in crate::fit) fn kind(self) -> ErrorKind {
        match self {
            Self::Model | Self::Residual => ErrorKind::Bias,
            Self::Table | Self::Sampling | Self::Composite | Self::Frame => ErrorKind::Bound,
            Self::Paths => ErrorKind::Chance,
        }
    }

    /// What its first-order effect is multiplied with where it is stated.
    pub(super) fn margin(self) -> f64 {
        match self {
            Self::Model => MARGIN,
            _ => 1.0,
        }
    }
}

/// How an error adds to an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::fit) enum ErrorKind {
    /// Its size and sign are known: in full.
    Bias,
    /// Its largest size is known: in squares.
    Bound,
    /// Its standard deviation is known: 1.96 times, in squares.
    Chance,
}

/// By how much the object's light of each scene may be off, for each source.
#[derive(Debug, Clone)]
pub(crate) struct ErrorImages(pub(super) Vec<(ErrorSource, Vec<Image>)>);

impl ErrorImages {
    /// Those of scene number `scene`.
    pub(super) fn of_scene(&self, scene: usize) -> Vec<&Image> {
        self.0.iter().map(|(_, images)| &images[scene]).collect()
    }

    /// The second difference of the light of scene number `scene` in ln B or ln(1 - g).
    pub(super) fn shape(&self, scene: usize) -> Option<Image> {
        let mut tables = self.0.iter().filter(|(source, _)| *source == ErrorSource::Table);
        let image = &tables.nth(1)?.1[scene];
        Some(apart(image, &Image::filled(image.width, image.height, 0.0), 1.0 / SHAPE_ERROR as f32))
    }

    /// Those of the model of `fit`, which renders `light`, one set for each phase function that it may have; `None` where the
    /// reference has no kernels.
    pub(super) fn all(fit: &Displacement, light: &[Image]) -> Result<Option<Vec<Self>>> {
        let sampling = between_pixels(fit, light)?;
        let hidden = beside_edges(fit, light)?;
        let frame = beyond_the_frame(fit, light)?;
        let mut all = Vec::new();
        for phase in phases(fit.parameters) {
            let reference = match reference(fit, phase) {
                Err(error) if error.is_about_model() => return Ok(None),
                reference => reference?,
            };
            let share = reference_error(fit.parameters.family()) as f32;
            let each = |f: &dyn Fn(&Parts) -> Image| reference.iter().map(f).collect::<Vec<_>>();
            let model = reference.iter().zip(light).map(|(r, light)| apart(&r.whole, light, 1.0)).collect();
            let mut sources = vec![
                (ErrorSource::Model, model),
                (ErrorSource::Table, each(&|r| apart(&r.whole, &r.direct, share))),
                (ErrorSource::Table, each(&shape_error)),
            ];
            sources.extend(hidden.iter().map(|images| (ErrorSource::Composite, images.clone())));
            sources.extend(frame.iter().map(|images| (ErrorSource::Frame, images.clone())));
            sources.extend(sampling.clone().map(|images| (ErrorSource::Sampling, images)));
            all.push(Self(sources));
        }
        Ok(Some(all))
    }
}

/// The light of all scenes by the reference, with this parameter of the phase function, and with a wider and a narrower one.
fn reference(fit: &Displacement, phase: f64) -> Result<Vec<Parts>> {
    let engine = Engine { model: REFERENCE, ..fit.engine };
    let at = fit.parameters.with_phase(phase);
    let parameter = at.of(Quantity::Phase);
    let [least, most] = REFERENCE.range(fit.parameters.family())?.phase;
    let stepped = |step: f64| {
        fit.parameters.with_phase(parameter.value_at(parameter.coordinate() + step).clamp(least, most))
    };
    let (wider, narrower) = (stepped(SHAPE_STEP), stepped(-SHAPE_STEP));
    let parts = |(scene, o): (usize, &Observation)| {
        let others = [wider.state(scene)?, narrower.state(scene)?];
        engine.parts(o.target, &at.state(scene)?, &others)
    };
    fit.observations().enumerate().map(parts).collect()
}

/// What an error of the shape of the kernel may look like: part of the light is spread farther, part of it less.
fn shape_error(reference: &Parts) -> Image {
    let [wider, narrower] = &reference.others[..] else { unreachable!("two others were asked for") };
    let pixel = |i: usize| {
        let [w, n, r] = [wider, narrower, &reference.whole].map(|image| f64::from(image.data[i]));
        (SHAPE_ERROR * (w - 2.0 * r + n) / (SHAPE_STEP * SHAPE_STEP)) as f32
    };
    Image { data: (0..reference.whole.data.len()).map(pixel).collect(), ..reference.whole }
}

/// Light that the filter may err by beside edges, the same everywhere, or with either sign across or down the view. None where
/// nothing covers anything.
fn beside_edges(fit: &Displacement, light: &[Image]) -> Result<Vec<Vec<Image>>> {
    let covers = |o: &Observation| o.target.relief.is_some_and(|relief| !relief.occluders.is_empty());
    if !fit.observations().any(covers) {
        return Ok(Vec::new());
    }
    let medium = fit.parameters.medium()?;
    let share = |(o, unseen): (&Observation, &Unseen)| error_share(o, unseen.hidden.as_ref(), &medium);
    let shares: Vec<Image> = fit.observations().zip(fit.unseen).map(share).collect();
    let varied = |factor: fn([f32; 2]) -> f32| {
        let image = |(light, share): (&Image, &Image)| {
            let place = |i: usize, n: usize| 2.0 * (i as f32 + 0.5) / n as f32 - 1.0;
            Image::from_fn(light.width, light.height, |x, y| {
                let place = [place(x, light.width), place(y, light.height)];
                share.at(x, y) * light.at(x, y) * factor(place)
            })
        };
        light.iter().zip(&shares).map(image).collect()
    };
    Ok([varied(|_| 1.0), varied(|[x, _]| x), varied(|[_, y]| y)].into())
}

/// The share of each pixel's light by which the composite filter may err: by what is hidden, and by how near an edge is.
fn error_share(observation: &Observation, hidden: Option<&Image>, medium: &Medium) -> Image {
    let Target { geometry, view, relief, .. } = observation.target;
    let distances = relief.map_or_else(Vec::new, |relief| relief.edge_distances_px(geometry));
    let nearest = relief.and_then(|relief| relief.occluders.first()).map_or(1.0, |occluder| occluder.z);
    let scattered = 1.0 - (-medium.tau(nearest)).exp();
    let width_px = nearest * medium.phase().planar_width() / geometry.median_pixel_pitch();
    Image::from_fn(view.width, view.height, |x, y| {
        let at = (y + view.y) * geometry.width + x + view.x;
        let distance = distances.get(at).map_or(f64::INFINITY, |d| f64::from(*d));
        let beside = EDGE_ERROR * scattered * (-distance / width_px).exp();
        hidden.map_or(0.0, |share| HIDDEN_ERROR * share.at(x, y)) + beside as f32
    })
}

/// What light from outside the clear images may differ by from what is taken for it: by the difference to the outermost pixels
/// repeated, and, the same everywhere, by as much as the light varies over the view. None where all of it is known.
fn beyond_the_frame(fit: &Displacement, light: &[Image]) -> Result<Vec<Vec<Image>>> {
    if fit.unseen.iter().all(|unseen| unseen.outside.is_none()) {
        return Ok(Vec::new());
    }
    let (mut otherwise, mut varied) = (Vec::new(), Vec::new());
    for (scene, ((o, unseen), light)) in fit.observations().zip(fit.unseen).zip(light).enumerate() {
        let Some(outside) = &unseen.outside else {
            let nothing = Image::filled(light.width, light.height, 0.0);
            otherwise.push(nothing.clone());
            varied.push(nothing);
            continue;
        };
        let target = Target { border: Border::Clamp, ..o.target };
        let repeated = fit.engine.image(target, &fit.parameters.state(scene)?, scene, 1.0)?;
        otherwise.push(apart(&repeated, light, 1.0));
        let mean = light.mean();
        let square = light.data.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>();
        let spread = (square / light.data.len() as f64).sqrt() as f32;
        varied.push(Image { data: outside.data.iter().map(|share| share * spread).collect(), ..*light });
    }
    Ok(vec![otherwise, varied])
}

/// Half of what another sampling of the clear image would change, where it is not known; `None` if it is.
fn between_pixels(fit: &Displacement, light: &[Image]) -> Result<Option<Vec<Image>>> {
    if fit.observations().all(|o| o.sampling_is_known) {
        return Ok(None);
    }
    let change = |(scene, (o, light)): (usize, (&Observation, &Image))| {
        if o.sampling_is_known {
            return Ok(Image::filled(light.width, light.height, 0.0));
        }
        let sampling = match o.target.sampling {
            Sampling::Pixel => Sampling::Bandlimited,
            Sampling::Bandlimited => Sampling::Pixel,
        };
        let target = Target { sampling, ..o.target };
        let other = fit.engine.image(target, &fit.parameters.state(scene)?, scene, 1.0)?;
        Ok(apart(&other, light, 0.5))
    };
    fit.observations().zip(light).enumerate().map(change).collect::<Result<_>>().map(Some)
}

/// `share` of the difference between two images.
fn apart(a: &Image, b: &Image, share: f32) -> Image {
    let data = a.data.iter().zip(&b.data).map(|(a, b)| share * (a - b)).collect();
    Image { data, ..*a }
}

/// The phase-function parameters at which the error is looked at.
fn phases(parameters: &Parameters) -> Vec<f64> {
    let phase = parameters.of(Quantity::Phase);
    if !phase.is_absent() {
        return vec![phase.value()];
    }
    SQUARED_WIDTHS.map(|square: f64| parameters.family().of_width(square.sqrt())).to_vec()
}
