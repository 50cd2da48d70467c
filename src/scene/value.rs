//! Values of keys that may be of several kinds.

use crate::imaging::VeilField;
use crate::io::picture::Format;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::Value;

/// The number that a value is.
pub(super) fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(v) => Some(*v),
        Value::Integer(v) => Some(*v as f64),
        _ => None,
    }
}

/// The array's items, if there are `N` and `item` accepts all of them.
pub(super) fn array<const N: usize, T>(value: &Value, item: impl Fn(&Value) -> Option<T>) -> Option<[T; N]> {
    value.as_array()?.iter().map(item).collect::<Option<Vec<T>>>()?.try_into().ok()
}

/// The refusal of a value that is not `wanted`.
pub(super) fn refused<T>(value: &Value, wanted: &str) -> std::result::Result<T, String> {
    Err(format!("{value} is not {wanted}"))
}

/// `transfer`: a name, a power or a file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum TransferValue {
    Linear,
    Srgb,
    Gamma(f64),
    File(PathBuf),
}

impl TryFrom<Value> for TransferValue {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        match (number(&value), value.as_str()) {
            (Some(v), _) => Ok(Self::Gamma(v)),
            (_, Some("linear")) => Ok(Self::Linear),
            (_, Some("srgb")) => Ok(Self::Srgb),
            (_, Some(path)) if path.ends_with(".csv") => Ok(Self::File(path.into())),
            _ => refused(&value, "\"linear\", \"srgb\", a gamma, nor the name of a CSV file"),
        }
    }
}

/// One standard deviation, read and shot noise, or the variance of each pixel.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum NoiseValue {
    Level(f64),
    Sensor { read: f64, shot: f64 },
    File(PathBuf),
}

impl TryFrom<Value> for NoiseValue {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        let sensor = || {
            let table = value.as_table().filter(|table| table.len() == 2)?;
            let entry = |key: &str| table.get(key).and_then(number);
            Some(Self::Sensor { read: entry("read")?, shot: entry("shot")? })
        };
        match (number(&value), value.as_str()) {
            (Some(v), _) => Ok(Self::Level(v)),
            (_, Some(path)) if Format::of_name(Path::new(path)).is_some() => Ok(Self::File(path.into())),
            _ => sensor().map_or_else(
                || {
                    refused(
                        &value,
                        "a number, nor { read = a number, shot = a number }, nor an image of variances",
                    )
                },
                Ok,
            ),
        }
    }
}

/// `veil`: a number, an image, or how it is fitted.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum VeilValue {
    Number(f64),
    File(PathBuf),
    Free,
    Field(VeilField),
    Auto,
}

impl Default for VeilValue {
    fn default() -> Self {
        Self::Number(0.0)
    }
}

impl TryFrom<Value> for VeilValue {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        match (number(&value), value.as_str()) {
            (Some(v), _) => Ok(Self::Number(v)),
            (_, Some("free")) => Ok(Self::Free),
            (_, Some("auto")) => Ok(Self::Auto),
            (_, Some("linear")) => Ok(Self::Field(VeilField::Linear)),
            (_, Some("quadratic")) => Ok(Self::Field(VeilField::Quadratic)),
            (_, Some(path)) => Ok(Self::File(path.into())),
            _ => refused(
                &value,
                "a number, nor the name of an image file, nor \"free\", \"linear\", \"quadratic\" or \"auto\"",
            ),
        }
    }
}

/// `blur_px`: a number, or how it is fitted.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(try_from = "Value")]
pub(super) enum BlurValue {
    Number(f64),
    Free,
    Auto,
}

impl TryFrom<Value> for BlurValue {
    type Error = String;

    fn try_from(value: Value) -> std::result::Result<Self, String> {
        match (number(&value), value.as_str()) {
            (Some(v), _) => Ok(Self::Number(v)),
            (_, Some("free")) => Ok(Self::Free),
            (_, Some("auto")) => Ok(Self::Auto),
            _ => refused(&value, "a number, nor \"free\" or \"auto\""),
        }
    }
}
