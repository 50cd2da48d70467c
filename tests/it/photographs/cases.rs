//! Real faults of photographs, mended by what the scene says.

use crate::common::report::select;
use narrowbeam::filter::Filter;
use narrowbeam::fit::{Fit, Settings};
use narrowbeam::scene::{Loss, ObservedScene};
use std::path::Path;

/// The medium of the images.
const TRUTH: [(&str, f64); 3] = [("sigma_s", 0.8), ("sigma_a", 0.08), ("b", 0.004_873_878_7)];

fn scene(name: &str) -> ObservedScene {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/faults");
    ObservedScene::read(&data.join(name)).unwrap()
}

fn fit(scene: ObservedScene) -> Fit {
    select(&[scene], &Settings::default(), Filter::Auto, 0.01, &|| ()).unwrap().report
}

/// Asserts that intervals `stretch` times as wide as those of 95 % hold the truth, and that no estimate is farther off than `most`.
fn assert_right(fit: &Fit, stretch: f64, most: f64) {
    for (name, truth) in TRUTH {
        let found = &fit.parameters[name];
        let [low, high] = found.ci95.expect("an interval");
        let off = found.value.unwrap() / truth - 1.0;
        println!("{name}: {:+.2} %, 95 % {low:.5} to {high:.5}", 100.0 * off);
        let (middle, half) = (0.5 * (low + high), 0.5 * stretch * (high - low));
        assert!((truth - middle).abs() < half, "{name}: {low} to {high} do not hold {truth}");
        assert!(off.abs() < most, "{name} is off by {off}");
    }
}

#[test]
fn saturated_pixels_that_the_image_shows_are_left_out() {
    let fit = fit(scene("clipped.toml"));
    // 3538 pixels have exactly the highest value; their neighbours are left out, too.
    assert!(fit.exposures[0].saturated_pixels > 3538);
    assert_eq!(fit.exposures[0].pixels + fit.exposures[0].saturated_pixels, 128 * 128);
    assert_right(&fit, 1.0, 0.03);
}

#[test]
fn a_noisy_clear_image_fits_if_its_noise_is_stated() {
    let noisy = scene("noisy-object.toml");
    assert!(noisy.scene.object[0].image.data.iter().any(|v| *v < 0.0));
    // One draw of noise, of which one in twenty falls outside 95 %: sigma_s is 2.0 standard errors off. How often intervals hold is
    // counted in `noise`; here it is three standard errors.
    assert_right(&fit(noisy.clone()), 1.5, 0.03);
    // Told nothing of the noise, the fit blurs it away by a medium that is too thick.
    let mut untold = noisy;
    untold.scene.object_noise = None;
    let value = fit(untold).parameters["sigma_s"].value.unwrap();
    assert!(value > 1.05 * 0.8, "{value}");
}

#[test]
fn fireflies_move_no_estimate_if_the_loss_is_hubers() {
    let mut seen = scene("fireflies.toml");
    seen.observation.loss = Loss::Huber;
    let fit = fit(seen);
    for (name, truth) in [("sigma_s", 0.8), ("sigma_a", 0.05), ("b", 8.0_f64.to_radians().powi(2) / 4.0)] {
        let found = &fit.parameters[name];
        let [low, high] = found.ci95.expect("an interval");
        let off = found.value.unwrap() / truth - 1.0;
        println!("{name}: {:+.2} %, std error {:?}", 100.0 * off, found.std_error);
        assert!((low..=high).contains(&truth) && off.abs() < 0.02, "{name}: {low} to {high}, {off}");
    }
    // By squares the 17 pixels are noise of every pixel.
    let by_squares = self::fit(scene("fireflies.toml"));
    let ratio =
        |name: &str| by_squares.parameters[name].std_error.unwrap() / fit.parameters[name].std_error.unwrap();
    println!("std errors by squares over these: {:.1}, {:.1}", ratio("sigma_s"), ratio("sigma_a"));
    assert!(ratio("sigma_a") > 3.0);
}
