//! What the camera of one scene did to the light: where it looked, how sharply, and its fields.

use super::term::Term;
use crate::fit::inference::{ChannelFit, ExposureEstimate};
use crate::forward::Quantity;
use crate::imaging::{GAIN_MONOMIALS, MONOMIALS, WarpParameter};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// Names of the monomials, places being counted from the middle of the view in half diagonals.
const NAMES: [&str; MONOMIALS] = ["1", "x", "y", "x2", "xy", "y2"];

/// Where an observation lay on the clear image: what that shows at p, from the middle of the view, is seen at the place p + shift
/// turned, scaled and so on about the middle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RegistrationReport {
    /// `shift`, `similarity`, `affine` or `homography`.
    pub kind: String,
    /// How far it is shifted to the right and downwards, px.
    pub shift_px: [f64; 2],
    /// Angle by which it is turned clockwise, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<f64>,
    /// Its size over that of the clear image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Stretch, shear and perspective.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub further: IndexMap<String, Term>,
    /// Standard errors.
    pub std_errors: RegistrationErrors,
}

/// Standard errors of a registration; null where the data leave it undetermined.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RegistrationErrors {
    /// Of the shift, px.
    pub shift_px: [Option<f64>; 2],
    /// Of the angle, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<f64>,
    /// Of the scale.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
}

/// A blur beyond that of the clear image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct BlurReport {
    /// Its standard deviation, px.
    pub value: f64,
    /// Standard error of that; null if it was given, if the data leave it undetermined, or if it may be 0.
    pub std_error: Option<f64>,
    /// Its variance, px², with the standard error.
    pub variance_px2: Term,
}

/// A polynomial of the place, x and y being counted from the middle of the view in half diagonals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FieldReport {
    /// Its coefficients: `x`, `y`, `x2`, `xy`, `y2`, or `r2` of a radial one.
    pub terms: IndexMap<String, Term>,
}

impl FieldReport {
    /// How the free veil varies; `None` if it does not.
    pub(super) fn of_veil(exposure: &ExposureEstimate) -> Option<Self> {
        let fitted = 1 + exposure.veil_terms.saturating_sub(1);
        let term = |i: usize| {
            (NAMES[i].to_string(), Term { value: exposure.veil.0[i], std_error: exposure.veil_errors[i] })
        };
        (fitted > 1).then(|| Self { terms: (1..fitted).map(term).collect() })
    }

    /// How the gain of scene number `scene` of `fit` varies; `None` if it does not.
    pub(super) fn of_gain(scene: usize, fit: &ChannelFit) -> Option<Self> {
        let radial = std::iter::once((Quantity::GainRadial, "r2"));
        let all = radial.chain(GAIN_MONOMIALS.map(|i| (Quantity::GainTerm(i), NAMES[i])));
        let terms: IndexMap<_, _> =
            all.filter_map(|(quantity, name)| Some((name.into(), term(scene, fit, quantity)?))).collect();
        (!terms.is_empty()).then_some(Self { terms })
    }
}

impl BlurReport {
    /// That of scene number `scene` in `fit`; `None` if it has none.
    pub(super) fn new(scene: usize, fit: &ChannelFit) -> Option<Self> {
        let variance_px2 = term(scene, fit, Quantity::Blur)?;
        let value = variance_px2.value.max(0.0).sqrt();
        let std_error =
            variance_px2.std_error.map(|error| 0.5 * error / value).filter(|error| *error < value);
        Some(Self { value, std_error, variance_px2 })
    }
}

impl RegistrationReport {
    /// Whether the data determine it.
    pub fn is_determined(&self) -> bool {
        let warp = self.rotation_deg.is_none()
            || self.std_errors.rotation_deg.is_some() && self.std_errors.scale.is_some();
        warp && self.std_errors.shift_px.iter().all(Option::is_some)
            && self.further.values().all(|term| term.std_error.is_some())
    }

    /// That of scene number `scene` in `fit`; `None` if it was not registered.
    pub(super) fn new(scene: usize, fit: &ChannelFit) -> Option<Self> {
        let shift = Quantity::SHIFT.map(|axis| term(scene, fit, axis));
        let [Some(x), Some(y)] = shift else { return None };
        let warp = |parameter: WarpParameter| term(scene, fit, Quantity::Warp(parameter));
        let (rotation, log_scale) = (warp(WarpParameter::Rotation), warp(WarpParameter::LogScale));
        let further: IndexMap<String, Term> = WarpParameter::ALL[2..]
            .iter()
            .filter_map(|parameter| Some((parameter.name().to_string(), warp(*parameter)?)))
            .collect();
        let kind = match (rotation, further.len()) {
            (None, _) => "shift",
            (_, 0) => "similarity",
            (_, 2) => "affine",
            _ => "homography",
        };
        let scale = log_scale.map(|term| term.value.exp());
        Some(Self {
            kind: kind.into(),
            shift_px: [x.value, y.value],
            rotation_deg: rotation.map(|term| term.value.to_degrees()),
            scale,
            further,
            std_errors: RegistrationErrors {
                shift_px: [x.std_error, y.std_error],
                rotation_deg: rotation.and_then(|term| term.std_error).map(f64::to_degrees),
                scale: log_scale
                    .and_then(|term| term.std_error)
                    .zip(scale)
                    .map(|(error, scale)| error * scale),
            },
        })
    }
}

/// The parameter of scene number `scene` of `fit` that moves `quantity`.
fn term(scene: usize, fit: &ChannelFit, quantity: Quantity) -> Option<Term> {
    let (id, parameter) =
        fit.parameters.of_scene(scene).find(|(_, p)| p.descriptor().quantity == quantity)?;
    Some(Term { value: parameter.value(), std_error: fit.covariance.std_error(id) })
}
