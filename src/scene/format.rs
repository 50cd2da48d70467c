//! The keys of a scene file, as TOML tables. Unknown keys are refused by name.

use super::place::of_byte;
use super::source::Source;
use super::value::{BlurValue, NoiseValue, TransferValue, VeilValue, array, number, refused};
use crate::error::Result;
use crate::image::Border;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use toml::Value;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    pub object: ObjectSection,
    pub camera: CameraSection,
    pub observation: Option<ObservationSection>,
    pub medium: Option<MediumSection>,
    #[serde(default)]
    pub fit: FitSection,
    pub illumination: Option<IlluminationSection>,
}

/// A truth file: the medium, beside tables that are for people.
#[derive(Debug, Deserialize)]
pub(super) struct TruthFile {
    pub medium: MediumSection,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObjectSection {
    pub radiance: Option<PathBuf>,
    pub reflectance: Option<PathBuf>,
    pub shading: Option<PathBuf>,
    pub layer_name: Option<String>,
    pub channels: Option<Vec<String>>,
    pub depth: NumberOrFile,
    pub depth_channel: Option<String>,
    #[serde(default)]
    pub depth_kind: DepthKind,
    #[serde(default)]
    pub depth_error: f64,
    #[serde(default)]
    pub surface: NumberOrFile,
    pub border: Option<Border>,
    pub sampling: Option<String>,
    pub transfer: Option<TransferValue>,
    pub noise: Option<NoiseValue>,
    pub depth_scale: Option<f64>,
    #[serde(default)]
    pub layer: Vec<LayerSection>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LayerSection {
    pub radiance: PathBuf,
    pub depth: NumberOrFile,
    pub layer_name: Option<String>,
    pub channels: Option<Vec<String>>,
    pub depth_channel: Option<String>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum DepthKind {
    #[default]
    Ray,
    Planar,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraSection {
    pub pixel_pitch: Option<f64>,
    pub fov_x_deg: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObservationSection {
    pub image: Option<PathBuf>,
    pub layer_name: Option<String>,
    pub channels: Option<Vec<String>>,
    /// Size of the view while there is no observed image to take it from.
    pub size_px: Option<[usize; 2]>,
    pub offset_px: Option<[usize; 2]>,
    pub transfer: Option<TransferValue>,
    pub noise: Option<NoiseValue>,
    pub saturation: Option<f64>,
    pub loss: Option<String>,
    pub variance: Option<PathBuf>,
    pub mask: Option<PathBuf>,
    #[serde(default)]
    pub gain: NumberOrFree,
    #[serde(default)]
    pub gain_error: f64,
    #[serde(default)]
    pub veil: VeilValue,
    pub hidden_share_max: Option<f64>,
    pub registration: Option<String>,
    pub blur_px: Option<BlurValue>,
    pub gain_field: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IlluminationSection {
    pub image: Option<PathBuf>,
    pub transfer: Option<TransferValue>,
    pub direction: Option<[f64; 3]>,
    pub irradiance: Option<Numbers>,
    pub normal: Option<[f64; 3]>,
    pub bottom: Option<f64>,
    pub bottom_reflectance: Option<Numbers>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MediumSection {
    pub sigma_s: Option<Numbers>,
    pub sigma_a: Option<Numbers>,
    pub phase: Option<String>,
    pub b: Option<Numbers>,
    pub spread_angle_deg: Option<Numbers>,
    pub g: Option<Numbers>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct FitSection {
    pub phase: Option<String>,
    pub start: PerParameter<Numbers>,
    pub fixed: PerParameter<Numbers>,
    pub bounds: PerParameter<Pairs>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PerParameter<T> {
    pub sigma_s: Option<T>,
    pub sigma_a: Option<T>,
    pub b: Option<T>,
    pub g: Option<T>,
}

impl<T> Default for PerParameter<T> {
    fn default() -> Self {
        Self { sigma_s: None, sigma_a: None, b: None, g: None }
    }
}

/// A number, or three for R, G, B.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum Numbers {
    One(f64),
    Three([f64; 3]),
}

/// A pair of bounds, or three for R, G, B.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum Pairs {
    One([f64; 2]),
    Three([[f64; 2]; 3]),
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum NumberOrFile {
    Number(f64),
    File(PathBuf),
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum NumberOrFree {
    Number(f64),
    Free,
}

impl Default for NumberOrFile {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

impl Default for NumberOrFree {
    fn default() -> Self {
        Self::Number(1.0)
    }
}

impl TryFrom<Value> for Numbers {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        let found = number(&value).map(Self::One).or_else(|| array(&value, number).map(Self::Three));
        found.map_or_else(|| refused(&value, "a number, nor three for R, G, B"), Ok)
    }
}

impl TryFrom<Value> for Pairs {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        let pair = |v: &Value| array::<2, f64>(v, number);
        let found = pair(&value).map(Self::One).or_else(|| array(&value, pair).map(Self::Three));
        found.map_or_else(|| refused(&value, "[low, high], nor three such pairs for R, G, B"), Ok)
    }
}

impl TryFrom<Value> for NumberOrFile {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        match (number(&value), value.as_str()) {
            (Some(v), _) => Ok(Self::Number(v)),
            (_, Some(path)) => Ok(Self::File(path.into())),
            _ => refused(&value, "a number, nor the name of an image file"),
        }
    }
}

impl TryFrom<Value> for NumberOrFree {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        match (number(&value), value.as_str()) {
            (Some(v), _) => Ok(Self::Number(v)),
            (_, Some("free")) => Ok(Self::Free),
            _ => refused(&value, "a number, nor \"free\""),
        }
    }
}

/// The contents of `source` as a `T`.
pub(super) fn parse<T: DeserializeOwned>(source: &Source) -> Result<T> {
    let text = &source.text;
    let read = |error: toml::de::Error| {
        let place = error.span().map(|span| of_byte(text, span.start));
        // Without the text, the error's own message names the table of the key.
        let named =
            text.parse::<toml::Table>().ok().and_then(|table| Value::Table(table).try_into::<T>().err());
        let message = named.map_or_else(|| error.message().to_string(), |named| named.to_string());
        source.error_at(place, &message.split_whitespace().collect::<Vec<_>>().join(" "))
    };
    toml::from_str(text).map_err(read)
}
