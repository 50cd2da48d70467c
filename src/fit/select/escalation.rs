//! Where the filter is the weak link, paths that meet the real surfaces take its place.
//!
//! The composite filter errs beside edges. Where all that near surfaces cover is known, pixels beside edges count, and that error may decide a
//! fit. The model `traced` has no such error; it is slow, and how slow is found out first. Where something is hidden that no image shows,
//! neither knows it, and the filter's fit stands.

use crate::error::Result;
use crate::filter::Filter;
use crate::fit::Settings;
use crate::fit::inference::{ChannelFit, ErrorSource, Status};
use crate::fit::report::Candidate;
use crate::fit::scenes::{SceneFit, fit_scenes, observations, reliefs};
use crate::forward::State;
use crate::image::Sampling;
use crate::scene::ObservedScene;
use crate::spread::Model;

/// Time of a fit over that of tracing its paths once: it seeks the medium with fewer, and evaluates them some ten times.
const FIT_OVER_TRACING: f64 = 2.0;
/// Share of reduced chi² by which the fit by paths must be better.
const BETTER: f64 = 0.98;

/// Whether the filter's error decides the `fit` of `scenes`, to within the relative error `tolerance`, and paths would not have it.
pub fn filter_is_weak(fit: &SceneFit, scenes: &[ObservedScene], tolerance: f64) -> bool {
    let traceable = |s: &ObservedScene| !s.observation.frees_camera() && s.scene.sampling == Sampling::Pixel;
    let all_known = !fit.hides() && scenes.iter().all(traceable);
    all_known && fit.channels.iter().any(|(_, channel)| decides(channel, tolerance))
}

fn decides(fit: &ChannelFit, tolerance: f64) -> bool {
    let of_filter = |id| {
        let parts = fit.model_errors(&fit.parameters.along(id));
        parts.iter().find(|(source, _)| *source == ErrorSource::Composite).map_or(0.0, |(_, error)| *error)
    };
    fit.with_status(Status::Free).any(|id| {
        let parameter = fit.parameters.get(id);
        let size = if parameter.is_logarithmic() { 1.0 } else { parameter.value() };
        let noise = fit.covariance.std_error(id).unwrap_or(f64::INFINITY);
        of_filter(id) > (tolerance * size).max(noise)
    })
}

/// Seconds that [`trace_instead`] takes, to a factor of two.
///
/// # Errors
/// Those of a render by `traced`.
pub fn tracing_seconds(scenes: &[ObservedScene], settings: &Settings, fit: &SceneFit) -> Result<f64> {
    let reliefs = reliefs(scenes, Filter::Composite);
    let mut seconds = 0.0;
    for (i, (_, channel)) in fit.channels.iter().enumerate() {
        let state = State::from(channel.parameters.medium()?);
        for observation in observations(scenes, &reliefs, i) {
            seconds += FIT_OVER_TRACING * settings.engine().tracing_seconds(observation.target, &state)?;
        }
    }
    Ok(seconds)
}

/// The fit by `traced`, if it describes the images better than `fit`, else `fit`; with both in the report.
///
/// # Errors
/// As [`fit_scenes`].
pub fn trace_instead(
    scenes: &[ObservedScene],
    settings: &Settings,
    filter: Filter,
    mut fit: SceneFit,
    progress: &dyn Fn(),
) -> Result<SceneFit> {
    let mut traced = fit_scenes(scenes, &Settings { model: Model::Traced, ..*settings }, filter, progress)?;
    let mut candidate = Candidate::new(Model::Traced, &traced);
    let mut candidates = std::mem::take(&mut fit.report.candidates);
    let is_better =
        traced.report.fit.converged && traced.report.fit.reduced_chi2 < BETTER * fit.report.fit.reduced_chi2;
    if is_better {
        let weak = "the filter's error beside edges decides";
        let taken = candidates.iter_mut().find(|candidate| candidate.taken);
        if let Some(before) = taken {
            (before.taken, before.shortcoming) = (false, Some(weak.into()));
        }
        candidate.taken = true;
    } else {
        candidate.shortcoming = Some("no better than the filter".into());
    }
    candidates.push(candidate);
    let chosen = if is_better { &mut traced } else { &mut fit };
    chosen.report.candidates = candidates;
    Ok(if is_better { traced } else { fit })
}

/// Adds to the report of `fit` that tracing was left out, since it takes `seconds`.
pub fn leave_out_tracing(fit: &mut SceneFit, seconds: f64) {
    let why = format!("the filter's error beside edges decides, but tracing takes about {seconds:.0} s");
    fit.report.candidates.push(Candidate::unfitted(Model::Traced, why, 0.0));
}
