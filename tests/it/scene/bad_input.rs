//! Each kind of bad input is refused by one message that names the culprit.

use super::folder::{Folder, SCENE, SEEN, SIZE, and, spoilt, texture, with};
use narrowbeam::image::Image;
use narrowbeam::imaging::VeilField;
use narrowbeam::scene::{Gain, ObservedScene, PartialMedium, Veil};

#[test]
fn a_missing_file_is_named() {
    let folder = Folder::new();
    for name in ["object.exr", "depth.exr", "observed.exr", "mask.exr"] {
        folder.refuses(&with(name, "none.exr"), &["none.exr: cannot be read", "No such file"]);
    }
    let error = ObservedScene::read(&folder.file("none.toml")).unwrap_err().to_string();
    assert!(error.contains("none.toml: cannot be read"), "{error}");
}

#[test]
fn a_missing_section_or_key_is_named() {
    let folder = Folder::new();
    folder.refuses(&with("radiance = \"object.exr\"\n", ""), &["scene.toml", "radiance", "object"]);
    folder.refuses(&with("depth = \"depth.exr\"\n", ""), &["scene.toml", "depth", "object"]);
    folder.refuses(&with("image = \"observed.exr\"\n", ""), &["scene.toml", "[observation] image"]);
    folder.refuses(&with("pixel_pitch = 0.01\n", ""), &["scene.toml", "[camera] pixel_pitch or fov_x_deg"]);
    folder.refuses("[object]\nradiance = \"a.exr\"\ndepth = 1\n", &["scene.toml", "camera"]);
    let without = SCENE.split("[observation]").next().unwrap();
    folder.refuses(without, &["scene.toml", "[observation]"]);
}

#[test]
fn an_unknown_key_is_named() {
    let folder = Folder::new();
    folder.refuses(&with("radiance", "radiancy"), &["scene.toml", "`radiancy`", "object"]);
    folder.refuses(&with("pixel_pitch", "pitch"), &["`pitch`", "camera"]);
    folder.refuses(&with("noise", "nose"), &["`nose`", "observation"]);
    folder.refuses(&with("sigma_a", "sigma_b"), &["`sigma_b`", "medium"]);
    folder.refuses(&and("[fit]\nstart = { c = 1 }"), &["`c`", "fit.start"]);
    folder.refuses(&and("[extra]\na = 1"), &["`extra`"]);
}

#[test]
fn a_value_of_the_wrong_type_is_named() {
    let folder = Folder::new();
    folder.refuses(&with("0.95", "\"much\""), &["medium.sigma_s", "much", "a number"]);
    folder.refuses(&with("0.002", "\"low\""), &["observation.noise"]);
    folder.refuses(&with("noise", "hidden_share_max = \"low\"\nnoise"), &["observation.hidden_share_max"]);
    folder.refuses(&with("depth = \"depth.exr\"", "depth = true"), &["object.depth", "true"]);
    folder.refuses(&with("pixel_pitch", "border = 1\npixel_pitch"), &["border"]);
    folder.refuses(&with("noise", "gain = \"auto\"\nnoise"), &["observation.gain", "auto"]);
    folder.refuses(&with("noise", "offset_px = [-1, 0]\nnoise"), &["observation.offset_px", "-1"]);
    folder.refuses(&with("depth =", "depth_kind = \"z\"\ndepth ="), &["object.depth_kind", "`z`", "planar"]);
    folder.refuses("[object\n", &["scene.toml", "line 1"]);
    folder.refuses(&with("[camera]", "camera"), &["scene.toml", "line 4"]);
}

#[test]
fn images_of_different_sizes_are_refused_by_name() {
    let folder = Folder::new();
    folder.put("depth.exr", &[("Z", Image::filled(11, 10, 2.0))]);
    folder.refuses(SCENE, &["depth.exr: is 11x10 px", "object.exr is 12x10 px"]);

    let folder = Folder::new();
    folder.put("mask.exr", &[("Y", Image::filled(8, 7, 1.0))]);
    folder.refuses(SCENE, &["mask.exr: is 8x7 px", "observed.exr is 8x6 px"]);

    let folder = Folder::new();
    folder.put("surface.exr", &[("Y", Image::filled(1, 1, 0.5))]);
    folder.refuses(&with("[camera]", "surface = \"surface.exr\"\n[camera]"), &["surface.exr: is 1x1 px"]);
    folder.put("veil.exr", &[("Y", Image::filled(3, 3, 0.5))]);
    folder.refuses(&with("noise", "veil = \"veil.exr\"\nnoise"), &["veil.exr: is 3x3 px"]);

    let folder = Folder::new();
    folder.put("observed.exr", &[("Y", texture((13, 10)))]);
    folder.refuses(SCENE, &["observed.exr: is 13x10 px", "at most the object image's 12x10 px"]);
}

