//! What a camera does to the light is fitted along where the image asks for it, and not where it does not.

use crate::common::bundled;
use crate::common::report::fit_scenes;
use narrowbeam::filter::spline::{Waves, sampled};
use narrowbeam::filter::{Backend, Filter};
use narrowbeam::fit::{SceneFit, Settings, Status, free_camera};
use narrowbeam::forward::Quantity;
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::imaging::{Blur, Choice, GainField, Places, Registration, VeilField, Warp, WarpParameter};
use narrowbeam::scene::{ObservedScene, Veil};
use narrowbeam::spread::Model;
use std::path::Path;

/// The medium of the images in tests/data/faults that are seen from afar.
const TRUTH: [(&str, f64); 3] = [("sigma_s", 0.8), ("sigma_a", 0.08), ("b", 0.004_873_878_7)];

fn fault(name: &str) -> ObservedScene {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/faults");
    ObservedScene::read(&data.join(name)).unwrap()
}

/// All that a scene may leave to the fit.
fn open(mut scene: ObservedScene) -> ObservedScene {
    let observation = &mut scene.observation;
    (observation.registration, observation.blur) = (Choice::Auto, Choice::Auto);
    observation.gain_field = Choice::Auto;
    if observation.veil == Veil::Fixed(0.0) {
        observation.veil = Veil::Auto;
    }
    scene
}

fn fit(scene: ObservedScene) -> SceneFit {
    let settings = Settings { model: Model::WideAngle, ..Settings::default() };
    let fit = |scenes: &[ObservedScene]| fit_scenes(scenes, &settings, Filter::Auto, &|| ());
    free_camera(&mut [scene], fit, fit).unwrap()
}

fn set(fit: &SceneFit) -> Vec<&str> {
    fit.report.camera.iter().map(|step| step.set.as_str()).collect()
}

/// Relative errors of the estimates, which are all given as good.
fn errors(fit: &SceneFit, truth: [(&str, f64); 3]) -> [f64; 3] {
    truth.map(|(name, value)| {
        let found = &fit.report.parameters[name];
        assert_eq!(found.status, Status::Free, "{name}");
        found.value.unwrap() / value - 1.0
    })
}

#[test]
fn a_lens_a_veil_and_a_vignette_are_found_and_bias_nothing() {
    let cases = [
        ("blurred.toml", "blur_px = \"free\""),
        ("veil.toml", "veil = \"linear\""),
        ("vignette.toml", "gain_field = \"radial\""),
    ];
    let mut held = 0;
    for (name, key) in cases {
        let found = fit(open(fault(name)));
        println!("{name}: {:?}, {:?}", set(&found), errors(&found, TRUTH));
        assert!(set(&found).contains(&key), "{name}: {:?}", set(&found));
        let [sigma_s, sigma_a, b] = errors(&found, TRUTH);
        // The texture of these images is finer than their pixels: 0.6 % by what lies between them.
        assert!(sigma_s.abs() < 0.01 && sigma_a.abs() < 0.01 && b.abs() < 0.015, "{name}");
        held += TRUTH
            .into_iter()
            .filter(|(name, value)| {
                let [low, high] = found.report.parameters[*name].ci95.unwrap();
                low <= *value && *value <= high
            })
            .count();
        assert!(found.report.warnings.is_empty(), "{name}: {:?}", found.report.warnings);
    }
    // Of nine intervals of 95 % two or more miss once in fourteen times.
    assert!(held >= 8, "{held} of 9");
    // Without it the same images give other media.
    let stated = fit(fault("veil.toml"));
    assert!(stated.report.parameters["sigma_a"].value.unwrap() / TRUTH[1].1 < 0.7);
}

#[test]
fn the_numbers_of_the_camera_are_reported_with_their_errors() {
    let vignette = fit(open(fault("vignette.toml")));
    let radial = vignette.report.exposures[0].gain_field.as_ref().unwrap().terms["r2"];
    assert!((radial.value + 0.1).abs() < 0.005 && radial.std_error.unwrap() < 0.001, "{radial:?}");
    let veil = fit(open(fault("veil.toml")));
    let exposure = &veil.report.exposures[0];
    let slope = exposure.veil_field.as_ref().unwrap().terms["x"];
    // 0.02 to 0.06 from the left to the right edge, which are 1/√2 half diagonals from the middle.
    assert!((slope.value - 0.02 * 2f64.sqrt()).abs() < 0.001, "{slope:?}");
    assert!((exposure.veil.value - 0.04).abs() < 0.001);
}

