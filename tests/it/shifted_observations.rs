//! Observations that do not lie on the clear image: the shift is found, reported with its error, and does not bias the medium.

use crate::common::bundled::dataset;
use crate::common::program::{narrowbeam, refuses};
use crate::common::report::fit_scenes;
use narrowbeam::filter::{Backend, Filter, moved};
use narrowbeam::fit::{Fit, SceneFit, Settings, Status};
use narrowbeam::forward::Quantity;
use narrowbeam::image::{Image, View};
use narrowbeam::imaging::{Choice, Registration};
use narrowbeam::scene::ObservedScene;
use narrowbeam::spread::Model;
use std::path::{Path, PathBuf};

/// The medium of the images in tests/data/registration.
const TRUTH: [(&str, f64); 3] = [("sigma_s", 0.8), ("sigma_a", 0.08), ("b", 0.004_873_878_7)];

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/registration").join(name)
}

fn scene(name: &str) -> ObservedScene {
    ObservedScene::read(&file(name)).unwrap()
}

fn fit(scenes: &[ObservedScene], settings: &Settings) -> SceneFit {
    fit_scenes(scenes, settings, Filter::Auto, &|| ()).unwrap()
}

fn wide_angle() -> Settings<'static> {
    Settings { model: Model::WideAngle, ..Settings::default() }
}

fn unregistered(mut scene: ObservedScene) -> ObservedScene {
    scene.observation.registration = Choice::Is(Registration::None);
    scene
}

/// Largest distance of the estimates of two fits of one medium, in standard errors of the first.
fn apart(one: &SceneFit, other: &SceneFit) -> f64 {
    let (one, other) = (&one.channels[0].1, &other.channels[0].1);
    let off = |quantity| {
        let (here, there) = (one.parameters.of(quantity), other.parameters.of(quantity));
        let error = one.covariance.std_error(one.parameters.id(quantity)).expect("determined");
        (here.coordinate() - there.coordinate()).abs() / error
    };
    Quantity::MEDIUM.into_iter().map(off).fold(0.0, f64::max)
}

/// Shift of scene number `scene` and its standard errors, px.
fn shift(fit: &SceneFit, scene: usize) -> ([f64; 2], [f64; 2]) {
    let registration = fit.report.exposures[scene].registration.as_ref().expect("registered");
    (registration.shift_px, registration.std_errors.shift_px.map(|error| error.expect("determined")))
}

#[test]
fn a_photograph_gives_the_same_medium_wherever_it_was_sampled() {
    let still = fit(&[unregistered(scene("photograph-shifted-0.toml"))], &wide_angle());
    assert!(still.report.exposures[0].registration.is_none());
    let (origin, _) = shift(&fit(&[scene("photograph-shifted-0.toml")], &wide_angle()), 0);
    for by in [0.0, 0.1, 0.25] {
        let found = fit(&[scene(&format!("photograph-shifted-{by}.toml"))], &wide_angle());
        let ([x, y], errors) = shift(&found, 0);
        println!(
            "sampled {by} px to the right: shifted by {x:.4} ± {:.4}, {y:.4} ± {:.4} px; medium {:.2} standard errors off",
            errors[0],
            errors[1],
            apart(&still, &found)
        );
        // What is sampled to the right is seen to the left. One noise is in all three images: it cancels in the difference.
        assert!((x + by - origin[0]).abs() < 0.01 && (y - origin[1]).abs() < 0.01, "{by}: {x}, {y}");
        assert!((x + by).abs() < 3.0 * errors[0] && y.abs() < 3.0 * errors[1], "{by}: {x}, {y}");
        assert!(errors[0] < 0.01 && errors[1] < 0.01, "{errors:?}");
        assert!(apart(&still, &found) < 0.5, "{by}");
    }
}

