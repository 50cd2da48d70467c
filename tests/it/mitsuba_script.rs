//! The script that makes Mitsuba datasets, run afresh on a small scene and its image fitted.

use crate::common::estimates::compare_all;
use crate::common::report::fit_scenes;
use narrowbeam::filter::Filter;
use narrowbeam::fit::Settings;
use narrowbeam::forward::Quantity;
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::exr;
use narrowbeam::medium::Medium;
use narrowbeam::scene::ObservedScene;
use std::path::Path;
use std::process::Command;

fn python() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let output = Command::new(root.join("scripts/mitsuba_env.sh")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().last().unwrap().to_string()
}

#[test]
fn a_fresh_mitsuba_image_gives_its_medium_back() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let object = Image::from_fn(64, 64, |x, y| if (x / 6 + y / 9) % 2 == 0 { 0.9 } else { 0.2 });
    exr::write(&file("object.exr"), &[Channel { name: "Y".into(), image: object }], &[]).unwrap();
    let scene = "[object]\nradiance = \"object.exr\"\ndepth = 1.0\n[camera]\npixel_pitch = 0.012\n\
                 [observation]\nimage = \"observed.exr\"\n";
    std::fs::write(file("scene.toml"), scene).unwrap();
    let truth = "[medium]\nsigma_s = 1.0\nsigma_a = 0.1\nspread_angle_deg = 8.0\n";
    std::fs::write(file("truth.toml"), truth).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/observe_mitsuba.py");
    let run = Command::new(python())
        .args([script, file("scene.toml"), file("truth.toml"), "--output".into(), file("observed.exr")])
        .args(["--samples", "256", "--seed", "1", "--variant", "scalar_rgb"])
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));

    let scene = ObservedScene::read(&file("scene.toml")).unwrap();
    let fit = fit_scenes(&[scene], &Settings::default(), Filter::Eq29, &|| ()).unwrap();
    let (_, channel) = &fit.channels[0];
    let truth = Medium::gaussian(1.0, 0.1, (8.0_f64.to_radians()).powi(2) / 4.0).unwrap();
    for found in compare_all(channel, truth) {
        // The datasets' promise at z = 1, and three standard errors of this small image's noise.
        let promise = match found.quantity {
            Quantity::SigmaS => 0.03,
            Quantity::SigmaA => 0.02,
            _ => 0.05 * found.truth,
        };
        let noise = 3.0 * found.parameter.slope() * found.std_error.unwrap();
        println!("{} {:.5} ± {:.5}, truth {:.5}", found.name(), found.value(), noise / 3.0, found.truth);
        assert!(found.error().abs() < promise + noise, "{}: {}", found.name(), found.value());
    }
}
