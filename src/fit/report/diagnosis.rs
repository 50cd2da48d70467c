//! What the residual says of the scene, as users read it.

use super::Severity;
use super::number::significant;
use crate::fit::inference::{Cause, ChannelFit, ErrorSource, Finding, Status};
use crate::fit::parameters::Id;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// Standard errors by which a fault must have moved an estimate to matter.
const MOVED: f64 = 1.0;
/// The same, from which on the image contradicts the scene, if it is also the share [`FAR`] of the value.
const CONTRADICTS: f64 = 4.0;
/// Share of a value; of sigma_a, of 0.1/z if that is more.
const FAR: f64 = 0.1;

/// How serious a `finding` is for `fit`.
pub(super) fn severity(finding: &Finding, fit: &ChannelFit) -> Severity {
    match finding.cause {
        Cause::Saturation => Severity::Caution,
        Cause::CorrelatedNoise | Cause::NoiseModel => Severity::Note,
        _ => {
            let moves = fit.with_status(Status::Free).map(|id| moved(finding, fit, id));
            let of_one = |[errors, share]: [f64; 2]| match errors {
                e if e > CONTRADICTS && share > FAR => Severity::Invalid,
                e if e > MOVED => Severity::Caution,
                _ => Severity::Note,
            };
            moves.map(of_one).max().unwrap_or(Severity::Note)
        }
    }
}

/// How far `finding` has moved the parameter `id` of `fit`: in standard errors of all that is stated else, and as a share of the value.
fn moved(finding: &Finding, fit: &ChannelFit, id: Id) -> [f64; 2] {
    let (parameter, along) = (fit.parameters.get(id), fit.parameters.along(id));
    let stated = fit.model_errors(&along).into_iter().filter(|(source, _)| *source != ErrorSource::Residual);
    let model: f64 = stated.map(|(_, error)| error * error).sum();
    let error = (fit.variance_of(&along).unwrap_or(f64::INFINITY) + model).sqrt();
    let bias = finding.bias.dot(&along).abs();
    let size = if parameter.is_logarithmic() { 1.0 } else { parameter.value().max(0.1 * parameter.scale()) };
    [bias / error, bias / size]
}

/// A cause that the residual speaks of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct DiagnosisReport {
    /// The cause.
    pub cause: Cause,
    /// Others that the image cannot tell from it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<Cause>,
    /// Number of the scene, from 0.
    pub scene: usize,
    /// The channel.
    pub channel: String,
    /// How large it is, in `unit`.
    pub amplitude: f64,
    /// Standard error of that.
    pub std_error: f64,
    /// Unit of both.
    pub unit: String,
    /// Drop of chi² if it were fitted along.
    pub delta_chi2: f64,
    /// Standard deviations by which that exceeds what noise does.
    pub significance: f64,
    /// How serious it is.
    pub severity: Severity,
    /// What it has added to each estimate, to first order.
    pub bias: IndexMap<String, f64>,
    /// What can be done.
    pub advice: String,
}

impl DiagnosisReport {
    /// Of a `finding` in the `fit` of `channel`, whose names of parameters end in `suffix`.
    pub(super) fn new(finding: &Finding, fit: &ChannelFit, channel: &str, suffix: &str) -> Self {
        let bias = fit.with_status(Status::Free).map(|id| {
            let parameter = fit.parameters.get(id);
            let bias = parameter.slope() * finding.bias.dot(&fit.parameters.along(id));
            (format!("{}{suffix}", parameter.name()), bias)
        });
        Self {
            cause: finding.cause,
            alternatives: finding.alternatives.clone(),
            scene: finding.scene,
            channel: channel.into(),
            amplitude: finding.amplitude,
            std_error: finding.std_error,
            unit: finding.cause.unit().into(),
            delta_chi2: finding.delta_chi2,
            significance: finding.significance,
            severity: severity(finding, fit),
            bias: bias.collect(),
            advice: finding.cause.advice().into(),
        }
    }

    /// A line for people.
    pub fn line(&self) -> String {
        let Self { cause, amplitude, std_error, unit, delta_chi2, .. } = self;
        let others: String = self.alternatives.iter().map(|other| format!(" or {other}")).collect();
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        format!(
            "the residual shows {cause}{others}: {} ± {}{unit} (chi² would drop by {delta_chi2:.0}); {}",
            significant(*amplitude),
            significant(*std_error),
            self.advice
        )
    }
}
