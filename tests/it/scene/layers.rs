//! `[[object.layer]]`: what is understood, and what is refused by name of file, key or pixel.

use super::folder::{Folder, SIZE, spoilt, texture, with};
use narrowbeam::geometry::Field;
use narrowbeam::image::Image;

const LAYER: &str = "[[object.layer]]\nradiance = \"behind.exr\"\ndepth = \"behind_depth.exr\"\n";

/// The sound scene with these layers; its object lies at 2.
fn layered(layers: &str) -> String {
    with("[camera]", &format!("{layers}[camera]"))
}

fn flat(depth: f32) -> Image {
    Image::filled(SIZE.0, SIZE.1, depth)
}

/// A folder with the files of `LAYER`, a layer at 3.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.put("behind.exr", &[("Y", texture(SIZE))]);
    folder.put("behind_depth.exr", &[("Z", flat(3.0))]);
    folder
}

#[test]
fn layers_are_read_nearest_first() {
    let folder = folder();
    folder.put("last.exr", &[("Y", flat(0.25))]);
    // Nothing in one corner, and the object repeated in another.
    folder.put("behind_depth.exr", &[("Z", spoilt(spoilt(flat(3.0), 0, 0, f32::INFINITY), 11, 9, 2.0))]);
    let text = layered(&format!("{LAYER}[[object.layer]]\nradiance = \"last.exr\"\ndepth = 4.5\n"));
    let scene = folder.observed(&text).unwrap().scene;
    assert_eq!(scene.behind, [vec![texture(SIZE), flat(0.25)]]);
    let distances = |x, y| scene.geometry.behind.iter().map(|f| f.distance(x, y)).collect::<Vec<_>>();
    assert_eq!(distances(5, 5), [Some(3.0), Some(4.5)]);
    assert_eq!(distances(0, 0), [None, Some(4.5)]);
    assert_eq!(distances(11, 9), [Some(2.0), Some(4.5)]);
}

#[test]
fn without_layers_nothing_is_behind() {
    let scene = Folder::new().observed(super::folder::SCENE).unwrap().scene;
    assert_eq!((scene.behind, scene.geometry.behind), (vec![vec![]], vec![]));
}

#[test]
fn each_colour_has_its_own_layers() {
    let folder = folder();
    let colours =
        |scale: f32| ["R", "G", "B"].map(|name| (name, flat(scale * f32::from(name.as_bytes()[0]))));
    folder.put("object.exr", &["R", "G", "B"].map(|name| (name, texture(SIZE))));
    folder.put("behind.exr", &colours(1.0));
    folder.put("last.exr", &colours(2.0));
    let text = layered(&format!("{LAYER}[[object.layer]]\nradiance = \"last.exr\"\ndepth = 4.5\n"));
    let behind = folder.read(&text).unwrap().behind;
    let values: Vec<Vec<f32>> = behind.iter().map(|c| c.iter().map(|i| i.at(3, 3)).collect()).collect();
    assert_eq!(values, [[82.0, 164.0], [71.0, 142.0], [66.0, 132.0]]);
}

#[test]
fn planar_distances_of_layers_are_converted() {
    let folder = folder();
    let text = layered(LAYER)
        .replace("pixel_pitch = 0.01", "fov_x_deg = 90")
        .replace("depth = \"depth.exr\"", "depth = 2.0\ndepth_kind = \"planar\"");
    for layer in [text.clone(), text.replace("\"behind_depth.exr\"", "3.0")] {
        let scene = folder.observed(&layer).unwrap().scene;
        let ratio = scene.geometry.behind[0].at(0, 0) / scene.geometry.object_distance(0, 0).unwrap();
        assert!((ratio - 1.5).abs() < 1e-6, "{ratio}");
    }
    // The same plane twice, once as a number and once as a map: equal but for rounding.
    folder.put("behind_depth.exr", &[("Z", flat(2.0))]);
    let scene = folder.observed(&text).unwrap().scene;
    assert!(matches!(scene.geometry.behind[0], Field::Map(_)));
}