#[test]
fn a_frame_that_ends_is_left_out_where_it_shows() {
    let mut scene = fault("outside.toml");
    scene.scene.border = Border::Unknown;
    let found = fit(scene);
    let exposure = &found.report.exposures[0];
    assert!(exposure.outside_pixels > 1000 && exposure.pixels > 1000);
    assert_eq!(exposure.outside_pixels + exposure.pixels, 128 * 128);
    let [sigma_s, sigma_a, b] = errors(&found, TRUTH);
    println!("{sigma_s}, {sigma_a}, {b}");
    assert!(sigma_s.abs() < 0.01 && sigma_a.abs() < 0.01 && b.abs() < 0.015);
    assert!(found.report.parameters["sigma_s"].model_errors.keys().any(|source| source == "frame"));
}

/// A photograph by a camera that is shifted, turned and nearer, cut to where nothing comes in from outside. What a lens has averaged
/// has a value between its pixels.
fn turned([turn, log_scale]: [f64; 2], shift_px: [f64; 2]) -> ObservedScene {
    const EDGE: usize = 26;
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/registration");
    let mut scene = ObservedScene::read(&data.join("photograph-shifted-0.toml")).unwrap();
    (scene.scene.sampling, scene.scene.sampling_is_known) = (Sampling::Bandlimited, true);
    let warp = Warp::default().with(WarpParameter::Rotation, turn).with(WarpParameter::LogScale, log_scale);
    let image: &mut Image = &mut scene.observation.image[0].image;
    let (width, height) = (image.width, image.height);
    let places = Places { width, height };
    let bend = warp.bend(places.half_diagonal_px()).unwrap();
    let from = |i: usize| {
        let [x, y] = bend.clear_place(places.px(i));
        [x - shift_px[0] + 0.5 * width as f64 - 0.5, y - shift_px[1] + 0.5 * height as f64 - 0.5]
    };
    let splines = [Waves::of(image).spline(0.0)];
    *image = sampled(&splines, (width, height), from).remove(0).image;
    let View { x, y, .. } = scene.scene.view;
    let inner = View { x: EDGE, y: EDGE, width: width - 2 * EDGE, height: height - 2 * EDGE };
    *image = image.crop(inner);
    scene.scene.view = View { x: x + EDGE, y: y + EDGE, ..inner };
    scene.observation.registration = Choice::Auto;
    scene
}

#[test]
fn turns_of_degrees_and_scales_of_percents_are_found() {
    let still = fit(turned([0.0; 2], [0.0; 2]));
    // The noise of this photograph moves it by 0.012 px.
    assert!(still.report.camera.is_empty(), "{:?}", set(&still));
    for (degrees, scale, shift_px) in [(0.2, 1.002, [0.3, -0.2]), (-5.0, 1.05, [6.0, -4.0])] {
        let found = fit(turned([f64::to_radians(degrees), f64::ln(scale)], shift_px));
        let registration = found.report.exposures[0].registration.as_ref().expect("registered");
        println!("{degrees}°, {scale}: {registration:?}");
        assert_eq!(registration.kind, "similarity");
        assert!((registration.rotation_deg.unwrap() - degrees).abs() < 0.02, "{degrees}");
        assert!((registration.scale.unwrap() - scale).abs() < 5e-4, "{scale}");
        assert!((0..2).all(|axis| (registration.shift_px[axis] - shift_px[axis]).abs() < 0.03));
        for name in ["sigma_s", "sigma_a", "b"] {
            let [a, b] = [&still, &found].map(|fit| fit.report.parameters[name].value.unwrap());
            // The scale of the image is also that of the kernel: the medium of an image 5 % larger is the same, seen with
            // larger pixels.
            let error = still.report.parameters[name].std_error.unwrap();
            println!("{name}: {:.2} standard errors", (a - b) / error);
            assert!((a - b).abs() < 3.0 * error, "{name}: {a}, {b} ± {error}");
        }
    }
}

#[test]
fn bundled_images_ask_for_nothing() {
    for name in ["mitsuba-natural", "mitsuba-checker", "traced-disks", "wide-30", "hg-90"] {
        let scene = ObservedScene::read(&bundled::dataset(name).join("scene.toml")).unwrap();
        assert_eq!(scene.observation.registration, Choice::Auto);
        let found = fit(open(scene));
        assert!(found.report.camera.is_empty(), "{name}: {:?}", set(&found));
    }
}

