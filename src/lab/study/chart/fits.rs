//! Time against error of fits.

use super::dataset::Dataset;
use super::timing::{Effort, Timing};
use crate::filter::Backend;
use crate::fit::scenes::SceneFit;
use crate::fit::{NAMES, Parameters, Status};
use crate::lab::study::stability::Method;
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use crate::spread::Model;

/// One model, or the automatic choice of one, on one backend, and what came of it.
#[derive(Debug, Clone)]
pub struct FitTrial {
    /// Model and solver.
    pub method: Method,
    /// Name of the backend.
    pub backend: &'static str,
    /// How long it took, if there was a fit.
    pub time: Option<Timing>,
    /// What was found, or why not all was.
    pub outcome: std::result::Result<Fitted, String>,
}

/// A fit that converged and determines everything, against the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// The model that was fitted or chosen.
    pub model: &'static str,
    /// Its filter.
    pub filter: &'static str,
    /// Error of sigma_s, sigma_a and B over the truth, of the channel where it is largest; `None` if
    /// it was not fitted.
    pub errors: [Option<f64>; 3],
    /// The largest standard error of these, as relative.
    pub std_error: f64,
    /// Codes of warnings.
    pub warnings: Vec<&'static str>,
}

impl Fitted {
    /// The largest error.
    pub fn error(&self) -> f64 {
        self.errors.iter().flatten().fold(0.0, |worst, e| e.abs().max(worst))
    }
}

/// Errors of sigma_s, sigma_a and B (`values`) relative to the truth; where that is no absorption, the error of sigma_a z. Of g
/// it is relative to 1 - g.
pub(super) fn relative_errors(values: [f64; 3], truth: &Medium, z: f64) -> [f64; 3] {
    let slope = truth.phase().family().slope(truth.phase().parameter());
    let scales = [truth.sigma_s(), scale(truth.sigma_a(), z), slope.abs()];
    let truth = truth.parameters();
    std::array::from_fn(|i| (values[i] - truth[i]) / scales[i])
}

/// What an error of a parameter is measured by.
fn scale(truth: f64, z: f64) -> f64 {
    if truth > 0.0 { truth } else { 1.0 / z }
}

/// All models, and the automatic choice.
fn methods() -> Vec<Method> {
    let models = Model::ALL.map(Method::of);
    models.into_iter().chain([Method::AUTO]).collect()
}

/// How many fits [`all`] makes.
pub(super) fn count(backends: usize) -> usize {
    methods().len() * backends
}

/// Fits `set` with every model on every backend; `tick` is called after each.
pub(super) fn all(set: &Dataset, backends: &[Backend], effort: &Effort, tick: &dyn Fn()) -> Vec<FitTrial> {
    let mut trials = Vec::new();
    for &backend in backends {
        for method in methods() {
            let (time, outcome) = match effort.time(|| method.fit(&set.observed, backend)) {
                Ok((fit, time)) => (Some(time), judge(&fit, set)),
                Err(error) => (None, Err(error.to_string())),
            };
            trials.push(FitTrial { method, backend: backend.name(), time, outcome });
            tick();
        }
    }
    trials
}

fn judge(fit: &SceneFit, set: &Dataset) -> std::result::Result<Fitted, String> {
    let channels = || fit.channels.iter().map(|(_, fit)| fit).zip(&set.truth);
    if channels().any(|(fit, _)| !fit.converged) {
        return Err("did not converge".into());
    }
    let lost = |i: &usize| channels().any(|(fit, _)| fit.uncertainty.status(*i) == Status::Undetermined);
    let lost: Vec<&str> = (0..3).filter(lost).map(|i| NAMES[i]).collect();
    if !lost.is_empty() {
        return Err(format!("{} undetermined", lost.join(" and ")));
    }
    let (mut errors, mut std_error) = ([None; 3], 0.0_f64);
    for (fit, truth) in channels() {
        let found = relative_errors(fit.parameters.values(), truth, set.z);
        for i in 0..3 {
            if let Some(spread) = fit.uncertainty.std_error(i) {
                errors[i] = [errors[i], Some(found[i])]
                    .into_iter()
                    .flatten()
                    .max_by(|a: &f64, b| a.abs().total_cmp(&b.abs()));
                let unit = if Parameters::is_logarithmic(i) { 1.0 } else { scale(truth.sigma_a(), set.z) };
                std_error = std_error.max(spread / unit);
            }
        }
    }
    let report = &fit.report;
    let warnings = report.warnings.iter().map(|w| w.code).collect();
    Ok(Fitted { model: report.model, filter: report.filter, errors, std_error, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_and_where_nothing_absorbs_counted_per_path() {
        let truth = Medium::gaussian(2.0, 0.5, 0.01).unwrap();
        assert_eq!(relative_errors([2.0, 0.5, 0.01], &truth, 3.0), [0.0; 3]);
        let [s, a, b] = relative_errors([1.0, 0.6, 0.02], &truth, 3.0);
        assert!((s + 0.5).abs() < 1e-12 && (a - 0.2).abs() < 1e-12 && (b - 1.0).abs() < 1e-12);
        let clear = Medium::gaussian(2.0, 0.0, 0.01).unwrap();
        assert!((relative_errors([2.0, 0.01, 0.01], &clear, 3.0)[1] - 0.03).abs() < 1e-12);
    }

    #[test]
    fn the_largest_error_counts_whatever_its_sign() {
        let fitted = |errors| Fitted { model: "", filter: "", errors, std_error: 0.0, warnings: Vec::new() };
        assert_eq!(fitted([Some(0.1), Some(-0.3), Some(0.2)]).error(), 0.3);
        assert_eq!(fitted([Some(0.1), None, None]).error(), 0.1);
    }
}