#[test]
fn a_bad_radiance_is_named_by_channel_and_pixel() {
    for value in [-0.25, f32::NAN, f32::INFINITY] {
        let folder = Folder::new();
        folder.put("object.exr", &[("Y", spoilt(texture(SIZE), 5, 3, value))]);
        folder.refuses(SCENE, &["object.exr", "channel Y", "pixel (5, 3)"]);
    }
}

#[test]
fn a_bad_variance_is_named_by_channel_and_pixel() {
    let folder = Folder::new();
    let text = with("noise = 0.002", "variance = \"variance.exr\"");
    folder.refuses(&text, &["variance.exr: cannot be read"]);
    folder
        .refuses(&with("noise", "variance = \"variance.exr\"\nnoise"), &["scene.toml", "noise and variance"]);
    let flat = Image::filled(SEEN.0, SEEN.1, 1e-4);
    for value in [0.0, -1e-4, f32::NAN, f32::INFINITY] {
        folder.put("variance.exr", &[("Y", spoilt(flat.clone(), 5, 3, value))]);
        folder.refuses(&text, &["variance.exr", "channel Y", "pixel (5, 3)"]);
    }
    for value in [-1e-4, f32::NAN] {
        folder.put("variance.exr", &[("Y.variance", spoilt(flat.clone(), 5, 3, value))]);
        folder.refuses(&text, &["variance.exr", "channel Y.variance", "pixel (5, 3)"]);
    }
    folder.put("variance.exr", &[("Y.variance", Image::filled(SEEN.0, SEEN.1, 0.0))]);
    folder.refuses(&text, &["variance.exr", "pixel (0, 0)", "more samples"]);
    folder.put("variance.exr", &[("Y", Image::filled(SEEN.0 + 1, SEEN.1, 1e-4))]);
    folder.refuses(&text, &["variance.exr: is 9x6 px", "8x6 px"]);
    folder.put("variance.exr", &[("R", flat)]);
    folder.refuses(&text, &["variance.exr", "has no channel Y"]);
}

#[test]
fn nan_in_a_distance_is_named_by_pixel() {
    let folder = Folder::new();
    folder.put("depth.exr", &[("Z", spoilt(Image::filled(12, 10, 2.0), 1, 9, f32::NAN))]);
    folder.refuses(SCENE, &["depth.exr", "channel Z", "pixel (1, 9)", "NaN"]);
}

#[test]
fn a_depth_of_zero_or_less_is_refused() {
    let folder = Folder::new();
    for value in ["0", "-2.0", "nan", "inf"] {
        folder.refuses(&with("\"depth.exr\"", value), &["scene.toml", "[object] depth"]);
    }
}

#[test]
fn an_object_before_the_surface_is_refused() {
    let folder = Folder::new();
    let surface = |value: &str| with("[camera]", &format!("surface = {value}\n[camera]"));
    folder.refuses(&surface("2.0"), &["depth.exr", "pixel (0, 0)", "surface"]);
    folder.refuses(&surface("-1"), &["scene.toml", "[object] surface"]);
    folder.put("surface.exr", &[("Y", spoilt(Image::filled(12, 10, 0.5), 4, 2, 2.5))]);
    folder.refuses(&surface("\"surface.exr\""), &["depth.exr", "pixel (4, 2)"]);
}

#[test]
fn exactly_one_projection_is_wanted() {
    let folder = Folder::new();
    folder.refuses(&with("[observation]", "fov_x_deg = 40\n[observation]"), &["[camera]", "both"]);
    folder.refuses(&with("0.01", "0"), &["scene.toml", "[camera] pixel_pitch = 0"]);
    folder.refuses(&with("pixel_pitch = 0.01", "fov_x_deg = 180"), &["[camera] fov_x_deg = 180"]);
}

#[test]
fn numbers_of_the_observation_are_checked() {
    let folder = Folder::new();
    for noise in ["0", "0.0", "-0.1", "nan"] {
        folder.refuses(&with("0.002", noise), &["scene.toml", "[observation] noise"]);
    }
    let share = |value: &str| with("noise", &format!("hidden_share_max = {value}\nnoise"));
    for value in ["0", "-0.1", "1.1", "nan"] {
        folder.refuses(&share(value), &["scene.toml", "[observation] hidden_share_max", "at most 1"]);
    }
    let max = |text: &str| folder.observed(text).unwrap().observation.hidden_share_max;
    assert_eq!((max(SCENE), max(&share("1"))), (0.01, 1.0));
    for gain in ["0", "-1", "inf"] {
        folder.refuses(&with("noise", &format!("gain = {gain}\nnoise")), &["[observation] gain"]);
    }
    folder.refuses(&with("noise", "veil = nan\nnoise"), &["[observation] veil"]);
    let scene = folder.observed(&with("noise", "gain = \"free\"\nveil = \"free\"\nnoise")).unwrap();
    let observation = scene.observation;
    assert_eq!((observation.gain, observation.veil), (Gain::Free, Veil::Free(VeilField::Constant)));
}

