//! No more camera than an image asks for: what a scene leaves open is freed one by one, the largest drop of chi² first.
//!
//! A scene may leave registration, blur, gain field and veil to the fit ([`Choice::Auto`]). The fit begins with the least of each. Where
//! the residual speaks of a cause that one of them answers, that one is freed, one kind at a time, and the fit is made again. An
//! observation that lies pixels off, or is turned by degrees, has a residual that no first order describes: where the residual is
//! no noise, it is first looked where the observation lies. At last, what was freed and came out as nothing is taken back.

use crate::error::Result;
use crate::filter::{coarse_shift, coarse_similarity};
use crate::fit::inference::{Cause, ChannelFit, Finding};
use crate::fit::report::CameraStep;
use crate::fit::scenes::SceneFit;
use crate::forward::Quantity;
use crate::imaging::{Blur, Choice, GainField, Registration, VeilField, WarpParameter};
use crate::scene::{Observation, ObservedScene, Veil};
use std::time::Instant;

/// Freed at most.
const MOST_STEPS: usize = 12;
/// How far an observation lies off, px, or is turned or scaled at the corners of its view, before that is looked at first.
const FAR_PX: f64 = 0.6;
/// What a camera can be freed for, and what comes of a camera that is not free yet.
const ANSWERED: [Cause; 8] = [
    Cause::Shift,
    Cause::Rotation,
    Cause::Scale,
    Cause::Blur,
    Cause::GainField,
    Cause::Veil,
    Cause::OutsideLight,
    Cause::Sampling,
];
/// Share of the mean square residual that may be left if an observation lies where it is seen.
const SEEN: f64 = 0.7;
/// Standard errors from 0 within which what was freed is nothing.
const NOTHING: f64 = 2.5;

/// What a scene leaves to the fit.
#[derive(Debug, Clone, Copy)]
struct Open {
    registration: bool,
    blur: bool,
    gain_field: bool,
    veil: bool,
}

impl Open {
    fn of(observation: &Observation) -> Self {
        Self {
            registration: observation.registration.is_auto(),
            blur: observation.blur.is_auto(),
            gain_field: observation.gain_field.is_auto(),
            veil: observation.veil == Veil::Auto,
        }
    }

    fn any(self) -> bool {
        self.registration || self.blur || self.gain_field || self.veil
    }
}

/// Fits `scenes` by `fit`, and frees what they leave open as far as their images ask for it: that is in `scenes` afterwards, and the
/// steps are in the report. Between the first fit and the last, `probe` fits.
///
/// # Errors
/// Those of `fit` and `probe`.
pub fn free_camera(
    scenes: &mut [ObservedScene],
    mut fit: impl FnMut(&[ObservedScene]) -> Result<SceneFit>,
    mut probe: impl FnMut(&[ObservedScene]) -> Result<SceneFit>,
) -> Result<SceneFit> {
    let mut open: Vec<Open> = scenes.iter().map(|scene| Open::of(&scene.observation)).collect();
    let mut found = fit(scenes)?;
    if !open.iter().any(|open| open.any()) {
        return Ok(found);
    }
    let mut steps = seen_first(&mut found, scenes, &open, &mut probe)?;
    let untested = freed_untested(scenes, &open);
    if !untested.is_empty() {
        steps.extend(untested);
        found = probed(&mut steps, scenes, &mut probe)?;
    }
    // Whether `found` is a fit by the model that is taken, of the scenes as they are now.
    let mut is_whole = steps.is_empty();
    loop {
        while steps.len() < MOST_STEPS
            && let Some(step) = asked(&found, scenes, &open)
        {
            steps.push(step);
            found = probed(&mut steps, scenes, &mut probe)?;
            is_whole = false;
        }
        if is_whole {
            found.report.camera = steps;
            return Ok(found);
        }
        steps.extend(taken_back(&found, scenes, &mut open));
        found = fit(scenes)?;
        is_whole = true;
    }
}

