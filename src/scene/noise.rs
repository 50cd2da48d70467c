//! `noise` and `variance`: how noisy the pixels of an image are.

use super::Noise;
use super::format::{number, refused};
use super::images::Frame;
use super::source::Source;
use super::variance;
use crate::error::Result;
use crate::image::Image;
use serde::Deserialize;
use std::path::PathBuf;
use toml::Value;

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
            (_, Some(path)) => Ok(Self::File(path.into())),
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

impl NoiseValue {
    /// The noise of the channels `names` of the image of `frame`, as the key `key` says. `mask`: which pixels count.
    pub fn read(
        &self,
        source: &Source,
        key: &str,
        names: &[&str],
        (frame, mask): (&Frame, Option<&Image>),
    ) -> Result<Noise> {
        match self {
            Self::Level(v) => Ok(Noise::Level(source.positive(key, *v)?)),
            Self::Sensor { read, shot } => Ok(Noise::Sensor {
                read: source.positive(&format!("{key} read"), *read)?,
                shot: source.non_negative(&format!("{key} shot"), *shot)?,
            }),
            Self::File(named) => {
                Ok(Noise::Variance(variance::read(&source.resolve(named), names, frame, mask)?))
            }
        }
    }
}
