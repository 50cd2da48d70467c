//! Fits on the device give what fits on the CPU do.

use super::gpu;
use super::scenes::Scene;
use crate::common::report::fit_scenes;
use crate::common::{bundled, with_noise};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::gpu::GpuFilter;
use narrowbeam::filter::{Backend, Filter, Optics};
use narrowbeam::fit::{ChannelFit, NoiseTerm, Observation, Settings, VeilTerm, fit_channel};
use narrowbeam::image::Image;
use narrowbeam::imaging::VeilField;
use narrowbeam::medium::Medium;
use narrowbeam::scene::{FitOptions, Gain, ObservedScene};
use narrowbeam::spread::Model;

/// What a fit was made with: sigma_s, sigma_a (1/length), B (rad²), gain and veil.
const TRUTH: (f64, f64, f64) = (0.8, 0.1, 2e-5);
const GAIN: f32 = 1.7;
const VEIL: f32 = 0.05;

fn optics() -> Optics {
    let (sigma_s, sigma_a, b) = TRUTH;
    Optics { model: Model::SmallAngle, medium: Medium::gaussian(sigma_s, sigma_a, b).unwrap() }
}

fn observed(scene: &Scene) -> Image {
    let optics = optics();
    let mut image = CpuFilter::new(scene.target(), &optics, 1.0).unwrap().render(&optics).unwrap();
    image.data.iter_mut().for_each(|v| *v = GAIN * *v + VEIL);
    with_noise(&image, 0.005, 3)
}

/// The estimates of both backends, which must agree to a hundredth of a standard error: the solver stops there.
fn assert_same(name: &str, cpu: &ChannelFit, device: &ChannelFit) {
    for (id, found) in cpu.parameters.of_medium() {
        let parameter = found.name();
        let (a, b) = (found.value(), device.parameters[parameter].value());
        let error = cpu.covariance.std_error(id).unwrap() * found.slope();
        let off = (a - b).abs() / error;
        println!("{name:28} {parameter:8} {a:.6} {b:.6} {off:.1e} standard errors apart");
        assert!(off < 0.02, "{name}, {parameter}: {off} standard errors");
    }
    assert!((cpu.reduced_chi2 / device.reduced_chi2 - 1.0).abs() < 1e-4);
    assert_eq!(cpu.pixels, device.pixels);
}

#[test]
fn fits_equal_those_of_the_cpu() {
    let mask = Image::from_fn(64, 48, |x, y| if (x / 8 + y / 8) % 5 == 0 { 0.0 } else { 1.0 });
    let variance = Image::from_fn(64, 48, |x, _| 2.5e-5 * (0.2 + x as f32 / 8.0).powi(2));
    let plane = || Scene::new("plane", (64, 48), |_, _| 2.0);
    let uneven = Some(NoiseTerm::Variance(&variance));
    let cases = [
        ("a plane, all free", plane(), None, VeilTerm::Fixed(0.05), None),
        (
            "a slope, masked",
            Scene::slope((64, 48), 64).composite(),
            Some(&mask),
            VeilTerm::Free(VeilField::Constant),
            None,
        ),
        ("uneven noise", plane(), None, VeilTerm::Fixed(0.05), uneven),
    ];
    for (name, scene, mask, veil, noise) in &cases {
        let image = observed(scene);
        let observation = Observation {
            mask: *mask,
            noise: *noise,
            gain: if mask.is_some() { Gain::Free } else { Gain::Fixed(f64::from(GAIN)) },
            veil: *veil,
            ..Observation::plain(scene.target(), &image)
        };
        let fit = |backend| {
            // By renders alone, so that the device takes every step.
            let settings = Settings { backend, gram: false, ..Settings::default() };
            fit_channel(&[observation], &FitOptions::default(), &settings, &|| ()).unwrap()
        };
        assert_same(name, &fit(Backend::Cpu), &fit(Backend::Gpu(gpu())));
    }
}

