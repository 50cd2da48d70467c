//! The command `trace`.

use crate::common::program::{refuses, succeeds};
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::exr::{self, ExrFile};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const SIZE: usize = 16;
const SCENE: &str = "[object]
radiance = \"object.exr\"
depth = 2.0
border = \"clamp\"
[camera]
pixel_pitch = 0.05
";
const MEDIUM: &str = "[medium]
sigma_s = 0.95
sigma_a = 0.05
spread_angle_deg = 8.0
";

/// A folder with a small scene whose object has these channels, all alike.
fn folder(channels: &[&str], medium: &str) -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    let checker = Image::from_fn(SIZE, SIZE, |x, y| if (x / 4 + y / 4) % 2 == 0 { 1.0 } else { 0.2 });
    let channel = |name: &&str| Channel { name: name.to_string(), image: checker.clone() };
    let object: Vec<Channel> = channels.iter().map(channel).collect();
    exr::write(&dir.path().join("object.exr"), &object, &[]).unwrap();
    fs::write(dir.path().join("scene.toml"), format!("{SCENE}{medium}")).unwrap();
    dir
}

fn run(dir: &Path, more: &[&str]) -> String {
    succeeds(dir, &[&["trace", "scene.toml", "--output", "seen.exr"], more].concat())
}

fn pixels(dir: &Path, name: &str) -> Vec<f32> {
    ExrFile::read(&dir.join("seen.exr")).unwrap().named(name).unwrap().image.data
}

#[test]
fn image_variance_and_the_rate_come_out() {
    let dir = folder(&["Y"], MEDIUM);
    let said = run(dir.path(), &["--samples", "64"]);
    assert!(said.starts_with("traced 16384 paths in ") && said.ends_with(" million paths/s\n"), "{said}");
    assert_eq!(said.lines().count(), 1);
    let file = ExrFile::read(&dir.path().join("seen.exr")).unwrap();
    let names: Vec<&str> = file.all().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["Y", "Y.variance"]);
    assert!(file.all().iter().all(|c| (c.image.width, c.image.height) == (SIZE, SIZE)));
}

#[test]
fn the_rate_comes_as_json_too() {
    let dir = folder(&["Y"], MEDIUM);
    let traced: serde_json::Value =
        serde_json::from_str(&run(dir.path(), &["--samples", "4", "--seed", "7", "--json"])).unwrap();
    assert_eq!((&traced["paths"], &traced["seed"]), (&1024.into(), &7.into()));
    assert!(traced["paths_per_second"].as_f64().unwrap() > 0.0);
}

#[test]
fn the_variance_is_that_between_seeds() {
    let dir = folder(&["Y"], MEDIUM);
    let traced = |seed: &str| {
        run(dir.path(), &["--samples", "200", "--seed", seed]);
        (pixels(dir.path(), "Y"), pixels(dir.path(), "Y.variance"))
    };
    let ((a, va), (b, vb)) = (traced("1"), traced("2"));
    let score = |i: usize| f64::from(a[i] - b[i]).powi(2) / f64::from(va[i] + vb[i]);
    let mean = (0..a.len()).map(score).sum::<f64>() / a.len() as f64;
    // Chi² of 256 pixels over 256: its standard deviation is sqrt(2/256) = .09; four of them.
    assert!((mean - 1.0).abs() < 0.36, "{mean}");
}

#[test]
fn the_same_seed_gives_the_same_pixels() {
    let dir = folder(&["Y"], MEDIUM);
    let traced = |seed: &str| {
        run(dir.path(), &["--samples", "8", "--seed", seed]);
        (pixels(dir.path(), "Y"), pixels(dir.path(), "Y.variance"))
    };
    let first = traced("5");
    assert_eq!(first, traced("5"));
    assert_ne!(first, traced("6"));
}

#[test]
fn colours_are_traced_apart_from_each_other() {
    let dir = folder(&["R", "G", "B"], "[medium]\nsigma_s = [0.95, 0.95, 0.5]\nsigma_a = 0.05\nb = 0.005\n");
    let said = run(dir.path(), &["--samples", "4"]);
    assert!(said.starts_with("traced 3072 paths in "), "{said}");
    let file = ExrFile::read(&dir.path().join("seen.exr")).unwrap();
    let mut names: Vec<&str> = file.all().iter().map(|c| c.name.as_str()).collect();
    names.sort_unstable();
    assert_eq!(names, ["B", "B.variance", "G", "G.variance", "R", "R.variance"]);
    // The same object through the same medium, but other paths.
    assert_ne!(pixels(dir.path(), "R"), pixels(dir.path(), "G"));
}