/// A fit after a step, whose outcome the last of `steps` gets.
fn probed(
    steps: &mut [CameraStep],
    scenes: &[ObservedScene],
    probe: &mut impl FnMut(&[ObservedScene]) -> Result<SceneFit>,
) -> Result<SceneFit> {
    let clock = Instant::now();
    let found = probe(scenes)?;
    if let Some(step) = steps.last_mut() {
        step.reduced_chi2 = Some(found.report.fit.reduced_chi2);
        step.seconds = clock.elapsed().as_secs_f64();
    }
    Ok(found)
}

/// Frees what the residual is not asked about, since the noise of a clear image would pass for it: a blur, and a gain that falls off. What
/// comes out as nothing is taken back.
fn freed_untested(scenes: &mut [ObservedScene], open: &[Open]) -> Vec<CameraStep> {
    let mut steps = Vec::new();
    for (i, scene) in scenes.iter_mut().enumerate().filter(|(_, scene)| scene.scene.object_noise.is_some()) {
        for (cause, is_open) in [(Cause::Blur, open[i].blur), (Cause::GainField, open[i].gain_field)] {
            let key = if is_open { freed(cause, &mut scene.observation, open[i]) } else { None };
            steps.extend(key.map(|key| CameraStep::new(i, key, cause, None)));
        }
    }
    steps
}

/// Mean square residual over all scenes and channels.
fn mean_square(fit: &SceneFit) -> f64 {
    let all = || fit.channels.iter().flat_map(|(_, channel)| &channel.exposures);
    let pixels: usize = all().map(|e| e.pixels).sum();
    all().map(|e| e.chi2 * e.noise * e.noise).sum::<f64>() / pixels.max(1) as f64
}

/// Registers what lies far off where it is seen, if the residual of `fit` is not noise; `fit` is the one that follows. What is seen may be
/// wrong, where a texture repeats itself or another fault has made the residual: it counts if it explains a good part of that.
fn seen_first(
    fit: &mut SceneFit,
    scenes: &mut [ObservedScene],
    open: &[Open],
    probe: &mut impl FnMut(&[ObservedScene]) -> Result<SceneFit>,
) -> Result<Vec<CameraStep>> {
    let mut steps = Vec::new();
    for i in 0..scenes.len() {
        for (registration, cause) in seen(fit, i, &scenes[i], open[i]) {
            let before = scenes[i].observation.registration;
            scenes[i].observation.registration = Choice::Is(registration);
            let clock = Instant::now();
            let found = probe(scenes)?;
            if mean_square(&found) > SEEN * mean_square(fit) {
                scenes[i].observation.registration = before;
                continue;
            }
            *fit = found;
            let key = format!("registration = \"{}\"", registration.name());
            let mut step = CameraStep::new(i, key, cause, None);
            (step.reduced_chi2, step.seconds) =
                (Some(fit.report.fit.reduced_chi2), clock.elapsed().as_secs_f64());
            steps.push(step);
        }
    }
    Ok(steps)
}

/// The registrations for which scene number `i` looks to lie far off, the simplest first; none if the residual of `fit` is noise.
fn seen(fit: &SceneFit, i: usize, scene: &ObservedScene, open: Open) -> Vec<(Registration, Cause)> {
    let speaks = |finding: &Finding| finding.scene == i && !finding.cause.is_of_noise();
    let is_odd =
        |(_, channel): &(String, ChannelFit)| channel.findings.iter().any(speaks) || channel.lacks_fit();
    if !open.registration || !fit.channels.iter().any(is_odd) {
        return Vec::new();
    }
    let clear = scene.scene.object[0].image.crop(scene.scene.view);
    let (observed, mask) = (&scene.observation.image[0].image, scene.observation.mask.as_ref());
    let (warp, _) = coarse_similarity(&clear, observed, mask);
    let shift_px = coarse_shift(&clear, observed, mask);
    let half_px = 0.5 * (clear.width as f64).hypot(clear.height as f64);
    let bent = [WarpParameter::Rotation, WarpParameter::LogScale].map(|p| warp.get(p).abs() * half_px);
    let shifted = (shift_px[0].hypot(shift_px[1]) > FAR_PX).then_some((Registration::Shift, Cause::Shift));
    let turned = (bent[0].max(bent[1]) > 2.0 * FAR_PX).then_some((Registration::Similarity, Cause::Rotation));
    shifted.into_iter().chain(turned).collect()
}