#[test]
fn a_fit_of_another_image_is_told_apart() {
    let scene = Scene::new("plane", (64, 64), |_, _| 2.0);
    let image = observed(&scene);
    let other = Image { data: image.data.iter().map(|v| 0.999 * v).collect(), ..image.clone() };
    let fit = |observed| {
        let observation = Observation {
            gain: Gain::Fixed(f64::from(GAIN)),
            veil: VeilTerm::Fixed(f64::from(VEIL)),
            ..Observation::plain(scene.target(), observed)
        };
        fit_channel(&[observation], &FitOptions::default(), &Settings::default(), &|| ()).unwrap()
    };
    let (right, wrong) = (fit(&image), fit(&other));
    assert!(std::panic::catch_unwind(|| assert_same("a thousandth darker", &right, &wrong)).is_err());
}

/// The sums of one evaluation over a square depth map of `side` pixels.
fn evaluation(side: usize) {
    let scene = Scene::slope((side, side), side).composite();
    let optics = optics();
    let cpu = CpuFilter::new(scene.target(), &optics, 1.0).unwrap().render_with_gradient(&optics).unwrap();
    let observed = with_noise(&cpu.image, 0.005, 4);
    let filter = GpuFilter::new(gpu(), scene.target(), &optics, 1.0).unwrap();
    let observation = filter.observe(observed.data.iter().map(|&y| (y, 1.0))).unwrap();
    let device = filter.products(&optics, &observation, [1.0, 0.0], true, None).unwrap();
    let [s, a, b] = cpu.gradient.unwrap();
    let value = |image: &Image, at: usize| f64::from(image.data[at]);
    let images = |at: usize| {
        let m = value(&cpu.image, at);
        [m, value(&s, at), value(&a, at), value(&b, at), m - value(&observed, at), 1.0]
    };
    let mut exact = [[0.0; 6]; 6];
    for at in 0..side * side {
        let all = images(at);
        (0..6).for_each(|i| (0..6).for_each(|j| exact[i][j] += all[i] * all[j]));
    }
    let mut worst: f64 = 0.0;
    for i in 0..6 {
        for j in 0..6 {
            let size = (exact[i][i] * exact[j][j]).sqrt();
            worst = worst.max((device[(i, j)] - exact[i][j]).abs() / size);
        }
    }
    println!("{side}x{side}: sums apart by {worst:.1e} of the norms of the two images");
    // The images are 1e-6 apart, the residual, a 200th of them, is off by that 200-fold.
    assert!(worst < 2e-4, "{side}: {worst}");
}

#[test]
fn one_evaluation_equals_that_of_the_cpu() {
    [256, 512].into_iter().for_each(evaluation);
}

#[test]
#[ignore = "2 minutes on a software adapter; cargo test --release --test it larger -- --ignored --nocapture"]
fn one_larger_evaluation_equals_that_of_the_cpu() {
    [1024, 2048].into_iter().for_each(evaluation);
}

fn dataset(name: &str) {
    let cpu = bundled::fit(name, Model::SmallAngle, Filter::Auto);
    let scene = ObservedScene::read(&bundled::dataset(name).join("scene.toml")).unwrap();
    let settings = Settings { backend: Backend::Gpu(gpu()), ..Settings::default() };
    let device = fit_scenes(&[scene], &settings, Filter::Auto, &|| ()).unwrap();
    assert_eq!(device.report.backend.kind, "gpu");
    for ((_, cpu), (_, device)) in cpu.channels.iter().zip(&device.channels) {
        assert_same(name, cpu, device);
    }
}

/// What the CPU recovers within the tolerances of tests/it/recovery_datasets.rs, the device then recovers too.
#[test]
fn bundled_depth_maps_give_the_same_on_both_backends() {
    for name in ["mitsuba-slope", "traced-slope"] {
        dataset(name);
    }
}

#[test]
#[ignore = "4 minutes on a software adapter; cargo test --release --test it gpu::fits::staged -- --ignored --nocapture"]
fn staged_depth_maps_give_the_same_on_both_backends() {
    for name in ["mitsuba-planes", "mitsuba-tilt", "mitsuba-stage"] {
        dataset(name);
    }
}
