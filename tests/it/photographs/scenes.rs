//! Scene files that name photographs.

use super::made::{codes, jpeg_with_exif, png, png_chunk, tiff16};
use crate::common::program::write_exr;
use narrowbeam::Error;
use narrowbeam::image::{Image, Sampling};
use narrowbeam::scene::{CautionCode, ObservedScene};
use std::path::Path;

const SIDE: u32 = 12;

/// Codes of a picture in which no two neighbours are the same.
fn texture(x: u32, y: u32) -> u16 {
    (40 + (37 * x + 61 * y + 11 * x * y) % 180) as u16
}

fn all() -> Vec<u16> {
    (0..SIDE * SIDE).map(|i| texture(i % SIDE, i / SIDE)).collect()
}

/// Reads the scene with these lines in `[object]` and `[observation]`.
fn read(dir: &Path, object: &str, observation: &str) -> Result<ObservedScene, Error> {
    let text = format!(
        "[object]\nradiance = \"clear.png\"\n{object}\n[camera]\npixel_pitch = 0.01\n[observation]\n{observation}\n"
    );
    std::fs::write(dir.join("scene.toml"), text).unwrap();
    ObservedScene::read(&dir.join("scene.toml"))
}

fn folder() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("clear.png"), png(SIDE, SIDE, 1, &all(), &[])).unwrap();
    dir
}

const TURBID: &str = "image = \"clear.png\"\ntransfer = \"srgb\"";

fn message(read: Result<ObservedScene, Error>) -> String {
    read.unwrap_err().to_string()
}

#[test]
fn curves_are_undone_for_object_and_observation_alike() {
    let dir = folder();
    let scene = read(dir.path(), "depth = 2.0\ntransfer = 2.0", TURBID).unwrap();
    let code = f64::from(texture(3, 5)) / 255.0;
    let clear = f64::from(scene.scene.object[0].image.at(3, 5));
    let seen = f64::from(scene.observation.image[0].image.at(3, 5));
    assert!((clear - code * code).abs() < 1e-7);
    assert!((seen - ((code + 0.055) / 1.055).powf(2.4)).abs() < 1e-7);
    assert_eq!((scene.scene.sampling, scene.scene.sampling_is_known), (Sampling::Bandlimited, true));
    std::fs::write(dir.path().join("response.csv"), "value,radiance\n0,0\n255,510\n").unwrap();
    let scene = read(dir.path(), "depth = 2.0\ntransfer = \"response.csv\"", TURBID).unwrap();
    assert_eq!(scene.scene.object[0].image.at(3, 5), 2.0 * f32::from(texture(3, 5)));
}

#[test]
fn a_transfer_that_is_not_stated_is_refused_with_advice() {
    let dir = folder();
    let object = message(read(dir.path(), "depth = 2.0", TURBID));
    for word in ["[object] transfer is missing", "clear.png", "8-bit PNG", "srgb", "linear"] {
        assert!(object.contains(word), "{object}");
    }
    let observation = message(read(dir.path(), "depth = 2.0\ntransfer = \"srgb\"", "image = \"clear.png\""));
    assert!(observation.contains("[observation] transfer is missing"), "{observation}");
    let wrong = message(read(dir.path(), "depth = 2.0\ntransfer = \"sRGB\"", TURBID));
    assert!(wrong.contains("sRGB"), "{wrong}");
    let wild = message(read(dir.path(), "depth = 2.0\ntransfer = 0.0", TURBID));
    assert!(wild.contains("[object] transfer = 0: must be from 0.1 to 10"), "{wild}");
    std::fs::write(dir.path().join("short.csv"), "value,radiance\n50,0\n255,1\n").unwrap();
    let short = message(read(dir.path(), "depth = 2.0\ntransfer = \"short.csv\"", TURBID));
    assert!(short.contains("pixel (0, 0)") && short.contains("response curve"), "{short}");
}

#[test]
fn a_transfer_beside_floats_is_refused() {
    let dir = folder();
    write_exr(&dir.path().join("seen.exr"), &[("Y", Image::from_fn(12, 12, |x, y| (x * y) as f32 + 0.5))]);
    let beside =
        message(read(dir.path(), "depth = 2.0\ntransfer = 2.2", "image = \"seen.exr\"\ntransfer = \"srgb\""));
    assert!(
        beside.contains("[observation] transfer is given, but") && beside.contains("seen.exr"),
        "{beside}"
    );
    assert!(
        read(dir.path(), "depth = 2.0\ntransfer = 2.2", "image = \"seen.exr\"\ntransfer = \"linear\"")
            .is_ok()
    );
}

#[test]
fn a_chunk_that_contradicts_the_transfer_is_a_caution() {
    let dir = folder();
    std::fs::write(dir.path().join("clear.png"), png(SIDE, SIDE, 1, &all(), &png_chunk(b"sRGB", &[0])))
        .unwrap();
    let scene = read(dir.path(), "depth = 2.0\ntransfer = \"linear\"", TURBID).unwrap();
    let [caution] = &scene.scene.cautions[..] else { panic!("one caution") };
    assert_eq!(caution.code, CautionCode::Transfer);
    assert!(caution.message.contains("sRGB chunk of") && caution.message.contains("clear.png"));
    assert!(scene.observation.cautions.is_empty());
}

