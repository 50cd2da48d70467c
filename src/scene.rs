//! A scene file read into typed, checked values (docs/scene-file.md has the format).
//!
//! A file is read as what it is needed for: [`Scene`] to render or trace, [`ObservedScene`] to fit, [`LitScene`] to
//! synthesize. Whatever is missing, unknown, contradictory or out of range is refused, by name of file and key or pixel; what
//! is returned needs no further checks.

mod background;
mod camera;
mod files;
mod fit_options;
mod format;
mod illumination;
mod images;
mod layers;
mod light;
mod medium;
mod noise;
mod numbers;
mod observation;
mod place;
mod read;
mod sampling;
mod saturation;
mod slips;
mod source;
mod value;
mod variance;

pub use medium::read_truth;
pub use slips::medium_slip;

use crate::geometry::Geometry;
use crate::illumination::{Bottom, Shading, Sun};
use crate::image::{Border, Channel, Image, Sampling, View};
use crate::imaging::{Blur, Choice, GainField, Imaging, Registration, VeilField};
use crate::phase::Family;
use std::path::PathBuf;

/// The object, the camera, the medium and the options of a fit from one scene file and the images that it names.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The scene file.
    pub path: PathBuf,
    /// All that may be read for it: the scene file and every file that it names, as far as they exist.
    pub files: Vec<PathBuf>,
    /// Clear radiance of the object, one channel or R, G, B; its reflectance in a [`LitScene`] with `shading`.
    pub object: Vec<Channel>,
    /// The noise of the object image, if it is not without.
    pub object_noise: Option<Noise>,
    /// For each of these channels, the clear radiance of each further layer, nearest first.
    pub behind: Vec<Vec<Image>>,
    /// Camera, object distance, medium surface.
    pub geometry: Geometry,
    /// Relative standard error of all depths together.
    pub depth_error: f64,
    /// What lies outside the object image.
    pub border: Border,
    /// What lies between the pixels of the object image.
    pub sampling: Sampling,
    /// Whether that was stated, or shows in the image.
    pub sampling_is_known: bool,
    /// The part of the object image that is observed, rendered or traced.
    pub view: View,
    /// What `[medium]` says, one for each object channel; see [`Scene::media`].
    pub medium: Vec<PartialMedium>,
    /// Starting values, fixed values and bounds of a fit, one for each object channel.
    pub fit: Vec<FitOptions>,
    /// What the user should know of the object image.
    pub cautions: Vec<Caution>,
}

/// Something that the user should know of an image, though it can be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caution {
    /// Its kind.
    pub code: CautionCode,
    /// What it is, and what can be done.
    pub message: String,
}

/// Kinds of cautions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CautionCode {
    /// The transfer curve that is stated is not the one that the file names.
    Transfer,
    /// The clear image has saturated pixels.
    Saturation,
}

impl Scene {
    /// Names of the object's channels.
    pub fn channels(&self) -> Vec<&str> {
        self.object.iter().map(|channel| channel.name.as_str()).collect()
    }
}

/// A scene and what was seen of it through the medium.
#[derive(Debug, Clone)]
pub struct ObservedScene {
    /// The scene; its view is the part that is observed.
    pub scene: Scene,
    /// What was seen.
    pub observation: Observation,
}

/// A scene and the light that falls into its medium.
#[derive(Debug, Clone)]
pub struct LitScene {
    /// The scene.
    pub scene: Scene,
    /// Given if the object emits no light but reflects that of the illumination.
    pub shading: Option<Shading>,
    /// The light.
    pub illumination: Illumination,
}

/// The light that falls into the medium.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Illumination {
    /// Only its veil over the view is known, one image for each of the object's channels.
    Veil(Vec<Channel>),
    /// Parallel light.
    Parallel {
        /// Its direction, and the surface through which it enters the medium.
        sun: Sun,
        /// For each object channel, irradiance on a plane perpendicular to the light.
        irradiance: Vec<f64>,
        /// For each object channel, what bounds the medium below.
        bottom: Vec<Bottom>,
    },
}

/// The values of `[medium]`, each in its range.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PartialMedium {
    /// Scattering coefficient, 1/length.
    pub sigma_s: Option<f64>,
    /// Absorption coefficient, 1/length.
    pub sigma_a: Option<f64>,
    /// Family of the phase function: that of the key which gives its parameter.
    pub family: Family,
    /// Its parameter, B (rad²) or g.
    pub phase_parameter: Option<f64>,
}

