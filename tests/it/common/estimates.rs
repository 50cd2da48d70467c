//! What a fit has found of a medium, parameter by parameter, beside the truth.

use narrowbeam::fit::{ChannelFit, Id, Parameter, Status};
use narrowbeam::forward::{Quantity, State};
use narrowbeam::medium::Medium;

/// One parameter of a medium after a fit, beside its true value.
#[derive(Debug, Clone, Copy)]
pub struct Compared<'a> {
    pub quantity: Quantity,
    pub id: Id,
    pub parameter: &'a Parameter,
    pub truth: f64,
    /// Standard error of the coordinate; `None` if the parameter is fixed or undetermined.
    pub std_error: Option<f64>,
}

impl<'a> Compared<'a> {
    pub fn name(&self) -> &'a str {
        self.parameter.name()
    }

    pub fn value(&self) -> f64 {
        self.parameter.value()
    }

    /// Estimate minus truth.
    pub fn error(&self) -> f64 {
        self.value() - self.truth
    }

    /// The same over the truth.
    pub fn relative_error(&self) -> f64 {
        self.value() / self.truth - 1.0
    }

    /// Estimate minus truth of the coordinate: ln sigma_s, sigma_a, ln B or ln(1 - g).
    pub fn off(&self) -> f64 {
        self.parameter.coordinate() - self.parameter.coordinate_of(self.truth)
    }

    /// The same in standard errors.
    pub fn in_std_errors(&self) -> Option<f64> {
        self.std_error.map(|error| self.off() / error)
    }

    /// What a relative error of 1 is in the coordinate.
    pub fn unit(&self) -> f64 {
        if self.parameter.is_logarithmic() { 1.0 } else { self.truth }
    }

    /// d value / d coordinate at the truth, without its sign.
    pub fn slope_at_truth(&self) -> f64 {
        self.parameter.descriptor().coordinate.slope(self.truth).abs()
    }
}

/// What `fit` found of `quantity`, beside the `truth`.
pub fn compare(fit: &ChannelFit, truth: Medium, quantity: Quantity) -> Compared<'_> {
    let id = fit.parameters.id(quantity);
    Compared {
        quantity,
        id,
        parameter: fit.parameters.get(id),
        truth: value_of(truth, quantity),
        std_error: fit.covariance.std_error(id),
    }
}

/// The same of sigma_s, sigma_a and the parameter of the phase function.
pub fn compare_all(fit: &ChannelFit, truth: Medium) -> [Compared<'_>; 3] {
    Quantity::MEDIUM.map(|quantity| compare(fit, truth, quantity))
}

/// The value of `quantity` in `medium`.
pub fn value_of(medium: Medium, quantity: Quantity) -> f64 {
    State::from(medium).value(quantity)
}

/// Names and values of the parameters of the medium.
pub fn values(fit: &ChannelFit) -> Vec<(&str, f64)> {
    fit.parameters.of_medium().map(|(_, parameter)| (parameter.name(), parameter.value())).collect()
}

pub fn status(fit: &ChannelFit, quantity: Quantity) -> Status {
    fit.covariance.status(fit.parameters.id(quantity))
}

/// Standard error of the coordinate of what is determined.
pub fn std_error(fit: &ChannelFit, quantity: Quantity) -> f64 {
    fit.covariance.std_error(fit.parameters.id(quantity)).expect("determined")
}