#[test]
fn a_sharp_image_gives_its_shift_and_its_medium_which_it_does_not_if_it_is_taken_to_lie_still() {
    let found = fit(&[scene("sharp-shifted-0.3.toml")], &wide_angle());
    let ([x, y], _) = shift(&found, 0);
    assert!((x - 0.3).abs() < 0.01 && y.abs() < 0.01, "{x}, {y}");
    let error = |fit: &SceneFit, (name, truth): (&str, f64)| {
        (fit.report.parameters[name].value.unwrap() / truth - 1.0).abs()
    };
    for parameter in TRUTH {
        assert!(error(&found, parameter) < 0.03, "{parameter:?}: {:?}", found.report.parameters[parameter.0]);
    }
    let still = fit(&[unregistered(scene("sharp-shifted-0.3.toml"))], &wide_angle());
    assert!(error(&still, TRUTH[2]) > 0.03 && still.report.fit.reduced_chi2 > 2.0);
}

#[test]
fn renders_alone_find_the_shift_that_gram_matrices_begin_with() {
    let scenes = [scene("sharp-shifted-0.3.toml")];
    let both = fit(&scenes, &wide_angle());
    let alone = fit(&scenes, &Settings { gram: false, ..wide_angle() });
    assert_eq!((both.report.fit.path.as_str(), alone.report.fit.path.as_str()), ("sums", "renders"));
    assert!(apart(&both, &alone) < 0.1, "{}", apart(&both, &alone));
    let (([x, y], errors), ([u, v], _)) = (shift(&both, 0), shift(&alone, 0));
    assert!((x - u).abs() < 0.1 * errors[0] && (y - v).abs() < 0.1 * errors[1]);
}

/// A bundled scene whose observation is moved by `shift_px`, and cut to where nothing comes in from outside.
fn moved_dataset(name: &str, shift_px: [f64; 2], registration: Registration) -> ObservedScene {
    const EDGE: usize = 12;
    let mut scene = ObservedScene::read(&dataset(name).join("scene.toml")).unwrap();
    let View { x, y, width, height } = scene.scene.view;
    let inner = View { x: EDGE, y: EDGE, width: width - 2 * EDGE, height: height - 2 * EDGE };
    let image: &mut Image = &mut scene.observation.image[0].image;
    *image = moved(image, shift_px).unwrap().crop(inner);
    scene.scene.view = View { x: x + EDGE, y: y + EDGE, ..inner };
    scene.observation.registration = Choice::Is(registration);
    scene
}

#[test]
fn a_shift_of_pixels_and_fractions_is_found_on_a_plane_and_on_a_depth_map() {
    for (name, by) in [("mitsuba-checker", [1.7, -0.4]), ("mitsuba-slope", [-0.6, 1.7])] {
        let still = fit(&[moved_dataset(name, [0.0; 2], Registration::None)], &wide_angle());
        let found = fit(&[moved_dataset(name, by, Registration::Shift)], &wide_angle());
        let ([x, y], errors) = shift(&found, 0);
        println!("{name}: {x:.4} ± {:.4}, {y:.4} ± {:.4} px of {by:?}", errors[0], errors[1]);
        assert!((x - by[0]).abs() < 0.01 && (y - by[1]).abs() < 0.01, "{name}: {x}, {y}");
        assert!(apart(&still, &found) < 0.5, "{name}: {}", apart(&still, &found));
    }
}

#[test]
fn scenes_that_share_a_medium_have_a_shift_each() {
    let scenes = [
        moved_dataset("mitsuba-checker", [0.4, -0.3], Registration::Shift),
        moved_dataset("mitsuba-checker", [0.0; 2], Registration::None),
        moved_dataset("mitsuba-checker", [-1.2, 0.7], Registration::Shift),
    ];
    let found = fit(&scenes, &wide_angle());
    for (scene, by) in [(0, [0.4, -0.3]), (2, [-1.2, 0.7])] {
        let ([x, y], _) = shift(&found, scene);
        assert!((x - by[0]).abs() < 0.01 && (y - by[1]).abs() < 0.01, "{scene}: {x}, {y}");
    }
    assert!(found.report.exposures[1].registration.is_none());
    let names: Vec<&str> = found.channels[0].1.parameters.iter().map(|(_, p)| p.name()).collect();
    assert_eq!(
        names,
        ["sigma_s", "sigma_a", "b", "shift_x_px.1", "shift_y_px.1", "shift_x_px.3", "shift_y_px.3"]
    );
}

