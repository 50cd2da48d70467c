//! How each scene was exposed, and where its observation lay.

use crate::fit::inference::{ChannelFit, ExposureEstimate};
use crate::fit::parameters::{Id, Parameter};
use crate::forward::Quantity;
use serde::{Deserialize, Serialize};

/// Gain, veil, noise and misfit of one channel of one scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ExposureReport {
    /// Number of the scene, from 0.
    pub scene: usize,
    /// The channel.
    pub channel: String,
    /// Exposure: observed = gain · object light + veil.
    pub gain: Term,
    /// Veil, the constant part.
    pub veil: Term,
    /// Standard deviation of a pixel's noise, given or estimated; of given variances the root of their harmonic mean.
    pub noise: f64,
    /// Sum of squared residuals over noise².
    pub chi2: f64,
    /// Pixels that counted.
    pub pixels: usize,
    /// Pixels left out because of hidden light.
    pub hidden_pixels: usize,
    /// Pixels left out because they, or the clear image there, are saturated.
    #[serde(default)]
    pub saturated_pixels: usize,
    /// What lies between the pixels of the clear image: `pixel` or `bandlimited`.
    pub sampling: String,
    /// Whether that was stated or shows in the image; if not, half of what the other would change is part of the model's error.
    pub sampling_is_known: bool,
    /// Where the observation lay, if it was registered by the fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registration: Option<RegistrationReport>,
}

/// A number that enters the image linearly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Term {
    /// Its value.
    pub value: f64,
    /// Its standard error; null if it was given or the data leave it undetermined.
    pub std_error: Option<f64>,
}

/// Where an observation lay on the clear image.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RegistrationReport {
    /// How far it is shifted to the right and downwards, px.
    pub shift_px: [f64; 2],
    /// Standard errors of these.
    pub std_errors: RegistrationErrors,
}

/// Standard errors of a registration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct RegistrationErrors {
    /// Of the shift, px; null where the data leave it undetermined.
    pub shift_px: [Option<f64>; 2],
}

impl RegistrationReport {
    /// Whether the data determine it.
    pub fn is_determined(&self) -> bool {
        self.std_errors.shift_px.iter().all(Option::is_some)
    }

    /// That of scene number `scene` in `fit`; `None` if it was not registered.
    fn new(scene: usize, fit: &ChannelFit) -> Option<Self> {
        let along = |quantity: Quantity| -> Option<(Id, &Parameter)> {
            fit.parameters.of_scene(scene).find(|(_, p)| p.descriptor().quantity == quantity)
        };
        let (x, y) = along(Quantity::ShiftX).zip(along(Quantity::ShiftY))?;
        Some(Self {
            shift_px: [x, y].map(|(_, parameter)| parameter.value()),
            std_errors: RegistrationErrors { shift_px: [x, y].map(|(id, _)| fit.covariance.std_error(id)) },
        })
    }
}

impl ExposureReport {
    pub(super) fn new(scene: usize, channel: &str, exposure: &ExposureEstimate, fit: &ChannelFit) -> Self {
        Self {
            scene,
            channel: channel.into(),
            gain: Term { value: exposure.gain, std_error: exposure.gain_error },
            veil: Term { value: exposure.veil, std_error: exposure.veil_error },
            noise: exposure.noise,
            sampling: exposure.sampling.name().into(),
            sampling_is_known: exposure.sampling_is_known,
            chi2: exposure.chi2,
            pixels: exposure.pixels,
            hidden_pixels: exposure.hidden_pixels,
            saturated_pixels: exposure.saturated_pixels,
            registration: RegistrationReport::new(scene, fit),
        }
    }
}
