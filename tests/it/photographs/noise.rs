//! Noise of the clear image and of sensors: estimates are right on average, and error bars hold the truth as often as they say.

use crate::common::estimates::compare_all;
use crate::common::texture;
use narrowbeam::filter::{Backend, Optics, Target};
use narrowbeam::fit::noise::{with_noise, with_variance};
use narrowbeam::fit::{NoiseTerm, Observation, Settings, fit_channel};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::scene::FitOptions;
use narrowbeam::spread::Model;

const SIDE: usize = 64;
const TRIALS: u64 = 48;

fn truth() -> Medium {
    Medium::gaussian(0.6, 0.1, 0.004).unwrap()
}

fn geometry() -> Geometry {
    Geometry::planar(SIDE, SIDE, 0.03, 2.0).unwrap()
}

fn target<'a>(object: &'a Image, geometry: &'a Geometry) -> Target<'a> {
    let plain = Target::plain(object, geometry, Border::Zero, View::whole(SIDE, SIDE));
    Target { sampling: Sampling::Bandlimited, ..plain }
}

/// What the medium shows of `object`, without noise.
fn seen(object: &Image, geometry: &Geometry) -> Image {
    let optics = Optics { model: Model::SmallAngle, medium: truth() };
    Backend::Cpu.prepare(target(object, geometry), &optics, 1.0).unwrap().render(&optics).unwrap()
}

/// Mean and standard deviation of the errors in standard errors, over sigma_s, sigma_a and B, and how many 95 % intervals hold the truth.
struct Trials {
    mean: [f64; 3],
    rms: [f64; 3],
    held: f64,
}

/// The fits of `TRIALS` draws of an observation, each made and described by `draw`.
fn trials(draw: impl Fn(u64) -> (Image, Image), describe: impl Fn(Observation) -> Observation) -> Trials {
    let geometry = geometry();
    let (mut mean, mut square, mut held) = ([0.0; 3], [0.0; 3], 0.0);
    for seed in 0..TRIALS {
        let (object, observed) = draw(seed);
        let observation = describe(Observation::plain(target(&object, &geometry), &observed));
        let settings = Settings { model: Model::SmallAngle, ..Settings::default() };
        let fit = fit_channel(&[observation], &FitOptions::default(), &settings, &|| ()).unwrap();
        for (i, found) in compare_all(&fit, truth()).into_iter().enumerate() {
            let errors = found.off() / found.std_error.expect("is determined");
            mean[i] += errors / TRIALS as f64;
            square[i] += errors * errors / TRIALS as f64;
            held += f64::from(u8::from(errors.abs() < 1.96));
        }
    }
    let rms = square.map(f64::sqrt);
    println!("mean {mean:.2?}, root mean square {rms:.2?}, held {held} of {}", 3 * TRIALS);
    Trials { mean, rms, held: held / (3 * TRIALS) as f64 }
}

/// Means of 48 standard normal numbers lie within 4/√48 = 0.58; of their roots of the mean square, 0.1 is one standard deviation. The
/// intervals of three parameters that hang together hold in 95 ± 3 %.
fn assert_honest(trials: &Trials) {
    assert!(trials.mean.iter().all(|m| m.abs() < 0.58), "{:?}", trials.mean);
    assert!(trials.rms.iter().all(|s| (0.6..1.4).contains(s)), "{:?}", trials.rms);
    assert!(trials.held > 0.86, "{}", trials.held);
}

#[test]
fn noise_of_the_clear_image_moves_no_estimate_on_average() {
    let (geometry, clear) = (geometry(), texture(SIDE, SIDE));
    let light = seen(&clear, &geometry);
    let draw = |seed: u64| (with_noise(&clear, 0.03, 2 * seed), with_noise(&light, 0.004, 2 * seed + 1));
    let level = Some(NoiseTerm::Level(0.004));
    let object = Some(NoiseTerm::Level(0.03));
    assert_honest(&trials(draw, |o| Observation { noise: level, object_noise: object, ..o }));
    // The comparison sees what it costs to leave it out.
    let untold = trials(draw, |o| Observation { noise: level, ..o });
    assert!(untold.mean[0] > 1.0 && untold.held < 0.8, "{:?}", untold.mean);
}

#[test]
fn noise_that_is_estimated_may_hold_that_of_the_clear_image() {
    let (geometry, clear) = (geometry(), texture(SIDE, SIDE));
    let light = seen(&clear, &geometry);
    let draw = |seed: u64| (with_noise(&clear, 0.02, 2 * seed), with_noise(&light, 0.004, 2 * seed + 1));
    let object = Some(NoiseTerm::Sensor { read: 0.02, shot: 0.0 });
    assert_honest(&trials(draw, |o| Observation { object_noise: object, ..o }));
}

#[test]
fn shot_noise_is_weighted_by_the_signal_and_not_by_the_pixel() {
    let (geometry, clear) = (geometry(), texture(SIDE, SIDE));
    let light = seen(&clear, &geometry);
    let (read, shot) = (0.002, 0.06);
    let variance = Image {
        data: light.data.iter().map(|v| (read * read + shot * shot * f64::from(*v)) as f32).collect(),
        ..light.clone()
    };
    let draw = |seed: u64| (clear.clone(), with_variance(&light, &variance, seed));
    let sensor = Some(NoiseTerm::Sensor { read, shot });
    assert_honest(&trials(draw, |o| Observation { noise: sensor, ..o }));
}
