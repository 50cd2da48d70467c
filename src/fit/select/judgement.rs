//! What speaks against a model.

use super::prospect::Prospect;
use crate::fit::inference::{Covariance, ModelError, Status};
use crate::fit::parameters::{Parameter, Parameters};
use crate::fit::scenes::SceneFit;
use crate::phase::Family;
use crate::spread::Model;

/// Standard deviations of chi² by which a residual exceeds its expectation before it counts as more than noise.
const EXCESS: f64 = 5.0;

/// What speaks against a model.
pub(super) enum Judgement {
    Suffices,
    /// Only that the residual holds more than noise.
    Misfit(String),
    /// Only that the data do not determine everything.
    Undetermined(String),
    Fails(String),
}

/// What speaks against the `fit` of `model`, over all channels: the worst.
pub(super) fn of_fit(fit: &SceneFit, model: Model, tolerance: f64) -> Judgement {
    let (mut misfit, mut undetermined) = (None, None);
    for (_, fit) in &fit.channels {
        if !fit.converged {
            return Judgement::Fails("the fit did not converge".into());
        }
        let known = Known {
            parameters: &fit.parameters,
            covariance: &fit.covariance,
            model_error: fit.model_error.as_ref(),
        };
        match known.judge(model, tolerance) {
            Judgement::Undetermined(why) => undetermined = Some(why),
            Judgement::Suffices => (),
            other => return other,
        }
        let freedom = fit.pixels.saturating_sub(fit.fitted).max(1) as f64;
        if fit.reduced_chi2 > 1.0 + EXCESS * (2.0 / freedom).sqrt() {
            misfit = Some(format!("the residual is more than noise, reduced chi² {:.3}", fit.reduced_chi2));
        }
    }
    match (undetermined, misfit) {
        (Some(why), _) => Judgement::Undetermined(why),
        (None, Some(why)) => Judgement::Misfit(why),
        (None, None) => Judgement::Suffices,
    }
}

/// What errors and uncertainty of `prospect` say of `model`.
pub(super) fn of_prospect(prospect: &Prospect, model: Model, tolerance: f64) -> Judgement {
    let Prospect { parameters, covariance, model_error } = prospect;
    Known { parameters, covariance, model_error: model_error.as_ref() }.judge(model, tolerance)
}

/// What is known at a medium.
struct Known<'a> {
    parameters: &'a Parameters,
    covariance: &'a Covariance,
    model_error: Option<&'a ModelError>,
}

impl<'a> Known<'a> {
    fn judge(&self, model: Model, tolerance: f64) -> Judgement {
        let lost: Vec<&str> = self.of_status(Status::Undetermined).map(|(_, p)| p.name()).collect();
        let undetermined = format!("{} undetermined", lost.join(" and "));
        if !lost.is_empty() && !model.spreads() {
            return Judgement::Fails(undetermined);
        }
        let Some(error) = self.model_error else {
            return Judgement::Fails("its error here is not known".into());
        };
        for (id, parameter) in self.of_status(Status::Free) {
            let noise = self.covariance.std_error(id).unwrap_or(f64::INFINITY);
            let value = if parameter.is_logarithmic() { 1.0 } else { parameter.value() };
            let bias = error.bias_of(&self.parameters.along(id)).abs();
            if bias > (tolerance * value).max(0.5 * noise) {
                let share = if value > 0.0 { 100.0 * bias / value } else { f64::INFINITY };
                return Judgement::Fails(format!("{} off by {share:.2} %", self.relative_name(parameter)));
            }
        }
        if error.image > 1.0 {
            return Judgement::Fails(format!("off by {:.1} times the noise of a pixel", error.image));
        }
        if lost.is_empty() { Judgement::Suffices } else { Judgement::Undetermined(undetermined) }
    }

    /// The medium's parameters of this status.
    fn of_status(&self, status: Status) -> impl Iterator<Item = (crate::fit::parameters::Id, &'a Parameter)> {
        self.parameters.of_medium().filter(move |(id, _)| self.covariance.status(*id) == status)
    }

    /// The name of what an error of its coordinate is relative to.
    fn relative_name<'p>(&self, parameter: &'p Parameter) -> &'p str {
        match self.parameters.family() {
            Family::HenyeyGreenstein if parameter.name() == Family::HenyeyGreenstein.parameter_name() => {
                "1 - g"
            }
            _ => parameter.name(),
        }
    }
}
