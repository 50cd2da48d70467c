//! `render`: overrides and what must be given.

use crate::workshop::{SCENE, Workshop};
use narrowbeam::io::exr::ExrFile;

fn mean(shop: &Workshop, name: &str) -> f64 {
    ExrFile::read(&shop.file(name)).unwrap().radiance().unwrap()[0].image.mean()
}

#[test]
fn the_command_line_overrides_the_scene_s_medium() {
    let shop = Workshop::new();
    shop.write("scene.toml", &SCENE.replace("zero", "mirror"));
    assert_eq!(shop.run("render scene.toml --sigma-s 0 --sigma-a 0.5 --output out.exr").code, 0);
    let ratio = mean(&shop, "out.exr") / mean(&shop, "object.exr");
    assert!((ratio - (-1.0_f64).exp()).abs() < 1e-6, "{ratio}");
}

#[test]
fn a_spread_angle_stands_for_b() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE);
    assert_eq!(shop.run("render scene.toml --spread-angle-deg 8 --output angle.exr").code, 0);
    assert_eq!(shop.run("render scene.toml --b 0.004873878716587337 --output b.exr").code, 0);
    assert_eq!(mean(&shop, "angle.exr"), mean(&shop, "b.exr"));
    assert_eq!(shop.run("render scene.toml --b 0.1 --spread-angle-deg 8 --output no.exr").code, 2);
}

#[test]
fn a_missing_medium_is_named() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE.split("[medium]").next().unwrap());
    let run = shop.run("render scene.toml --sigma-s 1 --output out.exr");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("sigma_a"), "{}", run.stderr);
    assert!(!shop.file("out.exr").exists());
}

#[test]
fn a_failed_render_leaves_the_old_file() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE);
    shop.write("out.exr", "precious");
    assert_eq!(shop.run("render scene.toml --sigma-s -1 --output out.exr").code, 2);
    assert_eq!(std::fs::read_to_string(shop.file("out.exr")).unwrap(), "precious");
}

#[test]
fn an_opaque_medium_renders_black() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE);
    for sigma_a in ["371.5", "372", "1e6"] {
        let run = shop.run(&format!("render scene.toml --sigma-a {sigma_a} --output out.exr"));
        assert_eq!(run.code, 0, "{sigma_a}: {}", run.stderr);
        assert!(mean(&shop, "out.exr").abs() < 1e-30);
    }
}

#[test]
fn a_kernel_cut_by_the_padding_is_warned_of() {
    let shop = Workshop::new();
    shop.write("scene.toml", &SCENE.replace("pixel_pitch = 0.03", "pixel_pitch = 0.00003"));
    let run = shop.run("render scene.toml --output out.exr");
    assert_eq!(run.code, 0);
    assert!(run.stderr.contains("kernel_cut"), "{}", run.stderr);
}
