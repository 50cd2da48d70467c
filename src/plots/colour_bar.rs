//! From values to the colours of a panel, and the bar that explains them.

use super::scale::Scale;
use crate::image::Channel;
use crate::io::colour::{NOT_A_NUMBER, Tone, diverging};
use crate::io::png::mean_of_channels;

/// How the values of a panel become colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shade {
    /// Radiance through the transfer curve: gray of one channel, colour of three.
    Radiance(Tone),
    /// Signed values, blue below 0 and red above, with the full colour at `scale`; of three channels the mean.
    Diverging {
        /// The value of the full colour.
        scale: f64,
    },
}

impl Shade {
    /// The colours of all pixels.
    pub(super) fn colours(&self, channels: &[Channel]) -> Vec<[u8; 3]> {
        match self {
            Shade::Diverging { .. } => {
                mean_of_channels(channels).image.data.iter().map(|&v| self.colour(v.into())).collect()
            }
            Shade::Radiance(tone) if channels.len() == 3 => (0..channels[0].image.data.len())
                .map(|i| std::array::from_fn(|c| tone.level(channels[c].image.data[i].into())))
                .collect(),
            Shade::Radiance(_) => channels[0].image.data.iter().map(|&v| self.colour(v.into())).collect(),
        }
    }

    /// The colour of one value in the bar.
    pub(super) fn colour(&self, value: f64) -> [u8; 3] {
        match self {
            _ if value.is_nan() => NOT_A_NUMBER,
            Shade::Radiance(tone) => [tone.level(value); 3],
            Shade::Diverging { scale } => diverging(value / scale),
        }
    }

    /// The values along the bar.
    pub(super) fn scale(&self) -> Scale {
        match self {
            Shade::Radiance(tone) => Scale { low: 0.0, high: tone.white, log: false },
            Shade::Diverging { scale } => Scale { low: -scale, high: *scale, log: false },
        }
    }
}
