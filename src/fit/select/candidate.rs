//! One model that was tried.

use crate::fit::inference::{ChannelFit, Status};
use crate::fit::scenes::SceneFit;
use crate::spread::Model;
use serde::{Deserialize, Serialize};

/// One model that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Candidate {
    /// Its name.
    pub model: String,
    /// The medium's parameters of each channel, as far as determined; empty if the model was not fitted.
    pub estimates: Vec<Vec<Option<f64>>>,
    /// Root mean square error of a pixel by the model, in units of the noise, of the worst channel; `None` if not known.
    pub image_error: Option<f64>,
    /// Reduced chi² over all channels, of a fit.
    pub reduced_chi2: Option<f64>,
    /// Bayesian information criterion, over all channels, of a fit.
    pub bic: Option<f64>,
    /// Time that it took, seconds.
    pub seconds: f64,
    /// Why it does not suffice; `None` if it does.
    pub shortcoming: Option<String>,
    /// Whether it is the one that was taken.
    pub taken: bool,
}

impl Candidate {
    pub(super) fn new(model: Model, fit: &SceneFit) -> Self {
        let channels = || fit.channels.iter().map(|(_, fit)| fit);
        let errors = channels().map(|fit| fit.model_error.as_ref().map(|e| e.image));
        Self {
            estimates: channels().map(estimates).collect(),
            image_error: errors.collect::<Option<Vec<f64>>>().map(|e| e.into_iter().fold(0.0, f64::max)),
            reduced_chi2: Some(fit.report.fit.reduced_chi2),
            bic: Some(channels().map(ChannelFit::bic).sum()),
            seconds: fit.report.fit.seconds,
            shortcoming: None,
            ..Self::unfitted(model, String::new(), 0.0)
        }
    }

    /// Of a model that was not fitted, and why.
    pub(super) fn unfitted(model: Model, why: String, seconds: f64) -> Self {
        Self {
            model: model.name().into(),
            estimates: Vec::new(),
            image_error: None,
            reduced_chi2: None,
            bic: None,
            seconds,
            shortcoming: Some(why),
            taken: false,
        }
    }

    /// A line for people.
    pub fn line(&self) -> String {
        let outcome = match (&self.shortcoming, self.taken) {
            (None, _) => "suffices".to_string(),
            (Some(why), true) => format!("taken though {why}"),
            (Some(why), false) => why.clone(),
        };
        let fitted = self.reduced_chi2.map_or("not fitted".into(), |chi2| format!("reduced chi² {chi2:.4}"));
        format!("{:<15} {:>7.3} s   {fitted:<20} {outcome}", self.model, self.seconds)
    }
}

/// The medium's parameters, as far as determined.
fn estimates(fit: &ChannelFit) -> Vec<Option<f64>> {
    let known = |(id, parameter): (_, &crate::fit::Parameter)| {
        let there = !parameter.is_absent() && fit.covariance.status(id) != Status::Undetermined;
        there.then_some(parameter.value())
    };
    fit.parameters.of_medium().map(known).collect()
}
