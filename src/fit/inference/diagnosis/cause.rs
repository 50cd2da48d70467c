//! What may have made a residual.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What may have made a residual.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Cause {
    /// The observation does not lie on the clear image.
    Shift,
    /// It is turned against it.
    Rotation,
    /// It is larger or smaller.
    Scale,
    /// It is less sharp, or sharper.
    Blur,
    /// The gain is not the same everywhere.
    GainField,
    /// There is light that the object has not sent.
    Veil,
    /// Light from outside the clear image.
    OutsideLight,
    /// Pixels are clipped.
    Saturation,
    /// The clear image is noisy.
    ObjectNoise,
    /// What lies between pixels is not as was said.
    Sampling,
    /// The phase function has another tail.
    PhaseTail,
    /// The depth varies across the view.
    DepthGradient,
    /// Values are not proportional to radiance.
    Transfer,
    /// The medium varies along the ray.
    Layers,
    /// Some pixels are far off.
    Outliers,
    /// The noise of neighbouring pixels is correlated.
    CorrelatedNoise,
    /// The noise is not what was said.
    NoiseModel,
}

impl Cause {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Shift => "shift",
            Self::Rotation => "rotation",
            Self::Scale => "scale",
            Self::Blur => "blur",
            Self::GainField => "gain_field",
            Self::Veil => "veil",
            Self::OutsideLight => "outside_light",
            Self::Saturation => "saturation",
            Self::ObjectNoise => "object_noise",
            Self::Sampling => "sampling",
            Self::PhaseTail => "phase_tail",
            Self::DepthGradient => "depth_gradient",
            Self::Transfer => "transfer",
            Self::Layers => "layers",
            Self::Outliers => "outliers",
            Self::CorrelatedNoise => "correlated_noise",
            Self::NoiseModel => "noise_model",
        }
    }

    /// Whether it says how noisy pixels are, and not what is wrong with the image.
    pub fn is_of_noise(self) -> bool {
        matches!(self, Self::Outliers | Self::CorrelatedNoise | Self::NoiseModel)
    }

    /// The unit of its amplitude.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Shift => "px",
            Self::Rotation => "deg",
            Self::Blur => "px²",
            Self::Veil | Self::OutsideLight => "radiance",
            Self::Saturation | Self::Outliers => "pixels",
            Self::NoiseModel => "ratio",
            Self::Scale
            | Self::GainField
            | Self::ObjectNoise
            | Self::Sampling
            | Self::PhaseTail
            | Self::DepthGradient
            | Self::Transfer
            | Self::Layers
            | Self::CorrelatedNoise => "1",
        }
    }

    /// What it means.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Shift => "the observation is shifted against the clear image",
            Self::Rotation => "the observation is turned against the clear image",
            Self::Scale => "the observation has another scale than the clear image",
            Self::Blur => "the observation is not as sharp as the clear image, by more than the medium",
            Self::GainField => "the gain varies over the view, as by vignetting",
            Self::Veil => "there is a veil, or it varies over the view",
            Self::OutsideLight => "light from outside the clear image is missing",
            Self::Saturation => "pixels are saturated",
            Self::ObjectNoise => "the clear image is noisy",
            Self::Sampling => "what lies between the pixels of the clear image is not what was assumed",
            Self::PhaseTail => "the phase function has another tail",
            Self::DepthGradient => "the depth varies over the view otherwise than was said",
            Self::Transfer => "values are not proportional to radiance",
            Self::Layers => "the medium varies along the ray",
            Self::Outliers => "a few pixels are far off, as hot pixels and fireflies are",
            Self::CorrelatedNoise => "the noise of neighbouring pixels is correlated",
            Self::NoiseModel => "the noise is not what was stated, or not the same everywhere",
        }
    }

    /// What a user can do.
    pub fn advice(self) -> &'static str {
        match self {
            Self::Shift | Self::Rotation | Self::Scale => "fit it along: registration = \"auto\"",
            Self::Blur => "fit it along: blur_px = \"free\"; or focus both images alike",
            Self::GainField => {
                "fit it along: gain_field = \"auto\"; or divide both images by the same flat field"
            }
            Self::Veil => "fit it along: veil = \"auto\"; or give it as an image",
            Self::OutsideLight => {
                "say so: border = \"unknown\"; or take a clear image that is larger than the view"
            }
            Self::Saturation => "mask the pixels, or expose for a shorter time",
            Self::ObjectNoise => "average several clear images",
            Self::Sampling => "state what is right: sampling = \"pixel\" or \"bandlimited\"",
            Self::PhaseTail => "fit the other phase function: phase = \"gaussian\" or \"hg\"",
            Self::DepthGradient => "give the depth as an image",
            Self::Transfer => "make the images linear",
            Self::Layers => "stir the medium, or look through less of it",
            Self::Outliers => "mask them",
            Self::CorrelatedNoise => "none needed: the error bars hold it",
            Self::NoiseModel => "give the noise of each pixel as an image: variance",
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