#[test]
fn a_scene_of_one_brightness_across_leaves_the_shift_across_undetermined() {
    let mut scene = moved_dataset("mitsuba-checker", [0.0; 2], Registration::Shift);
    let stripes = |image: &Image| {
        let row = |y: usize| if (y / 6).is_multiple_of(2) { 0.8 } else { 0.2 };
        Image::from_fn(image.width, image.height, |_, y| row(y))
    };
    scene.scene.border = narrowbeam::image::Border::Mirror;
    scene.scene.object[0].image = stripes(&scene.scene.object[0].image);
    let clear = scene.scene.object[0].image.crop(scene.scene.view);
    scene.observation.image[0].image = narrowbeam::fit::noise::with_noise(&clear, 0.01, 1);
    let found = fit(&[scene], &Settings::default());
    let errors = &found.report.exposures[0].registration.as_ref().unwrap().std_errors.shift_px;
    assert!(errors[0].is_none() && errors[1].is_some(), "{errors:?}");
    assert!(!found.report.is_complete());
}

#[test]
fn the_device_finds_the_shift_that_the_cpu_finds() {
    // From near the optimum, and by kernels that are cheap to make: what is compared is how both see the shift.
    let mut scene = scene("sharp-shifted-0.3.toml");
    let options = &mut scene.scene.fit[0];
    *options = options.started_at(|quantity| match quantity {
        Quantity::SigmaS => 0.9 * TRUTH[0].1,
        Quantity::SigmaA => 1.1 * TRUTH[1].1,
        _ => 1.2 * TRUTH[2].1,
    });
    let scenes = [scene];
    let settings = |backend| Settings { backend, gram: false, ..Settings::default() };
    let cpu = fit(&scenes, &settings(Backend::Cpu));
    let device = fit(&scenes, &settings(Backend::Gpu(crate::gpu::gpu())));
    assert_eq!(device.report.backend.kind, "gpu");
    // The solver stops within a hundredth of a standard error.
    assert!(apart(&cpu, &device) < 0.02, "{}", apart(&cpu, &device));
    let (([x, y], errors), ([u, v], _)) = (shift(&cpu, 0), shift(&device, 0));
    assert!((x - u).abs() < 0.02 * errors[0] && (y - v).abs() < 0.02 * errors[1], "{x} {u}, {y} {v}");
}

#[test]
fn the_program_reports_the_shift_and_refuses_what_it_cannot_register() {
    let dir = tempfile::tempdir().unwrap();
    let path = file("sharp-shifted-0.3.toml");
    let path = path.to_str().unwrap();
    let run = narrowbeam(dir.path(), &["fit", path, "--model", "wide-angle", "--json", "--out", "fit"]);
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
    let report: Fit = serde_json::from_slice(&run.stdout).unwrap();
    let registration = report.exposures[0].registration.as_ref().unwrap();
    assert!((registration.shift_px[0] - 0.3).abs() < 0.01 && registration.is_determined());
    assert!(report.parameters.values().all(|p| p.status == Status::Free) && report.parameters.len() == 3);
    assert!(String::from_utf8_lossy(&run.stderr).contains("px to the right"));

    refuses(dir.path(), &["fit", path, "--model", "traced", "--out", "no"], &["traced", "shift"]);
    let text = std::fs::read_to_string(path).unwrap().replace("\"shift\"", "\"warp\"");
    std::fs::write(dir.path().join("scene.toml"), text).unwrap();
    for name in ["sharp.exr", "sharp-shifted-0.3.exr"] {
        std::fs::copy(file(name), dir.path().join(name)).unwrap();
    }
    refuses(
        dir.path(),
        &["fit", "scene.toml"],
        &["[observation] registration", "warp", "none, shift, similarity"],
    );
}
