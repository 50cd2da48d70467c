//! Bad input: exit code 2, one message that names the culprit, nothing written.

use super::workshop::{SCENE, SIDE, Workshop, texture};
use narrowbeam::image::Image;

/// Runs a fit that must be refused with one line that holds all of `words`.
fn refused(shop: &Workshop, words: &[&str]) {
    let run = shop.run("fit scene.toml --out result");
    assert_eq!(run.code, 2, "{}", run.stderr);
    assert_eq!(run.stderr.trim_end().lines().count(), 1, "{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "{word} is not in: {}", run.stderr);
    }
    assert!(run.stdout.is_empty() && !shop.file("result").exists());
}

fn sound() -> Workshop {
    let shop = Workshop::new();
    shop.observe(SCENE);
    shop
}

fn scene_refused(from: &str, to: &str, words: &[&str]) {
    let shop = sound();
    assert!(SCENE.contains(from));
    shop.write("scene.toml", &SCENE.replacen(from, to, 1));
    refused(&shop, words);
}

fn object_refused(change: impl Fn(&mut Image), words: &[&str]) {
    let shop = sound();
    let mut object = texture(0);
    change(&mut object);
    shop.put("object.exr", &[("Y", object)]);
    refused(&shop, words);
}

#[test]
fn a_missing_scene_file() {
    refused(&Workshop::new(), &["scene.toml"]);
}

#[test]
fn a_missing_image_file() {
    scene_refused("object.exr", "elsewhere.exr", &["elsewhere.exr"]);
}

#[test]
fn an_image_of_the_wrong_size() {
    let shop = sound();
    shop.put("observed.exr", &[("Y", Image::filled(SIDE + 1, SIDE, 0.5))]);
    refused(&shop, &["observed.exr", "49x48", "48x48"]);
}

#[test]
fn nan_radiance() {
    object_refused(|o| o.data[5 * SIDE + 7] = f32::NAN, &["object.exr", "(7, 5)", "NaN"]);
}

#[test]
fn negative_radiance() {
    object_refused(|o| o.data[2 * SIDE + 3] = -0.25, &["object.exr", "(3, 2)", "-0.25"]);
}

#[test]
fn nan_in_the_observation() {
    let shop = sound();
    let mut observed = texture(0);
    observed.data[SIDE] = f32::NAN;
    shop.put("observed.exr", &[("Y", observed)]);
    refused(&shop, &["observed.exr", "(0, 1)"]);
}

#[test]
fn a_black_object() {
    object_refused(|o| o.data.fill(0.0), &["object.exr", "black"]);
}

#[test]
fn a_uniform_object_with_clamped_border() {
    let shop = sound();
    shop.put("object.exr", &[("Y", Image::filled(SIDE, SIDE, 0.5))]);
    shop.write("scene.toml", &SCENE.replacen("depth = 2.0", "depth = 2.0\nborder = \"clamp\"", 1));
    refused(&shop, &["object.exr", "uniform"]);
}

#[test]
fn a_missing_key() {
    scene_refused("pixel_pitch = 0.03", "", &["scene.toml", "pixel_pitch"]);
}

#[test]
fn an_unknown_key() {
    scene_refused("depth = 2.0", "depth = 2.0\ndeep = 3", &["scene.toml", "deep"]);
}

#[test]
fn a_negative_sigma() {
    scene_refused("sigma_s = 0.8", "sigma_s = -0.8", &["scene.toml", "sigma_s", "-0.8"]);
}

#[test]
fn a_depth_before_the_surface() {
    scene_refused("depth = 2.0", "depth = 2.0\nsurface = 2.5", &["scene.toml", "surface"]);
}

#[test]
fn a_depth_of_zero() {
    scene_refused("depth = 2.0", "depth = 0.0", &["scene.toml", "depth"]);
}

#[test]
fn an_exr_without_the_channel() {
    let shop = sound();
    shop.put("object.exr", &[("mystery", texture(0))]);
    refused(&shop, &["object.exr", "Y", "mystery"]);
}

