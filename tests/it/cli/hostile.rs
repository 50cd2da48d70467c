//! Files that were made to exhaust the memory or to overflow: refused by name, in time, with nothing written.

use super::workshop::Workshop;
use exr::prelude::{AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage};
use narrowbeam::image::Image;
use std::path::Path;

/// A copy of the scene `name` of tests/data/hostile.
fn hostile(name: &str) -> Workshop {
    let shop = Workshop::new();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/hostile").join(name);
    for file in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        std::fs::copy(file.path(), shop.file(file.file_name().to_str().unwrap())).unwrap();
    }
    shop
}

/// Runs `arguments`, which must exit with `code` and one line that holds all of `words`.
fn refused(shop: &Workshop, arguments: &str, code: i32, words: &[&str]) {
    let run = shop.run(arguments);
    assert_eq!(run.code, code, "{arguments}: {}", run.stderr);
    let said: Vec<&str> = run.stderr.lines().filter(|line| !line.starts_with("warning (")).collect();
    assert!(matches!(said[..], [line] if line.len() < 600), "{}", run.stderr);
    for word in words {
        assert!(run.stderr.contains(word), "{word} is not in: {}", run.stderr);
    }
    assert!(run.stdout.is_empty() && !shop.file("out.exr").exists() && !shop.file("result").exists());
}

const RENDER: &str = "render scene.toml --output out.exr";
const FIT: &str = "fit scene.toml --out result";

#[test]
fn numbers_that_overflow_later_are_refused_at_the_door() {
    refused(&hostile("scale1e20"), FIT, 2, &["object.exr", "channel Y", "pixel (", "at most 1e15"]);
    refused(&hostile("veil1e30"), FIT, 2, &["scene.toml: line 19, column 1", "[observation] veil = 1e30"]);
    let synthesize = "synthesize scene.toml --output out.exr";
    let words = ["scene.toml: line 12, column 1", "[illumination] irradiance = 1e43"];
    refused(&hostile("synthinf"), synthesize, 2, &words);
    refused(&hostile("z0"), RENDER, 2, &["f.exr: depth - surface at pixel (", "billionth"]);
}

#[test]
fn a_block_that_promises_a_tebibyte_is_not_believed() {
    refused(&hostile("dwa"), RENDER, 2, &["f.exr", "promises 1099511627776 bytes"]);
}

#[test]
fn pixels_that_are_not_square_are_refused() {
    refused(&hostile("pixel-aspect"), RENDER, 2, &["object.exr", "pixelAspectRatio is 2"]);
}

#[test]
fn a_plan_larger_than_the_budget_is_refused_with_its_size() {
    let words =
        ["36 depth slices", "16x16 px", "4096x4096 px", "GiB of memory", "leaves 1.0 GiB", "--memory"];
    refused(&hostile("depth7gb"), &format!("{RENDER} --memory 1GiB"), 1, &words);
}

#[test]
fn an_image_larger_than_the_budget_is_refused_with_its_size() {
    let shop = hostile("dwa");
    let channel = AnyChannel::new("Y", FlatSamples::F32(vec![0.0; 2048 * 2048]));
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let layer = Layer::new((2048, 2048), LayerAttributes::named("main"), Encoding::SMALL_LOSSLESS, channels);
    exr::prelude::Image::from_layer(layer).write().to_file(shop.file("f.exr")).unwrap();
    assert!(std::fs::metadata(shop.file("f.exr")).unwrap().len() < 100_000);
    let words = ["f.exr: 2048x2048 px in 1 channels", "48.0 MiB", "leaves 38.1 MiB", "--memory"];
    refused(&shop, &format!("{RENDER} --memory 40MB"), 2, &words);
}

#[test]
fn pipes_devices_and_folders_are_no_images() {
    let shop = hostile("z0");
    let scene = std::fs::read_to_string(shop.file("scene.toml")).unwrap();
    for (file, what) in [("/dev/zero", "pipe or a device"), ("/", "folder")] {
        shop.write("scene.toml", &scene.replace("f.exr", file));
        refused(&shop, RENDER, 2, &[file, what]);
        refused(&shop, &format!("render {file} --output out.exr"), 2, &[file, what]);
    }
}

#[test]
fn a_name_with_a_line_break_stays_on_one_line() {
    let shop = hostile("z0");
    let scene = std::fs::read_to_string(shop.file("scene.toml")).unwrap();
    shop.write("scene.toml", &scene.replace("f.exr", "a\\nb\\u001b[2K.exr"));
    refused(&shop, RENDER, 2, &["a\\nb\\u{1b}[2K.exr: cannot be read"]);
}

#[test]
fn an_extension_that_is_not_written_is_refused() {
    let shop = hostile("z0");
    for command in ["render", "trace", "synthesize"] {
        let run = shop.run(&format!("{command} scene.toml --output picture.jpg"));
        assert_eq!(run.code, 2);
        assert!(run.stderr.contains("must end in .exr"), "{}", run.stderr);
    }
}

#[test]
fn a_wrong_channel_says_what_asked_for_it() {
    let shop = Workshop::new();
    let grey = Image::filled(8, 8, 0.5);
    shop.put("object.exr", &["R", "G", "B"].map(|name| (name, grey.clone())));
    shop.put("observed.exr", &[("Y", grey)]);
    shop.write(
        "scene.toml",
        "object = { radiance = \"object.exr\", depth = 1 }\ncamera = { pixel_pitch = 1 }\nobservation = { image = \"observed.exr\" }\n",
    );
    let words = ["observed.exr: has no channel R, G, B (the object has R, G, B); it holds Y"];
    refused(&shop, FIT, 2, &words);
}
