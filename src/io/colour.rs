//! From linear values to 8-bit colours: the only place where a transfer curve or a colour map is applied.
//!
//! Pictures: value / white through the sRGB transfer curve (IEC 61966-2-1), clipped to 0..1; white is the 99.5 %
//! quantile of a reference image, so that single bright pixels do not darken the rest. Signed values: a diverging
//! map from blue (negative) over white (0) to red (positive), symmetric, linear in the value. Values from 0 up: a
//! sequential map from white (0) over green to dark blue, linear in the value.

use crate::image::Channel;
use std::sync::LazyLock;

/// Share of pixels that lie below white.
const WHITE_QUANTILE: f64 = 0.995;

/// Colour of a value that is not a number.
pub const NOT_A_NUMBER: [u8; 3] = [128, 128, 128];

/// The exposure of a picture: which radiance is white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Radiance that becomes white; above 0.
    pub white: f64,
}

impl Tone {
    /// White is the 99.5 % quantile of all finite values of `reference`; 1 if that is not above 0.
    pub fn of(reference: &[Channel]) -> Self {
        let white = quantile(finite_values(reference).collect(), WHITE_QUANTILE);
        Self { white: if white > 0.0 { white } else { 1.0 } }
    }

    /// The 8-bit level of a radiance; NaN is 0.
    pub fn level(&self, radiance: f64) -> u8 {
        let share = radiance / self.white;
        LEVELS.partition_point(|&begins| begins <= share) as u8
    }
}

/// Shares of white at which the levels 1 to 255 begin, half a level below their own.
static LEVELS: LazyLock<[f64; 255]> =
    LazyLock::new(|| std::array::from_fn(|i| srgb_inverse((i as f64 + 0.5) / 255.0)));

/// The linear value of an encoded one in 0..1.
pub(crate) fn srgb_inverse(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Scale of a residual picture: the 99.5 % quantile of the finite magnitudes of `residual`; 1 if all are 0.
pub fn residual_scale(residual: &[Channel]) -> f64 {
    let scale = quantile(finite_values(residual).map(f64::abs).collect(), WHITE_QUANTILE);
    if scale > 0.0 { scale } else { 1.0 }
}

/// Colour of the share `t` of the scale: -1 blue, 0 white, 1 red, clipped outside.
///
/// Piecewise linear between the five classes of ColorBrewer's RdBu and their halves towards white, which remain
/// distinct for colour-blind readers.
pub fn diverging(t: f64) -> [u8; 3] {
    const SIDE: [[[f64; 3]; 4]; 2] = [
        [[255.0, 255.0, 255.0], [146.0, 197.0, 222.0], [67.0, 147.0, 195.0], [5.0, 48.0, 97.0]],
        [[255.0, 255.0, 255.0], [244.0, 165.0, 130.0], [214.0, 96.0, 77.0], [103.0, 0.0, 31.0]],
    ];
    if t.is_nan() {
        return NOT_A_NUMBER;
    }
    between(&SIDE[usize::from(t > 0.0)], t.abs())
}

/// Colour of the share `t` of the scale: 0 white, 1 dark blue, clipped outside.
///
/// Piecewise linear between white and four classes of ColorBrewer's YlGnBu, which darken evenly.
pub fn sequential(t: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 5] = [
        [255.0, 255.0, 255.0],
        [199.0, 233.0, 180.0],
        [65.0, 182.0, 196.0],
        [34.0, 94.0, 168.0],
        [8.0, 29.0, 88.0],
    ];
    if t.is_nan() { NOT_A_NUMBER } else { between(&STOPS, t) }
}

/// The colour at the share `t` of the way over evenly spaced `stops`, clipped to 0..1.
fn between(stops: &[[f64; 3]], t: f64) -> [u8; 3] {
    let position = t.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let i = (position as usize).min(stops.len() - 2);
    let f = position - i as f64;
    std::array::from_fn(|c| (stops[i][c] + f * (stops[i + 1][c] - stops[i][c])).round() as u8)
}

fn finite_values(channels: &[Channel]) -> impl Iterator<Item = f64> {
    channels.iter().flat_map(|c| &c.image.data).map(|&v| f64::from(v)).filter(|v| v.is_finite())
}

/// The value below which the share `q` of `values` lies; 0 if there are none.
fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = (q * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    #[test]
    fn the_transfer_curve_is_that_of_srgb() {
        // Values of IEC 61966-2-1: the foot, the joint, mid-gray, white.
        for (linear, encoded) in [(0.0, 0.0), (0.0031308, 0.04045), (0.214041, 0.5), (1.0, 1.0)] {
            assert!((srgb_inverse(encoded) - linear).abs() < 1e-5, "{linear}");
        }
        let tone = Tone { white: 2.0 };
        let levels = [-1.0, f64::NAN, 0.0, 2.0 * 0.2150, 2.0, 9.0].map(|v| tone.level(v));
        assert_eq!(levels, [0, 0, 0, 128, 255, 255]);
        for level in 0..=255u8 {
            assert_eq!(tone.level(2.0 * srgb_inverse(f64::from(level) / 255.0)), level);
        }
    }

    #[test]
    fn white_ignores_a_few_bright_pixels_and_nan() {
        let mut image = Image::from_fn(1000, 1, |x, _| x as f32 / 1000.0);
        image.data[999] = 1e6;
        image.data[0] = f32::NAN;
        let tone = Tone::of(&[Channel { name: "Y".into(), image }]);
        assert!((tone.white - 0.995).abs() < 2e-3, "{}", tone.white);
        assert_eq!(tone.level(tone.white), 255);
        assert_eq!(Tone::of(&[]).white, 1.0);
    }

    #[test]
    fn the_diverging_map_is_white_at_zero_and_symmetric_in_lightness() {
        assert_eq!(diverging(0.0), [255, 255, 255]);
        assert_eq!(diverging(f64::NAN), NOT_A_NUMBER);
        let luma =
            |c: [u8; 3]| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
        for t in [0.2, 0.5, 0.9] {
            let (minus, plus) = (diverging(-t), diverging(t));
            assert!(minus[2] > minus[0] && plus[0] > plus[2]);
            assert!((luma(minus) - luma(plus)).abs() < 40.0, "{t}: {minus:?} {plus:?}");
        }
        assert_eq!(diverging(7.0), diverging(1.0));
    }

    #[test]
    fn the_sequential_map_is_white_at_zero_and_darkens() {
        let luma =
            |c: [u8; 3]| 0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2]);
        let lumas: Vec<f64> = (0..=20).map(|i| luma(sequential(f64::from(i) / 20.0))).collect();
        assert!(lumas.windows(2).all(|pair| pair[1] < pair[0]), "{lumas:?}");
        assert_eq!(sequential(0.0), [255, 255, 255]);
        assert_eq!((sequential(-1.0), sequential(7.0)), (sequential(0.0), sequential(1.0)));
        assert_eq!(sequential(f64::NAN), NOT_A_NUMBER);
    }
}