#[test]
fn derivatives_of_the_camera_are_those_of_its_images() {
    use narrowbeam::forward::{Engine, State, Tracing};
    use narrowbeam::imaging::Imaging;
    let scene = fault("veil.toml");
    let target = narrowbeam::filter::Target {
        view: View { x: 40, y: 30, width: 40, height: 36 },
        ..narrowbeam::filter::Target::plain(
            &scene.scene.object[0].image,
            &scene.scene.geometry,
            Border::Zero,
            View::whole(1, 1),
        )
    };
    let engine = Engine { model: Model::SmallAngle, backend: Backend::Cpu, tracing: Tracing::new(None, 1) };
    let mut imaging = Imaging::new(Registration::Homography, Blur::Free, GainField::Quadratic).unwrap();
    for (i, quantity) in Quantity::of_imaging(&imaging).into_iter().enumerate() {
        quantity.set_in_imaging(&mut imaging, 0.02 + 0.005 * i as f64);
    }
    let medium = narrowbeam::medium::Medium::gaussian(0.8, 0.08, 0.005).unwrap();
    let state = State { medium, shift_px: Some([0.4, -0.3]), imaging: Some(imaging) };
    let rendering = engine.prepare(target, &state, 1.0, 0).unwrap().rendering(&state).unwrap();
    let all = [Quantity::ShiftX].into_iter().chain(Quantity::of_imaging(&imaging));
    for quantity in all {
        let step = 1e-3;
        let at = |side: f64| {
            let mut state = state;
            match quantity {
                Quantity::ShiftX => state.shift_px = Some([0.4 + side * step, -0.3]),
                _ => {
                    let value = quantity.in_imaging(&imaging) + side * step;
                    quantity.set_in_imaging(state.imaging.as_mut().unwrap(), value);
                }
            }
            engine.image(target, &state, 0, 1.0).unwrap()
        };
        let (more, less) = (at(1.0), at(-1.0));
        let derivative = rendering.derivative(quantity).unwrap();
        let scale = derivative.data.iter().fold(0f32, |most, v| most.max(v.abs()));
        assert!(scale > 1e-3, "{quantity:?} changes nothing");
        for i in 0..derivative.data.len() {
            let expected = (more.data[i] - less.data[i]) / (2.0 * step as f32);
            let off = (derivative.data[i] - expected).abs();
            assert!(off < 0.02 * scale, "{quantity:?}, pixel {i}: {} {expected}", derivative.data[i]);
        }
    }
}

#[test]
fn a_veil_that_slopes_is_taken_off_by_gram_matrices_as_by_renders() {
    let mut scene = fault("veil.toml");
    scene.observation.veil = Veil::Free(VeilField::Quadratic);
    let settings = |gram| Settings { model: Model::SmallAngle, gram, ..Settings::default() };
    let fit = |gram| fit_scenes(&[scene.clone()], &settings(gram), Filter::Auto, &|| ()).unwrap().report;
    let (by_gram, by_renders) = (fit(true), fit(false));
    assert_eq!((by_gram.fit.path.as_str(), by_renders.fit.path.as_str()), ("sums", "renders"));
    for name in ["sigma_s", "sigma_a", "b"] {
        let [a, b] = [&by_gram, &by_renders].map(|fit| &fit.parameters[name]);
        let off = (a.value.unwrap() - b.value.unwrap()).abs() / a.std_error.unwrap();
        assert!(off < 0.05, "{name}: {off}");
    }
}

#[test]
fn a_whole_photograph_gives_its_medium_and_its_camera() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/photograph/scene.toml");
    let found = fit(ObservedScene::read(&data).unwrap());
    let exposure = &found.report.exposures[0];
    let registration = exposure.registration.as_ref().expect("registered");
    println!("{:?}: {registration:?}", set(&found));
    // Its maker says where each pixel looks: 1.003 times as far from the middle, and 0.25 and 0.6 px to the right and down.
    let [x, y] = registration.shift_px;
    assert!((x + 0.25).abs() < 0.02 && (y + 0.6).abs() < 0.02);
    let (scale, turn) = (registration.scale.unwrap(), registration.rotation_deg.unwrap());
    assert!((scale * 1.003 - 1.0).abs() < 2e-4 && turn.abs() < 0.01);
    assert!(exposure.outside_pixels > 0);
    let off = |name: &str, truth: f64| found.report.parameters[name].value.unwrap() / truth - 1.0;
    println!("{:+.3}, {:+.3}", off("sigma_s", 0.8), off("b", TRUTH[2].1));
    assert!(off("sigma_s", 0.8).abs() < 0.02 && off("b", TRUTH[2].1).abs() < 0.03);
    // The exposure is not known, so neither is the absorption.
    assert_eq!(found.report.parameters["sigma_a"].status, Status::Undetermined);
    assert!(found.report.warnings.iter().all(|w| w.severity < narrowbeam::fit::Severity::Invalid));
}
