//! A scene file read into typed, checked values (see the README for the format).

use crate::geometry::Geometry;
use crate::image::{Border, Channel, Image, View};
use std::path::PathBuf;

/// Everything that one scene file and the images it names say.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The scene file.
    pub path: PathBuf,
    /// Clear radiance of the object, one channel or R, G, B.
    pub object: Vec<Channel>,
    /// Camera, object distance, medium surface.
    pub geometry: Geometry,
    /// What lies outside the object image.
    pub border: Border,
    /// The part of the object image that is observed, rendered or traced.
    pub view: View,
    /// What was seen through the medium, if the scene has `[observation]`.
    pub observation: Option<Observation>,
    /// The medium to render or trace with, one for each object channel, if the scene has `[medium]`.
    pub medium: Option<Vec<MediumValues>>,
    /// Starting values, fixed values and bounds of a fit, one for each object channel.
    pub fit: Vec<FitOptions>,
}

/// sigma_s, sigma_a (1/length) and B (rad²) as given by a user, checked only when a medium is made of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MediumValues {
    /// Scattering coefficient, 1/length.
    pub sigma_s: f64,
    /// Absorption coefficient, 1/length.
    pub sigma_a: f64,
    /// Width of the Gaussian phase function, rad².
    pub b: f64,
}

/// The observed image and how it was exposed.
#[derive(Debug, Clone)]
pub struct Observation {
    /// The file it came from.
    pub path: PathBuf,
    /// Observed radiance, the same channels as the object's.
    pub image: Vec<Channel>,
    /// Standard deviation of the noise of a pixel, if known.
    pub noise: Option<f64>,
    /// Pixels above 0 count; absent: all do.
    pub mask: Option<Image>,
    /// Exposure.
    pub gain: Gain,
    /// Light scattered in from the illumination.
    pub veil: Veil,
}

/// Exposure: observed = gain · (light from the object + veil... see [`Veil`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gain {
    /// Known.
    Fixed(f64),
    /// Fitted.
    Free,
}

/// Light added to the image, in units of the observation: observed = gain · object light + veil.
#[derive(Debug, Clone, PartialEq)]
pub enum Veil {
    /// One known number.
    Fixed(f64),
    /// A known image, the same channels as the observation's.
    Image(Vec<Channel>),
    /// One number a channel, fitted.
    Free,
}

/// What the user asks of the fit of one channel; `None` leaves it to the program.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FitOptions {
    /// Starting values of sigma_s, sigma_a, B.
    pub start: [Option<f64>; 3],
    /// Values of sigma_s, sigma_a, B that are held.
    pub fixed: [Option<f64>; 3],
    /// Lower and upper bounds of sigma_s, sigma_a, B.
    pub bounds: [Option<[f64; 2]>; 3],
}
