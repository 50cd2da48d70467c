//! Pixels at the ceiling of a sensor, which show that there was light, but not how much.
//!
//! A ceiling that is not stated shows itself: many pixels have exactly the highest value. In a file of codes they are a pile far above
//! the counts of the codes below it. In a file of floats noise makes no two values the same, but at a ceiling; where other values
//! are tied, too, as in a render without noise, nothing is concluded.

use crate::image::{Channel, Image};

/// Pixels of exactly the highest value, and their share, from which on that may be a ceiling.
const FEWEST: usize = 8;
const SHARE: f64 = 5e-4;
/// How many times as many pixels as a code below it the highest one must have.
const PILE: f64 = 4.0;
/// Codes below the highest that are looked at, and those that an image has at least.
const BELOW: usize = 4;
const CODES: usize = 32;
/// Share of tied values above which floats are not those of a noisy image.
const TIED: f64 = 0.05;

/// The level at which `image` saturates, if it shows one; `are_codes`: whether its values are those of integers.
pub(super) fn ceiling(image: &Image, counts: impl Fn(usize) -> bool, are_codes: bool) -> Option<f32> {
    let mut values: Vec<f32> =
        image.data.iter().enumerate().filter(|(i, v)| counts(*i) && **v != 0.0).map(|(_, v)| *v).collect();
    let highest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let count = values.iter().filter(|v| **v == highest).count();
    if highest <= 0.0 || count < FEWEST || (count as f64) < SHARE * image.data.len() as f64 {
        return None;
    }
    values.sort_unstable_by(|a, b| b.total_cmp(a));
    let runs: Vec<usize> = values[count..].chunk_by(|a, b| a == b).map(<[f32]>::len).collect();
    let is_ceiling = if are_codes {
        let below = &runs[..runs.len().min(BELOW)];
        let mean = below.iter().sum::<usize>() as f64 / below.len().max(1) as f64;
        runs.len() >= CODES && count as f64 > PILE * mean
    } else {
        let tied: usize = runs.iter().filter(|n| **n > 1).sum();
        let others = values.len() - count;
        others > count && (tied as f64) < TIED * others as f64
    };
    is_ceiling.then_some(highest)
}

/// Which pixels do not count because some channel reaches its level there, or beside it: interpolated colours and a lens
/// carry what was cut off one pixel on. `None` if no channel does.
pub(super) fn left_out(channels: &[(&Channel, f32)]) -> Option<Vec<bool>> {
    let image = &channels.first()?.0.image;
    let (width, height) = (image.width, image.height);
    let reached = |i: usize| channels.iter().any(|(channel, level)| channel.image.data[i] >= *level);
    let saturated: Vec<bool> = (0..width * height).map(reached).collect();
    if !saturated.contains(&true) {
        return None;
    }
    let around = |i: usize, n: usize| i.saturating_sub(1)..(i + 2).min(n);
    let near = |i: usize| {
        around(i / width, height).any(|y| around(i % width, width).any(|x| saturated[y * width + x]))
    };
    Some((0..width * height).map(near).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of a noisy slope, in steps of `step`, cut off at `level`.
    fn slope(level: f32, step: f32) -> Image {
        let noise = |x: usize, y: usize| ((x * 7919 + y * 104_729) % 1009) as f32 / 1009.0;
        Image::from_fn(64, 64, |x, y| {
            let value = 0.01 * x as f32 + 0.1 * noise(x, y) + 1e-6 * (y * 64 + x) as f32;
            (value / step).round().mul_add(step, 0.0).min(level)
        })
    }

    #[test]
    fn ceilings_are_found_in_floats_and_codes_alike() {
        assert_eq!(ceiling(&slope(0.55, 1e-7), |_| true, false), Some(0.55));
        assert_eq!(ceiling(&slope(0.5, 1.0 / 128.0), |_| true, true), Some(0.5));
        assert_eq!(ceiling(&slope(9.0, 1e-7), |_| true, false), None);
        assert_eq!(ceiling(&slope(9.0, 1.0 / 128.0), |_| true, true), None);
    }

    #[test]
    fn renders_of_few_levels_have_no_ceiling() {
        let squares = Image::from_fn(64, 64, |x, y| if x < 4 && y < 60 { 0.2 } else { 0.7 });
        assert_eq!(ceiling(&squares, |_| true, false), None);
        assert_eq!(ceiling(&squares, |_| true, true), None);
        let tied = Image::from_fn(64, 64, |x, y| ((x + y) as f32 * 0.01).min(0.6));
        assert_eq!(ceiling(&tied, |_| true, false), None);
    }

    #[test]
    fn what_is_masked_is_not_looked_at() {
        assert_eq!(ceiling(&slope(0.55, 1e-7), |i| i % 64 < 40, false), None);
    }

    #[test]
    fn saturated_pixels_take_their_neighbours_with_them() {
        let image = Image::from_fn(5, 4, |x, y| if (x, y) == (3, 0) { 1.0 } else { 0.1 });
        let channel = Channel { name: "Y".into(), image };
        let out = left_out(&[(&channel, 1.0)]).unwrap();
        let places: Vec<usize> = (0..20).filter(|&i| out[i]).collect();
        assert_eq!(places, [2, 3, 4, 7, 8, 9]);
        assert!(left_out(&[(&channel, 1.5)]).is_none());
    }
}