#[test]
fn a_truncated_exr() {
    let shop = sound();
    let bytes = std::fs::read(shop.file("object.exr")).unwrap();
    std::fs::write(shop.file("object.exr"), &bytes[..bytes.len() / 2]).unwrap();
    refused(&shop, &["object.exr"]);
}

#[test]
fn a_noise_of_zero() {
    scene_refused("[medium]", "noise = 0.0\n[medium]", &["scene.toml", "noise"]);
}

#[test]
fn a_fully_masked_image() {
    let shop = sound();
    shop.put("mask.exr", &[("Y", Image::filled(SIDE, SIDE, 0.0))]);
    shop.write("scene.toml", &SCENE.replacen("[medium]", "mask = \"mask.exr\"\n[medium]", 1));
    refused(&shop, &["mask.exr"]);
}

#[test]
fn every_parameter_fixed() {
    let shop = sound();
    shop.write(
        "scene.toml",
        &format!("{SCENE}[fit]\nfixed = {{ sigma_s = 1.0, sigma_a = 0.1, b = 0.004 }}\n"),
    );
    refused(&shop, &["fixed"]);
}

#[test]
fn a_directory_that_cannot_be_written() {
    let shop = sound();
    shop.write("taken", "a file, not a directory");
    let run = shop.run("fit scene.toml --out taken/result");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("taken"), "{}", run.stderr);
    let run = shop.run("render scene.toml --output taken/out.exr");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("taken/out.exr"), "{}", run.stderr);
}

#[test]
fn unknown_names_and_bare_usage() {
    let shop = sound();
    for (arguments, words) in [
        ("fit scene.toml --model wide", &["wide", "--model", "auto", "small-angle", "traced"][..]),
        ("fit scene.toml --filter best", &["best", "--filter", "auto", "eq29", "composite"]),
        ("fit scene.toml --backend tpu", &["tpu", "--backend", "auto", "cpu", "gpu"]),
        ("fit scene.toml --solver best", &["best", "--solver", "levenberg-marquardt", "nelder-mead"]),
        ("table --phase mie --out t", &["mie", "--phase", "gaussian", "hg"]),
        ("fit", &["SCENE.toml"]),
        ("", &["Usage"]),
        ("melt scene.toml", &["melt"]),
    ] {
        let run = shop.run(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stderr);
        for word in words {
            assert!(run.stderr.contains(word), "{arguments}: {word} is not in: {}", run.stderr);
        }
    }
}

#[test]
fn the_traced_model_where_a_kernel_is_needed() {
    let run = sound().run("forecast scene.toml --model traced --noise 0.01");
    assert_eq!(run.code, 2, "{}", run.stderr);
    for word in ["--model", "traced", "no kernel", "narrowbeam fit or render"] {
        assert!(run.stderr.contains(word), "{word} is not in: {}", run.stderr);
    }
}

#[test]
fn a_black_observation() {
    let shop = sound();
    shop.put("observed.exr", &[("Y", Image::filled(SIDE, SIDE, 0.0))]);
    refused(&shop, &["observed.exr", "black"]);
}

#[test]
fn a_radiance_beyond_what_can_be_summed() {
    object_refused(|o| o.data[9] = 3e38, &["object.exr", "(9, 0)"]);
}

#[test]
fn coefficients_beyond_what_can_be_traced() {
    let shop = sound();
    for option in ["--sigma-s 1e39", "--b 1e6", "--sigma-a inf"] {
        let run = shop.run(&format!("trace scene.toml {option} --samples 4 --output out.exr"));
        assert_eq!(run.code, 2, "{option}: {}", run.stderr);
        assert!(!shop.file("out.exr").exists());
    }
}

#[test]
fn an_output_that_is_a_directory_is_found_before_anything_is_written() {
    for name in ["fit.json", "hidden_share.exr"] {
        let shop = sound();
        std::fs::create_dir_all(shop.file("result").join(name)).unwrap();
        let run = shop.run("fit scene.toml --out result");
        assert_eq!(run.code, 2);
        assert!(run.stderr.contains(name), "{}", run.stderr);
        assert_eq!(std::fs::read_dir(shop.file("result")).unwrap().count(), 1);
    }
}
