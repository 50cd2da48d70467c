//! What follows from the parameters of a fit.

use super::Regime;
use crate::fit::inference::ChannelFit;
use crate::forward::Quantity;
use crate::phase::{Family, Phase, PhaseFunction};
use crate::spread::Model;
use serde::{Deserialize, Serialize};

/// A quantity that follows from the parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[serde(untagged)]
#[non_exhaustive]
pub enum Derived {
    /// With its standard error.
    Estimate {
        /// Its value.
        value: f64,
        /// Its standard error; null where the data do not decide it.
        std_error: Option<f64>,
    },
    /// A number.
    Number(f64),
    /// In words.
    Words(String),
}

impl Derived {
    /// Its value; `None` if it is in words.
    pub fn value(&self) -> Option<f64> {
        match self {
            Self::Estimate { value, .. } | Self::Number(value) => Some(*value),
            Self::Words(_) => None,
        }
    }
}

/// What follows from the parameters of one channel.
pub(super) fn derived(fit: &ChannelFit, model: Model) -> Vec<(&'static str, Derived)> {
    let medium = fit.parameters.medium().expect("parameters stay in their range");
    let estimate = |value: f64, parts: &[(Quantity, f64)], scale: f64| {
        let variance = fit.variance_of(&fit.parameters.direction(parts));
        Derived::Estimate { value, std_error: variance.map(|v| v.sqrt() * scale) }
    };
    let number = Derived::Number;
    let z = fit.median_z;
    let of_sigma_t = [(Quantity::SigmaS, medium.sigma_s()), (Quantity::SigmaA, 1.0)];
    let mut all = vec![("sigma_t", estimate(medium.sigma_t(), &of_sigma_t, 1.0))];
    let phase = *medium.phase();
    if model.spreads() {
        let (name, product) = product(medium.sigma_s(), &phase);
        let parts = [(Quantity::SigmaS, 1.0), (Quantity::Phase, 1.0)];
        all.push((name, estimate(product, &parts, product)));
    }
    all.push(("tau", number(medium.tau(z))));
    all.push(("optical_depth", number(medium.sigma_t() * z)));
    all.push(("albedo", number(medium.albedo())));
    if model.spreads() {
        if let Phase::Gaussian(phase) = phase {
            all.push(("spread_angle_deg", number(phase.spread_angle().to_degrees())));
        }
        all.push(("g", number(phase.mean_cosine())));
        let regime = Regime::of(fit).expect("parameters stay in their range");
        all.push(("validity", number(regime.validity)));
        all.push(("scattered_share", number(regime.scattered_share)));
        all.push(("kernel_width_px", number(regime.kernel_width_px)));
        all.push(("kernel_width_views", number(regime.kernel_width_views)));
        all.push(("verdict", Derived::Words(regime.in_words())));
    }
    all.push(("z", number(z)));
    all
}

/// What thick media show of sigma_s and the phase function: sigma_s·B, or the reduced scattering coefficient sigma_s (1 - g).
fn product(sigma_s: f64, phase: &Phase) -> (&'static str, f64) {
    match phase.family() {
        Family::Gaussian => ("sigma_s_b", sigma_s * phase.parameter()),
        Family::HenyeyGreenstein => ("sigma_s_reduced", sigma_s * (1.0 - phase.parameter())),
    }
}
