//! A first guess of turn, scale and shift between a clear image and what is observed of it through a medium.
//!
//! Both images are made small. For each of many turns and scales the observation is moved back by them, and the phase correlation finds
//! the shift that is left. The turn and scale with which the clear image explains most are the best. The medium's blur has no direction,
//! so it favours none.

use super::registration::{Pair, coarse_shift};
use super::spline::{Spline, Waves, sampled};
use crate::image::Image;
use crate::imaging::{Places, Warp, WarpParameter};
use rayon::prelude::*;

/// Steps of the angle (rad) and of the logarithm of the scale that are looked at first, how many on each side, and how often they are
/// halved about the best.
const TURN_STEP: f64 = 0.026;
const SCALE_STEP: f64 = 0.02;
const STEPS_ASIDE: i32 = 4;
const HALVINGS: usize = 3;
/// How much more the best of many turns must explain than none, to be more than chance or a texture that repeats itself.
const BETTER: f64 = 1.15;
/// Larger side of the images on which turn and scale are sought, px: a step moves their edges by two pixels.
const SMALL: usize = 160;

/// Turn and scale of `observed` against `object` about their middle, and the shift before them: what the clear image shows at p is
/// seen at the warped place of p + shift, px. As [`coarse_shift`] otherwise; turns up to 6 degrees and scales up to 8 % are found,
/// to a few tenths of a pixel at the edge of small images.
pub fn coarse_similarity(object: &Image, observed: &Image, mask: Option<&Image>) -> (Warp, [f64; 2]) {
    let factor = object.width.max(object.height).div_ceil(SMALL);
    let small = [object, observed].map(|image| reduced(image, factor));
    let small_mask = mask.map(|mask| reduced(mask, factor));
    let spline = [Waves::of(&small[1]).spline(0.0)];
    let tried = |warp: &Warp| {
        let Some((observed, mask)) = moved_back(&small[1], small_mask.as_ref(), &spline, warp) else {
            return f64::NEG_INFINITY;
        };
        Pair { object: small[0].clone(), observed, mask: Some(mask) }.explained()
    };
    let about = |middle: [f64; 2], steps: [f64; 2], aside: i32| {
        let all = (-aside..=aside).flat_map(|i| (-aside..=aside).map(move |j| [i, j]));
        let places: Vec<[f64; 2]> =
            all.map(|n| [0, 1].map(|axis| middle[axis] + f64::from(n[axis]) * steps[axis])).collect();
        let tried = places.par_iter().map(|&[turn, scale]| (tried(&similarity(turn, scale)), [turn, scale]));
        tried.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(middle, |(_, place)| place)
    };
    let mut steps = [TURN_STEP, SCALE_STEP];
    let mut best = about([0.0; 2], steps, STEPS_ASIDE);
    for _ in 0..HALVINGS {
        steps = steps.map(|step| 0.5 * step);
        best = about(best, steps, 1);
    }
    let [unturned, found] = [[0.0; 2], best].map(|[turn, scale]| tried(&similarity(turn, scale)));
    let [turn, scale] = if found > BETTER * unturned { best } else { [0.0; 2] };
    let warp = similarity(turn, scale);
    let whole = [Waves::of(observed).spline(0.0)];
    let shift_px = moved_back(observed, mask, &whole, &warp)
        .map_or([0.0; 2], |(observed, mask)| coarse_shift(object, &observed, Some(&mask)));
    (warp, shift_px)
}

fn similarity(turn: f64, scale: f64) -> Warp {
    Warp::default().with(WarpParameter::Rotation, turn).with(WarpParameter::LogScale, scale)
}

/// `observed`, whose spline is given, as it would be without `warp`, and where it was seen.
fn moved_back(
    observed: &Image,
    mask: Option<&Image>,
    spline: &[Spline],
    warp: &Warp,
) -> Option<(Image, Image)> {
    let Image { width, height, .. } = *observed;
    let places = Places { width, height };
    let bend = warp.bend(places.half_diagonal_px())?;
    let from = |i: usize| {
        let [x, y] = bend.seen_at(places.px(i));
        [x + 0.5 * width as f64 - 0.5, y + 0.5 * height as f64 - 0.5]
    };
    let seen = Image::from_fn(width, height, |x, y| {
        let [u, v] = from(y * width + x).map(f64::round);
        let inside = u >= 0.0 && v >= 0.0 && u < width as f64 && v < height as f64;
        let counts = inside && mask.is_none_or(|mask| mask.at(u as usize, v as usize) > 0.0);
        f32::from(u8::from(counts))
    });
    Some((sampled(spline, (width, height), from).remove(0).image, seen))
}

/// The means of blocks of `factor` by `factor` pixels.
fn reduced(image: &Image, factor: usize) -> Image {
    let share = 1.0 / (factor * factor) as f32;
    Image::from_fn(image.width / factor, image.height / factor, |x, y| {
        let block = (0..factor).flat_map(|j| (0..factor).map(move |i| (x * factor + i, y * factor + j)));
        block.map(|(x, y)| image.at(x, y)).sum::<f32>() * share
    })
}
