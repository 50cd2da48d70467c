//! `render`: overrides and what must be given.

use super::workshop::{SCENE, SIDE, Workshop, striped, texture};
use narrowbeam::io::exr::ExrFile;
use narrowbeam::io::picture::Picture;

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

#[test]
fn the_share_of_hidden_light_is_written_as_numbers_or_as_a_picture() {
    let shop = Workshop::new();
    shop.put("object.exr", &[("R", texture(0)), ("G", texture(1)), ("B", texture(2))]);
    let scene = striped(&shop, SIDE / 2).replace("sigma_s = 0.8", "sigma_s = [0.4, 0.8, 1.2]");
    shop.write("scene.toml", &scene);
    for share in ["share.exr", "share.PNG"] {
        let run = shop.run(&format!("render scene.toml --output out.exr --hidden-share {share}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let share = ExrFile::read(&shop.file("share.exr")).unwrap().radiance().unwrap();
    assert_eq!(share.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["R", "G", "B"]);
    // Hidden light comes round the edge, to the far side above all, and more of it the more is scattered.
    let at = |c: usize, x: usize| share[c].image.at(x, SIDE / 2);
    assert!(at(1, SIDE / 2 + 1) > 0.01 && at(1, SIDE - 3) < 1e-3 && at(1, SIDE / 4) < 1e-3);
    assert!(at(0, SIDE / 2 + 1) < at(1, SIDE / 2 + 1) && at(1, SIDE / 2 + 1) < at(2, SIDE / 2 + 1));
    let picture = image::open(shop.file("share.PNG")).unwrap();
    assert!(picture.width() > 300 && picture.height() > 300);
    shop.write("scene.toml", SCENE);
    assert_eq!(shop.run("render scene.toml --output out.exr --hidden-share none.exr").code, 0);
    assert_eq!(mean(&shop, "none.exr"), 0.0);
}

#[test]
fn a_share_of_hidden_light_that_cannot_be_had_is_refused() {
    let shop = Workshop::new();
    shop.write("scene.toml", &striped(&shop, SIDE / 2));
    shop.write("taken", "a file, not a directory");
    for (options, words) in [
        ("--hidden-share share.tiff", ["share.tiff", ".exr or .png"]),
        ("--hidden-share share", ["share", ".exr or .png"]),
        ("--hidden-share share.exr --filter eq29", ["share.exr", "eq29"]),
        ("--hidden-share out.exr", ["out.exr", "--output"]),
        ("--hidden-share taken/share.exr", ["taken/share.exr", "cannot be written"]),
    ] {
        let run = shop.run(&format!("render scene.toml --output out.exr {options}"));
        assert_eq!(run.code, 2, "{options}: {}", run.stderr);
        assert!(words.iter().all(|word| run.stderr.contains(word)), "{}", run.stderr);
        assert!(!shop.file("out.exr").exists() && !shop.file("share.exr").exists());
    }
}

#[test]
fn images_are_written_in_the_format_of_their_name() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE);
    assert_eq!(shop.run("render scene.toml --output out.exr").code, 0);
    let written = Picture::read(&shop.file("out.exr")).unwrap().file.radiance().unwrap();
    for name in ["out.tif", "out.pfm", "out.hdr"] {
        assert_eq!(shop.run(&format!("render scene.toml --output {name}")).code, 0, "{name}");
        let read = Picture::read(&shop.file(name)).unwrap().file.all()[0].image.clone();
        // Radiance HDR has eight bits.
        let bound = if name == "out.hdr" { 1.0 / 128.0 } else { 0.0 };
        for (a, b) in written[0].image.data.iter().zip(&read.data) {
            assert!((a - b).abs() <= bound * a, "{name}: {a} {b}");
        }
    }
    assert_eq!(shop.run("trace scene.toml --samples 2 --output traced.tif").code, 0);
    assert_eq!(Picture::read(&shop.file("traced.tif")).unwrap().file.all().len(), 1);
    assert_eq!(shop.run("render scene.toml --output picture.png").code, 0);
    assert!(Picture::read(&shop.file("picture.png")).unwrap().codes.is_some());
    for command in ["render", "trace"] {
        let run = shop.run(&format!("{command} scene.toml --output out.jpg"));
        assert_eq!(run.code, 2, "{}", run.stderr);
        assert!(run.stderr.contains("--output") && run.stderr.contains(".tif"), "{}", run.stderr);
    }
}