#[test]
fn a_mask_that_excludes_everything_is_refused() {
    let folder = Folder::new();
    folder.put("mask.exr", &[("Y", Image::filled(8, 6, 0.0))]);
    folder.refuses(SCENE, &["mask.exr", "excludes every pixel"]);
}

#[test]
fn an_object_that_shows_nothing_is_refused() {
    let folder = Folder::new();
    folder.put("object.exr", &[("Y", Image::filled(12, 10, 0.0))]);
    folder.refuses(SCENE, &["nothing to fit", "object.exr", "black"]);
    folder.put("object.exr", &[("Y", Image::filled(12, 10, 0.5))]);
    assert!(folder.observed(SCENE).is_ok());
    folder.refuses(&with("[camera]", "border = \"clamp\"\n[camera]"), &["object.exr", "uniform"]);
}

#[test]
fn a_file_without_the_channel_is_named_with_what_it_holds() {
    let folder = Folder::new();
    folder.put("object.exr", &[("G", texture(SIZE)), ("B", texture(SIZE))]);
    folder.refuses(SCENE, &["object.exr: has no channel", "B, G"]);
    let folder = Folder::new();
    folder.put("observed.exr", &[("R", texture(SEEN))]);
    folder.refuses(SCENE, &["observed.exr: has no channel Y", "it holds R"]);
    let folder = Folder::new();
    folder.put("depth.exr", &[("A", texture(SIZE))]);
    folder.refuses(SCENE, &["depth.exr: has no channel", "it holds A"]);
}

#[test]
fn a_truncated_image_is_named() {
    for name in ["object.exr", "depth.exr", "observed.exr", "mask.exr"] {
        let folder = Folder::new();
        let bytes = std::fs::read(folder.file(name)).unwrap();
        std::fs::write(folder.file(name), &bytes[..bytes.len() / 2]).unwrap();
        folder.refuses(SCENE, &[&format!("{name}: cannot be read")]);
    }
}

#[test]
fn a_medium_out_of_range_is_named() {
    let folder = Folder::new();
    folder.refuses(&with("0.95", "-0.95"), &["scene.toml", "[medium] sigma_s = -0.95"]);
    folder.refuses(&with("0.05", "-0.05"), &["[medium] sigma_a = -0.05"]);
    folder.refuses(&with("0.0049", "0"), &["[medium] b = 0"]);
    folder.refuses(&with("0.95", "[1, 2, 3]"), &["[medium] sigma_s", "three", "one channel"]);
    folder.refuses(&with("0.95", "[1, 2]"), &["medium.sigma_s", "three for R, G, B"]);
    folder.refuses(&and("spread_angle_deg = 8"), &["[medium] b and spread_angle_deg"]);
    let text = with("b = 0.0049", "spread_angle_deg = 8");
    let b = folder.read(&text).unwrap().media(PartialMedium::default()).unwrap()[0].parameters()[2];
    assert!((b - 8f64.to_radians().powi(2) / 4.0).abs() < 1e-15);
}

#[test]
fn options_of_the_fit_are_checked() {
    let folder = Folder::new();
    folder.refuses(&and("[fit]\nstart = { sigma_s = 0 }"), &["[fit] start sigma_s = 0"]);
    folder.refuses(&and("[fit]\nfixed = { sigma_a = -1 }"), &["[fit] fixed sigma_a = -1"]);
    folder.refuses(&and("[fit]\nbounds = { b = [0.1, 0.1] }"), &["[fit] bounds b", "below"]);
    folder.refuses(&and("[fit]\nbounds = { b = [0, 0.1] }"), &["[fit] bounds b = 0"]);
    folder.refuses(&and("[fit]\nbounds = { b = 0.1 }"), &["fit.bounds.b", "[low, high]"]);
    folder.refuses(&and("[fit]\nstart = { b = 1 }\nbounds = { b = [0.1, 0.2] }"), &["[fit] start b = 1"]);
    let text = and("[fit]\nstart = { sigma_a = 1 }\nfixed = { sigma_a = 0 }\nbounds = { b = [1e-5, 1] }");
    let options = folder.observed(&text).unwrap().scene.fit[0];
    assert_eq!((options.sigma_a.fixed, options.phase.bounds), (Some(0.0), Some([1e-5, 1.0])));
}
