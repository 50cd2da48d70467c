//! What is reported of one model that was tried.

use crate::fit::inference::{ChannelFit, Status};
use crate::fit::report::Candidate;
use crate::fit::scenes::SceneFit;
use crate::spread::Model;

impl Candidate {
    /// Of the `fit` of `model`.
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
}

/// The medium's parameters, as far as determined.
fn estimates(fit: &ChannelFit) -> Vec<Option<f64>> {
    let known = |(id, parameter): (_, &crate::fit::Parameter)| {
        let there = !parameter.is_absent() && fit.covariance.status(id) != Status::Undetermined;
        there.then_some(parameter.value())
    };
    fit.parameters.of_medium().map(known).collect()
}
