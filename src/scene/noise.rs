//! `noise` and `variance`: how noisy the pixels of an image are.

use super::Noise;
use super::images::Frame;
use super::source::Source;
use super::value::NoiseValue;
use super::variance;
use crate::error::Result;
use crate::image::Image;

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
