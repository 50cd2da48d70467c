//! How each scene was exposed, and where its observation lay.

use super::imaging::{BlurReport, FieldReport, RegistrationReport};
use super::term::Term;
use crate::fit::inference::{ChannelFit, ExposureEstimate};
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
    /// Pixels left out because of light from outside the clear image.
    #[serde(default)]
    pub outside_pixels: usize,
    /// Where the observation lay, if it was registered by the fit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub registration: Option<RegistrationReport>,
    /// Its blur beyond that of the clear image, if there was one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub blur_px: Option<BlurReport>,
    /// How its gain varied, if it did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain_field: Option<FieldReport>,
    /// How its veil varied, if it was free to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub veil_field: Option<FieldReport>,
}

impl ExposureReport {
    pub(super) fn new(scene: usize, channel: &str, exposure: &ExposureEstimate, fit: &ChannelFit) -> Self {
        Self {
            scene,
            channel: channel.into(),
            gain: Term { value: exposure.gain, std_error: exposure.gain_error },
            veil: Term { value: exposure.veil.0[0], std_error: exposure.veil_errors[0] },
            veil_field: FieldReport::of_veil(exposure),
            gain_field: FieldReport::of_gain(scene, fit),
            blur_px: BlurReport::new(scene, fit),
            outside_pixels: exposure.outside_pixels,
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
