//! What lies between the pixels of a clear image: constant pixels, or nothing beyond half a cycle a pixel.

use crate::common::planes::PLANE;
use crate::common::report::fit_scenes;
use crate::common::{pixels, relative_l2};
use narrowbeam::filter::basis::{Basis, combination};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::gpu::GpuFilter;
use narrowbeam::filter::{Filter, Optics, Target, direct_sum, per_depth};
use narrowbeam::fit::{Fit, Settings};
use narrowbeam::forward::{Engine, State, Tracing};
use narrowbeam::geometry::{Field, Geometry};
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::imaging::{Choice, Registration};
use narrowbeam::medium::Medium;
use narrowbeam::scene::ObservedScene;
use narrowbeam::spread::Model;
use std::f64::consts::PI;
use std::path::Path;

const SIZE: [usize; 2] = [32, 24];
const Z: f64 = 1.5;

fn optics(model: Model) -> Optics {
    Optics { model, medium: Medium::gaussian(0.9, 0.1, 0.004).unwrap() }
}

/// Length of a pixel with which the kernels are `width_px` wide.
fn pitch(width_px: f64) -> f64 {
    Z * 0.004_f64.sqrt() / width_px
}

/// One wave of `k` half cycles across and `l` down; its mirror images go on with it.
fn wave(k: usize, l: usize) -> Image {
    let along = |i: usize, half_cycles: usize, n: usize| {
        (PI * half_cycles as f64 * (i as f64 + 0.5) / n as f64).cos()
    };
    Image::from_fn(SIZE[0], SIZE[1], |x, y| (along(x, k, SIZE[0]) * along(y, l, SIZE[1])) as f32)
}

fn target<'a>(radiance: &'a Image, geometry: &'a Geometry, border: Border, sampling: Sampling) -> Target<'a> {
    let view = View::whole(radiance.width, radiance.height);
    Target { radiance, behind: &[], geometry, border, sampling, view, relief: None }
}

#[test]
fn a_wave_below_half_a_cycle_a_pixel_is_weakened_by_the_transfer_function() {
    let gpu = crate::gpu::gpu();
    for width_px in [0.3, 1.0, 4.0] {
        let geometry = Geometry::planar(SIZE[0], SIZE[1], pitch(width_px), Z).unwrap();
        for [k, l] in [[0, 0], [3, 0], [5, 7], [31, 2], [20, 23]] {
            let object = wave(k, l);
            let target = target(&object, &geometry, Border::Mirror, Sampling::Bandlimited);
            let optics = optics(Model::SmallAngle);
            let w = [k, l].into_iter().zip(SIZE).map(|(k, n)| PI * k as f64 / n as f64);
            let w = w.map(|w| w * w).sum::<f64>().sqrt();
            let weakened = optics.kernel(Z).unwrap().mtf(w / geometry.median_pixel_pitch()).value;
            let expected = || pixels(&object).map(|v| weakened * v);
            let render = |image: &Image| relative_l2(pixels(image), expected());
            let definition = relative_l2(per_depth::render(&target, &optics).unwrap(), expected());
            let cpu = render(&CpuFilter::new(target, &optics, 1.0).unwrap().render(&optics).unwrap());
            let device = render(&GpuFilter::new(gpu, target, &optics, 1.0).unwrap().render(&optics).unwrap());
            let basis = Basis::new(target).unwrap().unwrap();
            let weights: Vec<f64> = basis.weights(&optics).unwrap().iter().map(|w| w.value).collect();
            let sums = render(&combination(&weights, &basis.all_images()));
            println!(
                "{width_px} px, wave {k}, {l}: {definition:.1e} {cpu:.1e} {device:.1e}, sums {sums:.1e}"
            );
            // The object is f32; renders are, and interpolate in tables.
            assert!(definition < 1e-7 && cpu < 1e-5 && device < 1e-5, "{definition} {cpu} {device}");
            // The mixture of Gaussians is not asked for more than 1e-3.
            assert!(sums < 2e-3, "{sums}");
        }
    }
}

