//! Legal scenes that are probably not meant: lengths of two units, images of two scales, swapped, or flipped.
//!
//! They are found from the images alone. A medium only takes light away and blurs: it makes nothing brighter, sharper or mirrored.

use super::report::{Warning, WarningCode};
use crate::geometry::median;
use crate::image::{Channel, Image};
use crate::scene::{Gain, ObservedScene, Veil};

/// Brightness of the observation over what the clear image allows, above which they are in two units.
const BRIGHTER: f64 = 3.0;
/// The same below which they are, unless much is absorbed.
const DARKER: f64 = 1.0 / 300.0;
/// How much sharper than the clear image no observation is.
const SHARPER: f64 = 1.5;
/// By how much the correlation with a flipped image must be larger, and how large at least.
const MORE_ALIKE: f64 = 0.2;
const ALIKE: f64 = 0.4;

/// Finds one kind of slip, in words.
type Rule = fn(&ObservedScene) -> Option<String>;

/// The cautions that `scenes` deserve.
pub fn slips(scenes: &[ObservedScene]) -> Vec<Warning> {
    let rules: [(WarningCode, Rule); 4] = [
        (WarningCode::Units, |seen| seen.scene.unit_slip()),
        (WarningCode::Brightness, brightness),
        (WarningCode::SwappedImages, swapped),
        (WarningCode::FlippedImage, flipped),
    ];
    let of_scene = |seen: &ObservedScene| {
        let warning = |&(code, rule): &(WarningCode, Rule)| {
            let message = rule(seen)?;
            let name = seen.scene.path.display();
            let message = if scenes.len() == 1 { message } else { format!("{name}: {message}") };
            Some(Warning { code, severity: code.severity(), message })
        };
        rules.iter().filter_map(warning).collect::<Vec<_>>()
    };
    scenes.iter().flat_map(of_scene).collect()
}

/// The observation is much brighter, or much darker, than the clear image seen with the stated gain and veil.
fn brightness(seen: &ObservedScene) -> Option<String> {
    let (Gain::Fixed(gain), Veil::Fixed(veil)) = (seen.observation.gain, &seen.observation.veil) else {
        return None;
    };
    let ratio = |(clear, observed): (&Channel, &Channel)| {
        let bright = f64::from(clear.image.data.iter().copied().fold(0.0, f32::max));
        let counts = |i: usize| seen.observation.mask.as_ref().is_none_or(|mask| mask.data[i] > 0.0);
        let values = observed.image.data.iter().enumerate().filter(|(i, _)| counts(*i));
        let above: Vec<f64> = values.map(|(_, v)| f64::from(*v) - veil).collect();
        let middle = median(above.clone());
        // The brighter half's median: neither noise nor fireflies.
        let brighter: Vec<f64> = above.into_iter().filter(|v| *v >= middle).collect();
        median(brighter) / (gain * bright)
    };
    let ratios: Vec<f64> = seen.scene.object.iter().zip(&seen.observation.image).map(ratio).collect();
    let (least, most) = ratios.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
    let advice = "are object and observation in one unit? If the exposure is not known, gain = \"free\"";
    if most > BRIGHTER {
        return Some(format!("the observation is {most:.3} times as bright as the clear image: {advice}"));
    }
    (most < DARKER && least > 0.0).then(|| {
        format!(
            "the observation is only {most:.2e} times as bright as the clear image: much is absorbed, or {advice}"
        )
    })
}

/// The observation is sharper than the clear image.
fn swapped(seen: &ObservedScene) -> Option<String> {
    let (clear, observed) = views(seen);
    let ratio = sharpness(&observed)? / sharpness(&clear)?;
    (ratio > SHARPER && correlation(&clear, &observed)? > ALIKE).then(|| {
        "the observation is sharper than the clear image, and a medium only blurs: are [object] radiance and \
         [observation] image swapped?"
            .into()
    })
}

/// The observation is more like the clear image flipped.
fn flipped(seen: &ObservedScene) -> Option<String> {
    let (clear, observed) = views(seen);
    let (w, h) = (clear.width, clear.height);
    let as_is = correlation(&clear, &observed)?;
    let turned = [
        ("left to right", Image::from_fn(w, h, |x, y| clear.at(w - 1 - x, y))),
        ("upside down", Image::from_fn(w, h, |x, y| clear.at(x, h - 1 - y))),
        ("by half a turn", Image::from_fn(w, h, |x, y| clear.at(w - 1 - x, h - 1 - y))),
    ];
    let alike = turned.iter().filter_map(|(how, image)| Some((*how, correlation(image, &observed)?)));
    let (how, most) = alike.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (most > ALIKE && most > as_is + MORE_ALIKE).then(|| {
        format!(
            "the observation is more like the clear image flipped {how} (correlation {most:.2}) than as it is ({as_is:.2})"
        )
    })
}

/// What is seen of the clear image, and the observation, the channels of each added.
fn views(seen: &ObservedScene) -> (Image, Image) {
    let sum = |channels: &[Channel]| {
        let mut sum = channels[0].image.clone();
        for channel in &channels[1..] {
            sum.data.iter_mut().zip(&channel.image.data).for_each(|(s, v)| *s += v);
        }
        sum
    };
    (sum(&seen.scene.object).crop(seen.scene.view), sum(&seen.observation.image))
}

/// Steps to the next pixel over the variance, from products of neighbouring rows and columns, in which white noise cancels;
/// `None` without contrast.
fn sharpness(image: &Image) -> Option<f64> {
    let mean = image.mean();
    let at = |x: usize, y: usize| f64::from(image.at(x, y)) - mean;
    let (mut steps, mut variance) = (0.0, 0.0);
    for y in 0..image.height.checked_sub(1)? {
        for x in 0..image.width.checked_sub(1)? {
            let (a, b, c, d) = (at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1));
            steps += (b - a) * (d - c) + (c - a) * (d - b);
            variance += a * d + b * c;
        }
    }
    (variance > 0.0 && steps > 0.0).then(|| steps / variance)
}

/// Pearson's; `None` without contrast.
fn correlation(a: &Image, b: &Image) -> Option<f64> {
    let (mean_a, mean_b) = (a.mean(), b.mean());
    let pairs = a.data.iter().zip(&b.data).map(|(a, b)| (f64::from(*a) - mean_a, f64::from(*b) - mean_b));
    let [aa, ab, bb] = pairs.fold([0.0; 3], |[aa, ab, bb], (a, b)| [aa + a * a, ab + a * b, bb + b * b]);
    (aa > 0.0 && bb > 0.0).then(|| ab / (aa * bb).sqrt())
}