/// The observed image and how it was exposed.
#[derive(Debug, Clone)]
pub struct Observation {
    /// The file it came from.
    pub path: PathBuf,
    /// Observed radiance, the same channels as the object's; finite (pixels that the mask excludes and that are
    /// not are set to 0).
    pub image: Vec<Channel>,
    /// The noise of a pixel, if known.
    pub noise: Option<Noise>,
    /// Pixels above 0 count; absent: all do.
    pub mask: Option<Image>,
    /// Exposure.
    pub gain: Gain,
    /// Relative standard error of a gain that is given.
    pub gain_error: f64,
    /// Light scattered in from the illumination.
    pub veil: Veil,
    /// Largest hidden share of a pixel that counts: the share of its light that may come from behind nearer surfaces,
    /// from where no layer shows anything. Above 0, at most 1.
    pub hidden_share_max: f64,
    /// How the image is registered on the object's.
    pub registration: Choice<Registration>,
    /// Its blur beyond that of the object's image.
    pub blur: Choice<Blur>,
    /// How its gain varies over the view.
    pub gain_field: Choice<GainField>,
    /// What large residuals count.
    pub loss: Loss,
    /// Pixels that the mask excludes for saturation.
    pub saturated_pixels: usize,
    /// What the user should know of the image.
    pub cautions: Vec<Caution>,
}

impl Observation {
    /// `image` from the file `path`: gain 1, no veil, noise not known, all pixels count, a camera that does nothing.
    pub fn plain(path: PathBuf, image: Vec<Channel>) -> Self {
        Self {
            path,
            image,
            noise: None,
            mask: None,
            gain: Gain::Fixed(1.0),
            gain_error: 0.0,
            veil: Veil::Fixed(0.0),
            hidden_share_max: HIDDEN_SHARE_MAX,
            registration: Choice::Is(Registration::None),
            blur: Choice::Is(Blur::default()),
            gain_field: Choice::Is(GainField::None),
            loss: Loss::Gaussian,
            saturated_pixels: 0,
            cautions: Vec::new(),
        }
    }

    /// Whether a fit of it has parameters beside those of the medium and what enters linearly.
    pub fn frees_camera(&self) -> bool {
        let (registration, gain_field) = (self.registration.least(), self.gain_field.least());
        registration != Registration::None
            || Imaging::new(registration, self.blur.least(), gain_field).is_some()
    }
}

/// The noise of an image.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Noise {
    /// One standard deviation for all pixels, above 0.
    Level(f64),
    /// That of a sensor: variance `read`² + `shot`² times the signal.
    Sensor {
        /// Standard deviation without light, above 0.
        read: f64,
        /// Standard deviation at the signal 1 without the former, at least 0.
        shot: f64,
    },
    /// The variance of each pixel, the same channels as the image's; above 0 where the mask does not exclude it.
    Variance(Vec<Channel>),
}

/// Exposure: observed = gain · (light from the object) + veil.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Gain {
    /// Known, above 0.
    Fixed(f64),
    /// Fitted.
    Free,
}

/// Light added to the image, in units of the observation: observed = gain · object light + veil.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Veil {
    /// One known number.
    Fixed(f64),
    /// A known image, the same channels as the observation's.
    Image(Vec<Channel>),
    /// One field per channel, fitted.
    Free(VeilField),
    /// None, or a free one if the image asks for it.
    Auto,
}

/// Default share of hidden light above which a pixel does not count: a smaller share is lost in the noise of ordinary
/// images.
pub const HIDDEN_SHARE_MAX: f64 = 0.01;

/// What a residual adds to the cost of a fit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Loss {
    /// Its square: noise is normal.
    #[default]
    Gaussian,
    /// Its square up to 1.345 standard deviations, its magnitude beyond (Huber 1964): a few pixels may be far off.
    Huber,
}

/// The user's options for the fit of one channel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FitOptions {
    /// Family of the phase function whose parameter, B or g, is fitted.
    pub family: Family,
    /// Of the scattering coefficient, 1/length; values above 0.
    pub sigma_s: ParameterOptions,
    /// Of the absorption coefficient, 1/length; values of at least 0.
    pub sigma_a: ParameterOptions,
    /// Of the phase-function parameter: B (rad²), above 0, or g, between 0 and 1.
    pub phase: ParameterOptions,
}

/// The user's options for one parameter; `None` leaves the choice to the program. Where a value is fixed, its start and bounds do not
/// matter. All are finite.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ParameterOptions {
    /// Starting value.
    pub start: Option<f64>,
    /// A value that is held fixed; for sigma_s it may also be 0.
    pub fixed: Option<f64>,
    /// Lower and upper bound, the lower below the upper and the start between them.
    pub bounds: Option<[f64; 2]>,
}