#[test]
fn a_further_layer_is_seen_through_empty_pixels() {
    let dir = folder(&["Y"], MEDIUM);
    let write = |name: &str, channel: &str, image: Image| {
        exr::write(&dir.path().join(name), &[Channel { name: channel.into(), image }], &[]).unwrap();
    };
    write("depth.exr", "Z", Image::from_fn(SIZE, SIZE, |x, _| if x < 8 { 2.0 } else { 0.0 }));
    write("behind.exr", "Y", Image::filled(SIZE, SIZE, 3.0));
    let layer = "[[object.layer]]\nradiance = \"behind.exr\"\ndepth = 3.0\n[camera]";
    let scene = SCENE.replace("2.0", "\"depth.exr\"").replace("[camera]", layer);
    fs::write(dir.path().join("scene.toml"), format!("{scene}{MEDIUM}")).unwrap();
    run(dir.path(), &["--samples", "2", "--sigma-s", "0", "--sigma-a", "0"]);
    let seen = pixels(dir.path(), "Y");
    assert_eq!((seen[0], seen[7], seen[8], seen[SIZE - 1]), (1.0, 0.2, 3.0, 3.0));
    succeeds(dir.path(), &["render", "scene.toml", "--output", "render.exr"]);
}

#[test]
fn the_file_says_how_it_was_made() {
    let dir = folder(&["Y"], MEDIUM);
    run(dir.path(), &["--samples", "3", "--seed", "7", "--sigma-a", "0.25", "--b", "0.004"]);
    let meta = ::exr::meta::MetaData::read_from_file(dir.path().join("seen.exr"), false).unwrap();
    let attributes = &meta.headers[0].own_attributes;
    assert!(attributes.software_name.as_ref().unwrap().to_string().starts_with("narrowbeam "));
    let said = |key: &str| {
        let key = ::exr::prelude::Text::from(format!("narrowbeam:{key}").as_str());
        format!("{:?}", attributes.other[&key])
    };
    for (key, value) in
        [("seed", "7"), ("samples", "3"), ("sigma_s", "0.95"), ("sigma_a", "0.25"), ("b", "0.004")]
    {
        assert!(said(key).contains(&format!("\"{value}\"")), "{key}: {}", said(key));
    }
    assert!(said("command").contains("narrowbeam trace scene.toml"), "{}", said("command"));
}

#[test]
fn a_medium_may_come_from_the_command_line_and_a_missing_value_is_named() {
    let dir = folder(&["Y"], "[medium]\nsigma_s = 0.95\n");
    let trace = ["trace", "scene.toml", "--output", "seen.exr", "--samples", "2"];
    refuses(
        dir.path(),
        &[&trace[..], &["--sigma-a", "0"]].concat(),
        &["scene.toml", "[medium] b", "missing"],
    );
    let b = ["--spread-angle-deg", "8"];
    refuses(dir.path(), &[&trace[..], &b].concat(), &["scene.toml", "[medium] sigma_a", "missing"]);
    succeeds(dir.path(), &[&trace[..], &b, &["--sigma-a", "0"]].concat());
}

#[test]
fn bad_values_are_refused_by_option_before_anything_is_written() {
    let dir = folder(&["Y"], MEDIUM);
    let trace = ["trace", "scene.toml", "--output", "seen.exr"];
    for (option, value) in [
        ("--sigma-s", "-1"),
        ("--sigma-a", "NaN"),
        ("--b", "0"),
        ("--spread-angle-deg", "-8"),
        ("--samples", "1"),
        ("--seed", "-1"),
    ] {
        refuses(dir.path(), &[&trace[..], &[option, value]].concat(), &[option]);
    }
    refuses(dir.path(), &["trace", "scene.toml"], &["--output"]);
    refuses(dir.path(), &["trace", "none.toml", "--output", "seen.exr"], &["none.toml"]);
    let nowhere = ["trace", "scene.toml", "--output", "no/such/seen.exr"];
    refuses(dir.path(), &nowhere, &["no/such/seen.exr: cannot be written"]);
}
