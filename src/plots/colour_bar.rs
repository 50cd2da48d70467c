//! From values to the colours of a panel, and the bar that explains them.

use super::scale::{Scale, round_step};
use crate::image::Channel;
use crate::io::colour::{NOT_A_NUMBER, Tone, diverging, sequential};
use crate::io::png::mean_of_channels;

/// Numbers beside a bar, at most.
pub(super) const BAR_TICKS: usize = 5;

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
    /// Values from 0 up, white at 0 and darkest at `max`; of three channels the mean.
    Sequential {
        /// The value of the darkest colour.
        max: f64,
    },
}

impl Shade {
    /// Values from 0 to the largest finite one of `channels`, rounded up to a tick of the bar; to 1 if none is above 0.
    pub fn from_zero(channels: &[Channel]) -> Self {
        let values = channels.iter().flat_map(|c| &c.image.data).filter(|v| v.is_finite());
        let largest = f64::from(values.fold(0.0, |a: f32, &b| a.max(b)));
        let step = round_step(largest / BAR_TICKS as f64);
        Shade::Sequential { max: if largest > 0.0 { step * (largest / step).ceil() } else { 1.0 } }
    }

    /// The colours of all pixels.
    pub(super) fn colours(&self, channels: &[Channel]) -> Vec<[u8; 3]> {
        match self {
            Shade::Diverging { .. } | Shade::Sequential { .. } => {
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
            Shade::Sequential { max } => sequential(value / max),
        }
    }

    /// The values along the bar.
    pub(super) fn scale(&self) -> Scale {
        match self {
            Shade::Radiance(tone) => Scale { low: 0.0, high: tone.white, log: false },
            Shade::Diverging { scale } => Scale { low: -scale, high: *scale, log: false },
            Shade::Sequential { max } => Scale { low: 0.0, high: *max, log: false },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    #[test]
    fn a_sequential_shade_ends_at_a_round_value_above_all() {
        let max = |values: [f32; 3]| {
            let image = Image { width: 3, height: 1, data: values.to_vec() };
            match Shade::from_zero(&[Channel { name: "Y".into(), image }]) {
                Shade::Sequential { max } => (max * 1e6).round() / 1e6,
                other => unreachable!("{other:?}"),
            }
        };
        assert_eq!(max([0.0, 0.27, f32::NAN]), 0.3);
        assert_eq!(max([0.0, 0.004, 0.0151]), 0.02);
        assert_eq!(max([0.0; 3]), 1.0);
    }
}