#[test]
fn the_definition_in_real_space_agrees_with_transforms() {
    let object = Image::from_fn(SIZE[0], SIZE[1], |x, y| ((7 * x + 13 * y + x * y) % 17) as f32 / 17.0);
    let depths = Image::from_fn(SIZE[0], SIZE[1], |x, _| if x < 20 { 1.0 } else { 1.5 });
    for width_px in [0.3, 1.0, 4.0] {
        let flat = Geometry::planar(SIZE[0], SIZE[1], pitch(width_px), Z).unwrap();
        let stepped = Geometry { depth: Field::Map(depths.clone()), ..flat.clone() };
        for (name, geometry) in [("plane", &flat), ("step", &stepped)] {
            let render = |sampling| {
                let target = target(&object, geometry, Border::Zero, sampling);
                let optics = optics(Model::SmallAngle);
                let fast = CpuFilter::new(target, &optics, 1.0).unwrap().render(&optics).unwrap();
                [
                    direct_sum::render(&target, &optics).unwrap(),
                    per_depth::render(&target, &optics).unwrap(),
                    pixels(&fast).collect(),
                ]
            };
            let [sum, transforms, fast] = render(Sampling::Bandlimited);
            let [pixel, _, _] = render(Sampling::Pixel);
            let (off, fast) = (relative_l2(transforms.clone(), sum.clone()), relative_l2(fast, transforms));
            let other = relative_l2(pixel, sum);
            println!("{name}, {width_px} px: {off:.1e}, fast {fast:.1e}; constant pixels {other:.1e}");
            // Rings fall like 1/d²: over the padding of a transform up to 1e-3 of them is left.
            assert!(off < 1e-3 && fast < 1e-4, "{name}, {width_px} px: {off} {fast}");
            assert!(other > 4.0 * off, "constant pixels pass for a band-limited image: {other}");
        }
    }
}

#[test]
fn traced_planes_know_both() {
    let geometry = Geometry::planar(SIZE[0], SIZE[1], pitch(1.0), Z).unwrap();
    let object = wave(20, 23);
    let medium = optics(Model::WideAngle).medium;
    let render = |model, sampling| {
        let engine = Engine { model, backend: narrowbeam::filter::Backend::Cpu, tracing: Tracing::default() };
        let target = target(&object, &geometry, Border::Mirror, sampling);
        engine.image(target, &State::from(medium), 0, 1.0).unwrap()
    };
    let traced = render(Model::Traced, Sampling::Bandlimited);
    let [same, other] = Sampling::ALL
        .map(|sampling| relative_l2(pixels(&traced), pixels(&render(Model::WideAngle, sampling))));
    println!("constant pixels {same:.1e}, band-limited {other:.1e}");
    // A million paths know the kernel to 0.2 %.
    assert!(other < 3e-3 && same > 1e-2, "{other} {same}");
}

#[test]
fn traced_depth_maps_refuse_what_they_do_not_know() {
    let depth = Image::from_fn(SIZE[0], SIZE[1], |x, _| 1.0 + 0.02 * x as f32);
    let flat = Geometry::planar(SIZE[0], SIZE[1], pitch(1.0), Z).unwrap();
    let slope = Geometry { depth: Field::Map(depth), ..flat };
    let object = wave(3, 2);
    let render = |sampling| {
        let tracing = Tracing::new(Some(1 << 14), 1);
        let engine = Engine { model: Model::Traced, backend: narrowbeam::filter::Backend::Cpu, tracing };
        let target = target(&object, &slope, Border::Mirror, sampling);
        engine.image(target, &State::from(optics(Model::WideAngle).medium), 0, 1.0)
    };
    assert!(render(Sampling::Pixel).is_ok());
    let error = render(Sampling::Bandlimited).unwrap_err();
    assert!(error.is_usage() && error.to_string().contains("band-limited"), "{error}");
}

/// The fit of what `made` shows, read as `read`; `known` tells whether that was stated.
fn refit(made: Sampling, read: Sampling, known: bool) -> Fit {
    let mut scene = PLANE.scene(Image::filled(PLANE.side, PLANE.side, 0.0), None).unwrap();
    let target = Target {
        radiance: &scene.scene.object[0].image,
        behind: &[],
        geometry: &scene.scene.geometry,
        border: Border::Zero,
        sampling: made,
        view: scene.scene.view,
        relief: None,
    };
    let optics = Optics { model: Model::WideAngle, medium: PLANE.medium };
    let image = CpuFilter::new(target, &optics, 1.0).unwrap().render(&optics).unwrap();
    let noise = 0.002 * image.mean();
    let seen = narrowbeam::fit::noise::with_noise(&image, noise, 3);
    scene.observation.image[0].image = seen;
    scene.observation.noise = Some(narrowbeam::scene::Noise::Level(noise));
    (scene.scene.sampling, scene.scene.sampling_is_known) = (read, known);
    let settings = Settings { model: Model::WideAngle, ..Settings::default() };
    fit_scenes(&[scene], &settings, Filter::Auto, &|| ()).unwrap().report
}

