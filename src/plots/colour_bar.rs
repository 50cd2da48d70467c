//! From values to the colours of a panel, and the bar that explains them.

use super::canvas::{Drawn, INK, label};
use super::scale::{Scale, round_step};
use crate::image::Channel;
use crate::io::colour::{NOT_A_NUMBER, Tone, diverging, sequential};
use crate::io::png::mean_of_channels;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, DrawingBackend, PathElement, RGBColor, Rectangle, Text};
use plotters::style::Color;

/// Largest count of numbers beside a bar.
pub(super) const BAR_TICKS: usize = 5;

const TICK_PX: f64 = 14.0;
const BAR_WIDTH_PX: i32 = 14;
/// From one name of a legend to the next.
const LEGEND_STEP_PX: i32 = 26;

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
    /// Values above 0 in bands whose edges are evenly spaced in their logarithm, so that the edges are contours: the
    /// darkest below `max`, white under `max` / 10^`decades`; of three channels the mean.
    Bands {
        /// The upper edge of the darkest band.
        max: f64,
        /// Decades from there to the lower edge of the palest.
        decades: u8,
        /// Bands in a decade.
        per_decade: u8,
    },
    /// Whole numbers that stand for these names, each with its colour.
    Categories(&'static [(&'static str, [u8; 3])]),
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
            Shade::Diverging { .. }
            | Shade::Sequential { .. }
            | Shade::Bands { .. }
            | Shade::Categories(_) => {
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
            Shade::Categories(names) => names.get(value as usize).map_or(NOT_A_NUMBER, |(_, colour)| *colour),
            Shade::Bands { .. } if value <= 0.0 => sequential(0.0),
            Shade::Bands { decades, per_decade, .. } => {
                let bands = f64::from(*decades) * f64::from(*per_decade);
                sequential((self.scale().share(value) * bands).ceil() / bands)
            }
        }
    }

    /// The values along the bar.
    pub(super) fn scale(&self) -> Scale {
        match self {
            Shade::Radiance(tone) => Scale { low: 0.0, high: tone.white, log: false },
            Shade::Diverging { scale } => Scale { low: -scale, high: *scale, log: false },
            Shade::Sequential { max } => Scale { low: 0.0, high: *max, log: false },
            Shade::Categories(names) => Scale { low: 0.0, high: names.len() as f64, log: false },
            Shade::Bands { max, decades, .. } => {
                Scale { low: max / 10f64.powi((*decades).into()), high: *max, log: true }
            }
        }
    }

    /// Draws the bar with its numbers, its top left corner at `left`, `top` and `height` px high.
    pub(super) fn draw_bar<DB: DrawingBackend>(
        &self,
        root: &DrawingArea<DB, Shift>,
        (left, top): (i32, i32),
        height: i32,
    ) -> Drawn {
        if let Shade::Categories(names) = self {
            return draw_legend(root, (left, top), names);
        }
        let scale = self.scale();
        let y_of = |value: f64| top + ((1.0 - scale.share(value)) * f64::from(height - 1)).round() as i32;
        for y in 0..height {
            let [r, g, b] = self.colour(scale.value(1.0 - f64::from(y) / f64::from(height - 1)));
            let line = [(left, top + y), (left + BAR_WIDTH_PX, top + y + 1)];
            root.draw(&Rectangle::new(line, RGBColor(r, g, b).filled())).map_err(|e| e.to_string())?;
        }
        let frame = [(left, top), (left + BAR_WIDTH_PX, top + height - 1)];
        root.draw(&Rectangle::new(frame, INK.stroke_width(1))).map_err(|e| e.to_string())?;
        for value in scale.ticks(BAR_TICKS) {
            let (x, y) = (left + BAR_WIDTH_PX, y_of(value));
            let tick = PathElement::new([(x, y), (x + 4, y)], INK);
            let number = Text::new(scale.label(value), (x + 8, y), label(TICK_PX));
            root.draw(&tick).and_then(|()| root.draw(&number)).map_err(|e| e.to_string())?;
        }
        Ok(())
    }
}

/// Draws a square of each colour with its name, one below the other.
fn draw_legend<DB: DrawingBackend>(
    root: &DrawingArea<DB, Shift>,
    (left, top): (i32, i32),
    names: &[(&'static str, [u8; 3])],
) -> Drawn {
    for (i, (name, [r, g, b])) in names.iter().enumerate() {
        let y = top + i as i32 * LEGEND_STEP_PX;
        let square = [(left, y), (left + BAR_WIDTH_PX, y + BAR_WIDTH_PX)];
        let filled = Rectangle::new(square, RGBColor(*r, *g, *b).filled());
        let frame = Rectangle::new(square, INK.stroke_width(1));
        let words = Text::new(*name, (left + BAR_WIDTH_PX + 8, y + BAR_WIDTH_PX / 2), label(TICK_PX));
        root.draw(&filled).and_then(|()| root.draw(&frame)).map_err(|e| e.to_string())?;
        root.draw(&words).map_err(|e| e.to_string())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    #[test]
    fn bands_have_one_colour_between_their_edges_and_none_below_the_last() {
        let shade = Shade::Bands { max: 10.0, decades: 3, per_decade: 4 };
        assert_eq!(shade.colour(9.9), shade.colour(5.7));
        assert_ne!(shade.colour(5.7), shade.colour(5.6));
        assert_eq!(shade.colour(100.0), shade.colour(10.0));
        for dark in [0.0, -1.0, 0.0099] {
            assert_eq!(shade.colour(dark), [255; 3], "{dark}");
        }
        assert_ne!(shade.colour(0.0101), [255; 3]);
        assert_eq!(shade.colour(f64::NAN), NOT_A_NUMBER);
    }

    #[test]
    fn categories_have_their_own_colours() {
        let shade = Shade::Categories(&[("right", [1, 2, 3]), ("wrong", [4, 5, 6])]);
        assert_eq!([0.0, 1.0].map(|v| shade.colour(v)), [[1, 2, 3], [4, 5, 6]]);
        assert_eq!(shade.colour(2.0), NOT_A_NUMBER);
    }

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
