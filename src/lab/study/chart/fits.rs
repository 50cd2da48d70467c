//! Time against error of fits.

use super::dataset::Dataset;
use super::timing::{Effort, Timing};
use crate::filter::Backend;
use crate::fit::{Fit, SceneFit, Status, WarningCode};
use crate::forward::{Quantity, State};
use crate::lab::study::stability::Method;
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use crate::spread::Model;

/// One model, or the automatic choice of one, on one backend, and its result.
#[derive(Debug, Clone)]
pub struct FitTrial {
    /// Model and solver.
    pub method: Method,
    /// Name of the backend.
    pub backend: &'static str,
    /// How long it took, if there was a fit.
    pub time: Option<Timing>,
    /// The estimate, or why it is missing or incomplete.
    pub outcome: std::result::Result<Fitted, String>,
}

/// A fit that converged and determines everything, against the truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// The model that was fitted or chosen.
    pub model: String,
    /// Its filter.
    pub filter: String,
    /// Error of each parameter that was fitted, over the truth, of the channel where it is largest.
    pub errors: Vec<(Quantity, f64)>,
    /// The largest standard error of these, as relative.
    pub std_error: f64,
    /// Codes of warnings.
    pub warnings: Vec<WarningCode>,
}

impl Fitted {
    /// The largest error.
    pub fn error(&self) -> f64 {
        self.errors.iter().fold(0.0, |worst, (_, e)| e.abs().max(worst))
    }

    /// The error of `quantity`, if it was fitted.
    pub fn error_of(&self, quantity: Quantity) -> Option<f64> {
        self.errors.iter().find(|(of, _)| *of == quantity).map(|(_, error)| *error)
    }
}

/// The error of `value` relative to the truth; where the true sigma_a is 0, the error of sigma_a z. Of g it is relative to 1 - g.
pub(super) fn relative_error(quantity: Quantity, value: f64, truth: &Medium, z: f64) -> f64 {
    let true_value = State::from(*truth).value(quantity);
    let unit = match quantity {
        Quantity::SigmaA => scale(true_value, z),
        Quantity::Phase => truth.phase().family().slope(true_value).abs(),
        _ => true_value,
    };
    (value - true_value) / unit
}

/// The unit of the error of a parameter.
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
    let lost = fit.report.parameters.iter().filter(|(_, p)| p.status == Status::Undetermined);
    let lost: Vec<&str> = lost.map(|(name, _)| name.as_str()).collect();
    if !lost.is_empty() {
        return Err(format!("{} undetermined", lost.join(" and ")));
    }
    let mut errors: Vec<(Quantity, f64)> = Vec::new();
    let mut std_error = 0.0_f64;
    for (fit, truth) in channels() {
        for (id, parameter) in fit.parameters.of_medium() {
            let Some(spread) = fit.covariance.std_error(id) else { continue };
            let quantity = parameter.descriptor().quantity;
            let error = relative_error(quantity, parameter.value(), truth, set.z);
            match errors.iter_mut().find(|(of, _)| *of == quantity) {
                Some((_, worst)) if worst.abs() <= error.abs() => *worst = error,
                Some(_) => (),
                None => errors.push((quantity, error)),
            }
            let unit = if parameter.is_logarithmic() { 1.0 } else { scale(truth.sigma_a(), set.z) };
            std_error = std_error.max(spread / unit);
        }
    }
    let Fit { model, filter, warnings, .. } = fit.report.clone();
    let warnings = warnings.iter().map(|w| w.code).collect();
    Ok(Fitted { model, filter, errors, std_error, warnings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_relative_and_where_nothing_absorbs_counted_per_path() {
        let truth = Medium::gaussian(2.0, 0.5, 0.01).unwrap();
        let of = |values: [f64; 3], truth: &Medium| {
            let mut values = values.into_iter();
            Quantity::MEDIUM.map(|quantity| relative_error(quantity, values.next().unwrap(), truth, 3.0))
        };
        assert_eq!(of([2.0, 0.5, 0.01], &truth), [0.0; 3]);
        let [s, a, b] = of([1.0, 0.6, 0.02], &truth);
        assert!((s + 0.5).abs() < 1e-12 && (a - 0.2).abs() < 1e-12 && (b - 1.0).abs() < 1e-12);
        let clear = Medium::gaussian(2.0, 0.0, 0.01).unwrap();
        assert!((of([2.0, 0.01, 0.01], &clear)[1] - 0.03).abs() < 1e-12);
    }

    #[test]
    fn the_largest_error_counts_whatever_its_sign() {
        let fitted = |errors: &[f64]| Fitted {
            model: String::new(),
            filter: String::new(),
            errors: Quantity::MEDIUM.into_iter().zip(errors.iter().copied()).collect(),
            std_error: 0.0,
            warnings: Vec::new(),
        };
        assert_eq!(fitted(&[0.1, -0.3, 0.2]).error(), 0.3);
        assert_eq!(fitted(&[0.1]).error(), 0.1);
    }
}
