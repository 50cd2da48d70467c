//! What the user should know about an estimate.

use crate::scene::{Caution, CautionCode};
use serde::{Deserialize, Serialize};
use std::fmt;

/// What the user should know about an estimate.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Warning {
    /// Short name for programs.
    pub code: WarningCode,
    /// How serious it is.
    pub severity: Severity,
    /// What it means and what can be done.
    pub message: String,
}

/// How serious a warning is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Severity {
    /// Good to know.
    Note,
    /// The estimate may be off by more than it says.
    Caution,
    /// The image contradicts the scene: the estimate is not to be relied on.
    Invalid,
}

/// Kinds of warnings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum WarningCode {
    /// The optimiser stopped before the optimum.
    NotConverged,
    /// The data do not determine some parameter.
    Undetermined,
    /// The kernel reaches beyond the padding of the image.
    KernelCut,
    /// Noise, depth slices or paths did not settle.
    NotSettled,
    /// More pixels are left out for hidden light than count.
    HiddenLight,
    /// chi² is too large.
    Misfit,
    /// The residual is not noise.
    Structure,
    /// The image shows only the core of the kernel.
    WideKernel,
    /// The data want a parameter beyond its bound.
    AtBound,
    /// The model is known to be the wrong one.
    ModelError,
    /// The error of the model is not known.
    ModelErrorUnknown,
    /// The scene is outside what the model is valid for.
    OutsideValidity,
    /// A file says another transfer curve than the scene.
    Transfer,
    /// The clear image is saturated.
    Saturation,
    /// Lengths are hardly in one unit.
    Units,
    /// The observation is brighter or darker than the clear image allows.
    Brightness,
    /// The observation is sharper than the clear image.
    SwappedImages,
    /// The observation is like the clear image flipped.
    FlippedImage,
}

impl WarningCode {
    /// How serious a warning of this kind is.
    pub fn severity(self) -> Severity {
        match self {
            Self::HiddenLight => Severity::Note,
            _ => Severity::Caution,
        }
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::NotConverged => "not_converged",
            Self::Undetermined => "undetermined",
            Self::KernelCut => "kernel_cut",
            Self::NotSettled => "not_settled",
            Self::HiddenLight => "hidden_light",
            Self::Misfit => "misfit",
            Self::Structure => "structure",
            Self::WideKernel => "wide_kernel",
            Self::AtBound => "at_bound",
            Self::ModelError => "model_error",
            Self::ModelErrorUnknown => "model_error_unknown",
            Self::OutsideValidity => "outside_validity",
            Self::Transfer => "transfer",
            Self::Saturation => "saturation",
            Self::Units => "units",
            Self::Brightness => "brightness",
            Self::SwappedImages => "swapped_images",
            Self::FlippedImage => "flipped_image",
        }
    }
}

impl fmt::Display for WarningCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<&Caution> for Warning {
    fn from(caution: &Caution) -> Self {
        let code = match caution.code {
            CautionCode::Transfer => WarningCode::Transfer,
            CautionCode::Saturation => WarningCode::Saturation,
        };
        Self::new(code, caution.message.clone())
    }
}

impl Warning {
    /// A warning of this kind.
    pub(super) fn new(code: WarningCode, message: String) -> Self {
        Self { code, severity: code.severity(), message }
    }

    /// The same, of another severity.
    pub(super) fn of(self, severity: Severity) -> Self {
        Self { severity, ..self }
    }
}