/// Frees what answers the cause with the largest drop of chi²; `None` if nothing that is open does.
fn asked(fit: &SceneFit, scenes: &mut [ObservedScene], open: &[Open]) -> Option<CameraStep> {
    let all = fit.channels.iter().flat_map(|(_, channel)| &channel.findings);
    let mut findings: Vec<&Finding> = all.filter(|finding| !finding.cause.is_of_noise()).collect();
    findings.sort_by(|a, b| b.delta_chi2.total_cmp(&a.delta_chi2));
    let mut told = vec![true; scenes.len()];
    findings.into_iter().find_map(|finding| {
        let (scene, open) = (&mut scenes[finding.scene].observation, open[finding.scene]);
        // What nothing answers is left for the user to see: something else that looks like it would only hide it.
        told[finding.scene] &= ANSWERED.contains(&finding.cause)
            && finding.alternatives.iter().all(|other| ANSWERED.contains(other));
        if !told[finding.scene] {
            return None;
        }
        let key = freed(finding.cause, scene, open)?;
        Some(CameraStep::new(finding.scene, key, finding.cause, Some(finding.delta_chi2)))
    })
}

/// Frees the next kind of what answers `cause` in `observation`, and returns the key with its value; `None` if nothing open does.
fn freed(cause: Cause, observation: &mut Observation, open: Open) -> Option<String> {
    match cause {
        Cause::Shift | Cause::Rotation | Cause::Scale if open.registration => {
            let least = if cause == Cause::Shift { Registration::Shift } else { Registration::Similarity };
            let now = observation.registration.least();
            let next = Registration::ALL.into_iter().find(|kind| *kind > now && *kind >= least)?;
            observation.registration = Choice::Is(next);
            Some(format!("registration = \"{}\"", next.name()))
        }
        Cause::Blur if open.blur && observation.blur.least() != Blur::Free => {
            observation.blur = Choice::Is(Blur::Free);
            Some("blur_px = \"free\"".into())
        }
        Cause::GainField if open.gain_field => {
            let now = observation.gain_field.least();
            let next = GainField::ALL.into_iter().find(|kind| *kind > now)?;
            observation.gain_field = Choice::Is(next);
            Some(format!("gain_field = \"{}\"", next.name()))
        }
        Cause::Veil if open.veil => {
            let next = match observation.veil {
                Veil::Auto => VeilField::Constant,
                Veil::Free(now) => VeilField::ALL.into_iter().find(|kind| *kind > now)?,
                _ => return None,
            };
            observation.veil = Veil::Free(next);
            Some(format!("veil = \"{}\"", if next == VeilField::Constant { "free" } else { next.name() }))
        }
        _ => None,
    }
}

/// Takes back what was freed and came out as nothing in every channel.
fn taken_back(fit: &SceneFit, scenes: &mut [ObservedScene], open: &mut [Open]) -> Vec<CameraStep> {
    let mut steps = Vec::new();
    for (i, scene) in scenes.iter_mut().enumerate() {
        let observation = &mut scene.observation;
        let is_nothing = |quantities: &[Quantity]| {
            fit.channels.iter().all(|(_, channel)| {
                let mut mine = channel.parameters.of_scene(i);
                mine.all(|(id, p)| {
                    let error = channel.covariance.std_error(id).unwrap_or(f64::INFINITY);
                    !quantities.contains(&p.descriptor().quantity) || p.value().abs() < NOTHING * error
                })
            })
        };
        if open[i].blur && observation.blur.least() == Blur::Free && is_nothing(&[Quantity::Blur]) {
            (observation.blur, open[i].blur) = (Choice::Is(Blur::default()), false);
            steps.push(CameraStep::new(i, "blur_px = 0".into(), Cause::Blur, None));
        }
        if open[i].gain_field
            && observation.gain_field.least() == GainField::Radial
            && is_nothing(&[Quantity::GainRadial])
        {
            (observation.gain_field, open[i].gain_field) = (Choice::Is(GainField::None), false);
            steps.push(CameraStep::new(i, "gain_field = \"none\"".into(), Cause::GainField, None));
        }
    }
    steps
}