#[test]
fn integer_depth_maps_need_a_scale() {
    let dir = folder();
    let path = dir.path().join("depth.tif");
    std::fs::write(&path, tiff16(SIDE, SIDE, 1, &vec![1500; (SIDE * SIDE) as usize])).unwrap();
    let with = |lines: &str| {
        read(dir.path(), &format!("transfer = \"srgb\"\ndepth = \"depth.tif\"\n{lines}"), TURBID)
    };
    let depth = with("depth_scale = 0.001").unwrap().scene.geometry.object_distance(2, 2).unwrap();
    assert!((depth - 1.5).abs() < 1e-6);
    let missing = message(with(""));
    assert!(
        missing.contains("[object] depth_scale is missing") && missing.contains("16-bit TIFF"),
        "{missing}"
    );
    assert!(message(with("depth_scale = 0.0")).contains("depth_scale = 0: must be above 0"));
    write_exr(&dir.path().join("depth.exr"), &[("Z", Image::filled(12, 12, 1.5))]);
    let floats = read(dir.path(), "transfer = \"srgb\"\ndepth = \"depth.exr\"\ndepth_scale = 0.001", TURBID);
    assert!(message(floats).contains("holds lengths already"));
    std::fs::write(dir.path().join("depth.jpg"), jpeg_with_exif(SIDE, SIDE, |_, _| 90, 1)).unwrap();
    let lossy = read(dir.path(), "transfer = \"srgb\"\ndepth = \"depth.jpg\"\ndepth_scale = 0.01", TURBID);
    assert!(message(lossy).contains("JPEG"));
}

#[test]
fn a_mask_may_be_a_grey_picture_in_three_colours() {
    let dir = folder();
    let mask: Vec<u16> = (0..SIDE * SIDE).flat_map(|i| [if i % SIDE < 4 { 0 } else { 255 }; 3]).collect();
    std::fs::write(dir.path().join("mask.png"), png(SIDE, SIDE, 3, &mask, &[])).unwrap();
    let scene =
        read(dir.path(), "depth = 2.0\ntransfer = \"srgb\"", &format!("{TURBID}\nmask = \"mask.png\""));
    let mask = scene.unwrap().observation.mask.unwrap();
    assert_eq!((mask.at(3, 0), mask.at(4, 0)), (0.0, 1.0));
}

#[test]
fn saturated_pixels_are_left_out_with_their_neighbours_and_counted() {
    let dir = folder();
    let scene = |lines: &str| {
        read(
            dir.path(),
            "depth = 2.0\ntransfer = \"linear\"",
            &format!("image = \"clear.png\"\ntransfer = \"linear\"\n{lines}"),
        )
    };
    assert_eq!(scene("").unwrap().observation.saturated_pixels, 0);
    let mut sorted = all();
    sorted.sort_unstable();
    let bright = sorted[sorted.len() - 4];
    let level = f64::from(bright) / 255.0;
    let reached = |i: u32| texture(i % SIDE, i / SIDE) >= bright;
    let near = |i: u32| {
        let (x, y) = (i % SIDE, i / SIDE);
        let around = (y.saturating_sub(1)..(y + 2).min(SIDE))
            .flat_map(|v| (x.saturating_sub(1)..(x + 2).min(SIDE)).map(move |u| v * SIDE + u));
        around.into_iter().any(reached)
    };
    let expected = (0..SIDE * SIDE).filter(|i| near(*i)).count();
    assert!(expected > 9 && expected < (SIDE * SIDE) as usize);
    let observation = scene(&format!("saturation = {level}")).unwrap().observation;
    assert_eq!(observation.saturated_pixels, expected);
    assert_eq!(observation.mask.unwrap().data.iter().filter(|v| **v == 0.0).count(), expected);
    let all = message(scene("saturation = 0.01"));
    assert!(all.contains("every pixel that counts is saturated"), "{all}");
}

#[test]
fn noise_is_a_number_a_sensor_or_an_image() {
    let dir = folder();
    let noise = |value: &str| {
        read(dir.path(), &format!("depth = 2.0\ntransfer = \"srgb\"\nnoise = {value}"), TURBID)
            .map(|scene| scene.scene.object_noise)
    };
    assert!(noise("{ read = 0.001, shot = 0.006 }").unwrap().is_some());
    assert!(noise("0.01").unwrap().is_some());
    let refused = |value: &str| noise(value).unwrap_err().to_string();
    assert!(refused("0.0").contains("[object] noise = 0: must be above 0"));
    assert!(refused("{ read = 0.001 }").contains("shot"));
    assert!(refused("{ read = 0.001, shot = 0.1, more = 1 }").contains("shot"));
    assert!(refused("{ read = 0.0, shot = 0.1 }").contains("[object] noise read = 0"));
    std::fs::write(dir.path().join("v.png"), png(SIDE, SIDE, 1, &codes(&[9; 144]), &[])).unwrap();
    assert!(refused("\"v.png\"").contains("variances are floats"));
}

#[test]
fn negative_radiance_needs_noise_that_explains_it() {
    let dir = folder();
    write_exr(&dir.path().join("object.exr"), &[("Y", Image::from_fn(12, 12, |x, y| (x * y) as f32 - 0.5))]);
    let with = |noise: &str| {
        let text = format!(
            "[object]\nradiance = \"object.exr\"\ndepth = 2.0\n{noise}\n[camera]\npixel_pitch = 0.01\n[observation]\n{TURBID}\n"
        );
        std::fs::write(dir.path().join("scene.toml"), text).unwrap();
        ObservedScene::read(&dir.path().join("scene.toml"))
    };
    assert!(message(with("")).contains("pixel (0, 0) is -0.5"));
    assert!(with("noise = 0.02").is_ok());
}