#[test]
fn an_image_read_as_it_was_made_gives_the_medium_and_one_that_may_be_either_says_so() {
    let off = |fit: &Fit| {
        let sigma_s = &fit.parameters["sigma_s"];
        (sigma_s.value.unwrap() - PLANE.medium.sigma_s()) / sigma_s.std_error.unwrap()
    };
    for sampling in Sampling::ALL {
        let right = refit(sampling, sampling, true);
        println!("{}: {:+.1} standard errors", sampling.name(), off(&right));
        assert!(off(&right).abs() < 4.0);
        assert!(!right.parameters["sigma_s"].model_errors.contains_key("sampling"));
        assert_eq!(right.exposures[0].sampling, sampling.name());
    }
    let wrong = refit(Sampling::Bandlimited, Sampling::Pixel, true);
    println!("read as constant pixels: {:+.1} standard errors", off(&wrong));
    assert!(off(&wrong).abs() > 4.0);
    let either = refit(Sampling::Bandlimited, Sampling::Pixel, false);
    let part = either.parameters["sigma_s"].model_errors["sampling"];
    let moved = (either.parameters["sigma_s"].value.unwrap() - PLANE.medium.sigma_s()).abs();
    println!("may be either: off by {moved:.2e}, half the difference {part:.2e}");
    assert!((0.25 * moved..moved).contains(&part), "{part} against {moved}");
    assert!(!either.exposures[0].sampling_is_known);
}

#[test]
fn a_photograph_that_a_lens_has_averaged_is_band_limited() {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/registration/photograph-shifted-0.toml");
    let fit = |sampling| {
        let mut scene = ObservedScene::read(&file).unwrap();
        scene.observation.registration = Choice::Is(Registration::None);
        (scene.scene.sampling, scene.scene.sampling_is_known) = (sampling, true);
        let settings = Settings { model: Model::WideAngle, ..Settings::default() };
        fit_scenes(&[scene], &settings, Filter::Auto, &|| ()).unwrap().report
    };
    // By Mitsuba: sigma_s 0.8, sigma_a 0.08, 8 degrees; a lens blurs both images by 0.6 px.
    let photograph = fit(Sampling::Bandlimited);
    for (name, truth) in [("sigma_s", 0.8), ("sigma_a", 0.08), ("b", 0.004_873_878_7)] {
        let [low, high] = photograph.parameters[name].ci95.unwrap();
        println!("{name}: {low:.5} to {high:.5}, {truth}");
        assert!((low..=high).contains(&truth), "{name}");
    }
}

#[test]
fn the_scene_file_states_it() {
    let folder = tempfile::TempDir::new().unwrap();
    let texture = PLANE.texture.image(32);
    crate::common::program::write_exr(&folder.path().join("object.exr"), &[("Y", texture)]);
    let read = |sampling: &str| {
        let path = folder.path().join("scene.toml");
        let text = format!(
            "[object]\nradiance = \"object.exr\"\ndepth = 2.0\n{sampling}[camera]\npixel_pitch = 0.1\n"
        );
        std::fs::write(&path, text).unwrap();
        narrowbeam::scene::Scene::read(&path).map(|scene| (scene.sampling, scene.sampling_is_known))
    };
    assert_eq!(read("sampling = \"bandlimited\"\n").unwrap(), (Sampling::Bandlimited, true));
    assert_eq!(read("sampling = \"pixel\"\n").unwrap(), (Sampling::Pixel, true));
    assert_eq!(read("").unwrap(), (Sampling::Pixel, false));
    let error = read("sampling = \"sharp\"\n").unwrap_err().to_string();
    assert!(error.contains("[object] sampling") && error.contains("sharp"), "{error}");
}
