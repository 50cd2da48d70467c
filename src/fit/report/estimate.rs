//! One parameter of one channel.

use crate::fit::inference::{ChannelFit, ErrorKind, Status, Z95};
use crate::fit::parameters::{Id, Role};
use indexmap::IndexMap;
use serde::{Deserialize, Deserializer, Serialize};

/// One parameter of one channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Estimate {
    /// The estimate; the last value tried if undetermined; absent if the model does not have this parameter.
    pub value: Option<f64>,
    /// Standard error from the noise.
    pub std_error: Option<f64>,
    /// The same over the value.
    pub relative_error: Option<f64>,
    /// Error of the model itself at this scene, [`ModelError`](crate::fit::ModelError); null where it is not known.
    pub model_error: Option<f64>,
    /// Its parts by source, whose root sum of squares it is.
    pub model_errors: IndexMap<String, f64>,
    /// Standard error by what is said of depths and gains.
    pub input_error: Option<f64>,
    /// 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Free, fixed, undetermined or doubtful.
    pub status: Status,
    /// Where the fit began.
    pub start: Option<f64>,
    /// 95 % interval by profile likelihood, if it was asked for; null if fixed. An end is null where the data leave it open.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    pub profile95: Option<Option<[Option<f64>; 2]>>,
    /// The same by bootstrap.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
    pub bootstrap95: Option<Option<[Option<f64>; 2]>>,
}

/// Further ways to 95 % intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ways {
    /// Profile likelihood.
    Profile,
    /// Parametric bootstrap.
    Bootstrap,
}

/// A value that is there, even if null.
fn present<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

impl Estimate {
    /// What `fit` says of the parameter `id`.
    pub(super) fn new(fit: &ChannelFit, id: Id) -> Self {
        let parameter = fit.parameters.get(id);
        let along = fit.parameters.along(id);
        let (value, slope) = (parameter.value(), parameter.slope().abs());
        let status =
            if parameter.descriptor().role == Role::Free { fit.covariance.status(id) } else { Status::Fixed };
        let error = fit.covariance.std_error(id);
        let input_error = error.map(|_| fit.input_error.variance_of(&along).sqrt());
        let model_errors = error.map_or_else(Vec::new, |_| fit.model_errors(&along));
        let whole = model_errors.iter().map(|(_, e)| e * e).sum::<f64>().sqrt();
        let model_error = error.and(fit.model_error.as_ref()).map(|_| whole);
        let interval = |e: f64| {
            let [low, high] = parameter.bounds();
            // Chance and bounds of unknown sign add in squares; what is known to be off adds in full.
            let [mut square, mut known] =
                [(Z95 * e).powi(2) + (Z95 * input_error.unwrap_or(0.0)).powi(2), 0.0];
            for (source, error) in &model_errors {
                match source.kind() {
                    ErrorKind::Bias => known += error,
                    ErrorKind::Bound => square += error * error,
                    ErrorKind::Chance => square += (Z95 * error).powi(2),
                }
            }
            let half = square.sqrt() + known;
            let u = parameter.coordinate();
            let [a, b] = [u - half, u + half].map(|u| parameter.value_at(u));
            [a.min(b).max(low).min(value), a.max(b).min(high).max(value)]
        };
        let ci95 = error.map(interval);
        let there = |value: f64| (!parameter.is_absent()).then_some(value);
        Self {
            value: there(value),
            std_error: fit.std_error(parameter.name()),
            relative_error: error.filter(|_| value > 0.0).map(|e| e * (slope / value)),
            model_error: model_error.map(|e| e * slope),
            model_errors: model_errors
                .into_iter()
                .map(|(source, e)| (source.name().into(), e * slope))
                .collect(),
            input_error: input_error.map(|e| e * slope),
            ci95,
            status,
            start: there(fit.start[parameter.name()].value()),
            profile95: None,
            bootstrap95: None,
        }
    }

    /// Says that the image contradicts the scene.
    pub(super) fn doubt(&mut self) {
        if self.status == Status::Free {
            (self.status, self.ci95) = (Status::Doubtful, None);
        }
    }
}