#[test]
fn a_layer_seen_through_an_empty_pixel_is_light_to_fit() {
    let folder = folder();
    folder.put("object.exr", &[("Y", flat(0.5))]);
    folder.put("depth.exr", &[("Z", spoilt(flat(2.0), 4, 4, 0.0))]);
    let text = layered(LAYER).replace("depth = \"depth.exr\"", "depth = \"depth.exr\"\nborder = \"clamp\"");
    assert!(folder.observed(&text).is_ok());
    folder.put("behind.exr", &[("Y", flat(0.5))]);
    folder.refuses(&text, &["object.exr", "uniform"]);
}

#[test]
fn keys_of_a_layer_are_checked() {
    let folder = folder();
    for (from, to, words) in [
        ("depth", "deep", &["`deep`", "object.layer"] as &[&str]),
        ("radiance = \"behind.exr\"\n", "", &["scene.toml", "radiance", "object.layer"]),
        ("behind.exr", "none.exr", &["none.exr: cannot be read"]),
        ("behind_depth.exr", "none.exr", &["none.exr: cannot be read"]),
        ("\"behind_depth.exr\"", "true", &["object.layer", "true"]),
        (
            "\"behind_depth.exr\"",
            "0",
            &["scene.toml: line 4, column 1: [[object.layer]] 1 depth = 0", "above 0"],
        ),
        ("\"behind_depth.exr\"", "-3.0", &["scene.toml: line 4, column 1: [[object.layer]] 1 depth = -3"]),
        ("\"behind_depth.exr\"", "nan", &["scene.toml: line 4, column 1: [[object.layer]] 1 depth = NaN"]),
        ("\"behind_depth.exr\"", "1.5", &["scene.toml: [[object.layer]] 1: depth at pixel (0, 0) = 1.5"]),
    ] {
        folder.refuses(&layered(&LAYER.replacen(from, to, 1)), words);
    }
    let second = format!("{LAYER}[[object.layer]]\nradiance = \"behind.exr\"\ndepth = 2.5\n");
    folder.refuses(&layered(&second), &["scene.toml: [[object.layer]] 2: depth at pixel (0, 0) = 2.5"]);
}

#[test]
fn images_of_a_layer_are_checked() {
    let spoilt_depth = |x, y, value| ("Z", spoilt(flat(3.0), x, y, value));
    for (file, channel, words) in [
        ("behind.exr", ("R", texture(SIZE)), &["behind.exr: has no channel Y", "it holds R"] as &[&str]),
        ("behind.exr", ("Y", texture((12, 9))), &["behind.exr: is 12x9 px", "object.exr is 12x10 px"]),
        ("behind.exr", ("Y", spoilt(texture(SIZE), 5, 3, -0.25)), &["behind.exr", "pixel (5, 3) is -0.25"]),
        ("behind.exr", ("Y", spoilt(texture(SIZE), 5, 3, f32::NAN)), &["behind.exr", "pixel (5, 3)", "NaN"]),
        ("behind_depth.exr", ("Z", Image::filled(11, 10, 3.0)), &["behind_depth.exr: is 11x10 px"]),
        ("behind_depth.exr", spoilt_depth(1, 9, f32::NAN), &["behind_depth.exr", "pixel (1, 9)", "NaN"]),
        (
            "behind_depth.exr",
            spoilt_depth(7, 2, 1.75),
            &["behind_depth.exr", "pixel (7, 2) = 1.75", "in front"],
        ),
    ] {
        let folder = folder();
        folder.put(file, &[channel]);
        folder.refuses(&layered(LAYER), words);
    }
}

#[test]
fn a_layer_before_the_surface_is_refused() {
    let folder = folder();
    folder.put("depth.exr", &[("Z", spoilt(flat(2.0), 3, 4, 0.0))]);
    folder.put("behind_depth.exr", &[("Z", spoilt(flat(3.0), 3, 4, 0.25))]);
    let text = layered(&format!("surface = 0.5\n{LAYER}"));
    folder.refuses(&text, &["behind_depth.exr", "[[object.layer]] 1", "pixel (3, 4) = -0.25", "surface"]);
}
