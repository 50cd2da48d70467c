//! Scene files: each kind of bad input is refused by one message that names the culprit, and the rules of the
//! format for views, distances and channels hold.

use narrowbeam::geometry::Field;
use narrowbeam::image::{Channel, Image, View};
use narrowbeam::io::exr;
use narrowbeam::scene::{Gain, Purpose, Scene, Veil, read_truth};
use std::path::PathBuf;
use tempfile::TempDir;

const SIZE: (usize, usize) = (12, 10);
const SEEN: (usize, usize) = (8, 6);

const SCENE: &str = "[object]
radiance = \"object.exr\"
depth = \"depth.exr\"
[camera]
pixel_pitch = 0.01
[observation]
image = \"observed.exr\"
noise = 0.002
mask = \"mask.exr\"
[medium]
sigma_s = 0.95
sigma_a = 0.05
b = 0.0049
";

/// A folder with a sound scene, of which tests break one part.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.put("object.exr", &[("Y", texture(SIZE))]);
        folder.put("depth.exr", &[("Z", Image::filled(SIZE.0, SIZE.1, 2.0))]);
        folder.put("surface.exr", &[("Y", Image::filled(SIZE.0, SIZE.1, 0.5))]);
        folder.put("observed.exr", &[("Y", texture(SEEN))]);
        folder.put("mask.exr", &[("Y", Image::filled(SEEN.0, SEEN.1, 1.0))]);
        folder
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, channels: &[(&str, Image)]) {
        let channel =
            |(name, image): &(&str, Image)| Channel { name: name.to_string(), image: image.clone() };
        exr::write(&self.file(name), &channels.iter().map(channel).collect::<Vec<_>>(), &[]).unwrap();
    }

    fn read(&self, text: &str, purpose: Purpose) -> Result<Scene, narrowbeam::Error> {
        std::fs::write(self.file("scene.toml"), text).unwrap();
        Scene::read(&self.file("scene.toml"), purpose)
    }

    /// Asserts that a fit of the scene fails with one line that holds all of `words`.
    fn refuses(&self, text: &str, words: &[&str]) {
        let error = self.read(text, Purpose::Fit).expect_err("bad input");
        let message = error.to_string();
        assert!(error.is_usage(), "{message}");
        assert!(!message.contains('\n'), "{message}");
        for word in words {
            assert!(message.contains(word), "{word} is not in: {message}");
        }
    }
}

fn texture((width, height): (usize, usize)) -> Image {
    Image::from_fn(width, height, |x, y| ((x * 3 + y * 5) % 7) as f32 / 7.0)
}

/// The sound scene with `old` replaced by `new`.
fn with(old: &str, new: &str) -> String {
    assert!(SCENE.contains(old), "{old}");
    SCENE.replace(old, new)
}

/// The sound scene and a further section.
fn and(section: &str) -> String {
    format!("{SCENE}{section}\n")
}

/// `image` with the value of one pixel replaced.
fn spoilt(mut image: Image, x: usize, y: usize, value: f32) -> Image {
    image.data[y * image.width + x] = value;
    image
}

#[test]
fn a_sound_scene_is_read() {
    let folder = Folder::new();
    let scene = folder.read(SCENE, Purpose::Fit).unwrap();
    let observation = scene.observation.as_ref().unwrap();
    assert_eq!((observation.noise, observation.gain), (Some(0.002), Gain::Fixed(1.0)));
    assert_eq!(observation.veil, Veil::Fixed(0.0));
    assert_eq!(scene.view, View { x: 2, y: 2, width: 8, height: 6 });
    assert_eq!(scene.geometry.path_length(3, 4), Some(2.0));
    assert_eq!(scene.medium_values([None; 3]).unwrap()[0].b, 0.0049);
}

#[test]
fn a_missing_file_is_named() {
    let folder = Folder::new();
    for name in ["object.exr", "depth.exr", "observed.exr", "mask.exr"] {
        folder.refuses(&with(name, "none.exr"), &["none.exr: cannot be read", "No such file"]);
    }
    let error = Scene::read(&folder.file("none.toml"), Purpose::Fit).unwrap_err().to_string();
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
    folder.refuses(&and("[fit]\nstart = { g = 1 }"), &["`g`", "fit.start"]);
    folder.refuses(&and("[extra]\na = 1"), &["`extra`"]);
}

#[test]
fn a_value_of_the_wrong_type_is_named() {
    let folder = Folder::new();
    folder.refuses(&with("0.95", "\"much\""), &["medium.sigma_s", "much", "a number"]);
    folder.refuses(&with("0.002", "\"low\""), &["observation.noise"]);
    folder.refuses(&with("depth = \"depth.exr\"", "depth = true"), &["object.depth", "true"]);
    folder.refuses(&with("pixel_pitch", "border = 1\npixel_pitch"), &["border"]);
    folder.refuses(&with("noise", "gain = \"auto\"\nnoise"), &["observation.gain", "auto"]);
    folder.refuses(&with("noise", "offset_px = [-1, 0]\nnoise"), &["observation.offset_px", "-1"]);
    folder.refuses(&with("depth =", "depth_kind = \"z\"\ndepth ="), &["object.depth_kind", "`z`", "planar"]);
    folder.refuses("[object\n", &["scene.toml", "line 1"]);
    folder.refuses(&with("[camera]", "camera"), &["scene.toml", "line 4"]);
}

#[test]
fn further_layers_are_not_built_yet() {
    let folder = Folder::new();
    let layer = "[[object.layer]]\nradiance = \"behind.exr\"\ndepth = 3.0\n[camera]";
    folder.refuses(&with("[camera]", layer), &["[[object.layer]]", "not built yet"]);
    folder.refuses(&with("[camera]", &layer.replace("3.0", "3.0\ndeep = 1")), &["`deep`"]);
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
fn nan_in_a_distance_is_named_by_pixel() {
    let folder = Folder::new();
    folder.put("depth.exr", &[("Z", spoilt(Image::filled(12, 10, 2.0), 1, 9, f32::NAN))]);
    folder.refuses(SCENE, &["depth.exr", "channel Z", "pixel (1, 9)", "NaN"]);
}

#[test]
fn empty_pixels_of_a_depth_map_hold_no_object() {
    let folder = Folder::new();
    let mut depth = Image::filled(12, 10, 2.0);
    for (x, value) in [0.0, -1.0, f32::INFINITY, 2e9].into_iter().enumerate() {
        depth = spoilt(depth, x, 0, value);
    }
    folder.put("depth.exr", &[("Z", depth)]);
    let scene = folder.read(SCENE, Purpose::Fit).unwrap();
    let z: Vec<_> = (0..5).map(|x| scene.geometry.path_length(x, 0)).collect();
    assert_eq!(z, [None, None, None, None, Some(2.0)]);
    folder.put("depth.exr", &[("Z", Image::filled(12, 10, 0.0))]);
    folder.refuses(SCENE, &["depth.exr", "no pixel"]);
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
fn planar_distances_become_distances_along_the_ray() {
    let folder = Folder::new();
    let text = with("pixel_pitch = 0.01", "fov_x_deg = 90")
        .replace("depth = \"depth.exr\"", "depth = 2.0\ndepth_kind = \"planar\"\nsurface = 0.5");
    let scene = folder.read(&text, Purpose::Fit).unwrap();
    // At 90 degrees the pixel (0, 0) of 12 x 10 lies at slopes (5.5, 4.5) / 6.
    let stretch = (1.0 + (5.5_f64 * 5.5 + 4.5 * 4.5) / 36.0).sqrt();
    assert!((scene.geometry.object_distance(0, 0).unwrap() - 2.0 * stretch).abs() < 1e-6);
    assert!((scene.geometry.path_length(0, 0).unwrap() - 1.5 * stretch).abs() < 1e-6);

    let text = with("depth = \"depth.exr\"", "depth = 2.0\ndepth_kind = \"planar\"");
    assert_eq!(folder.read(&text, Purpose::Fit).unwrap().geometry.depth, Field::Uniform(2.0));
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
    for gain in ["0", "-1", "inf"] {
        folder.refuses(&with("noise", &format!("gain = {gain}\nnoise")), &["[observation] gain"]);
    }
    folder.refuses(&with("noise", "veil = nan\nnoise"), &["[observation] veil"]);
    let scene = folder.read(&with("noise", "gain = \"free\"\nveil = \"free\"\nnoise"), Purpose::Fit).unwrap();
    let observation = scene.observation.unwrap();
    assert_eq!((observation.gain, observation.veil), (Gain::Free, Veil::Free));
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
    assert!(folder.read(SCENE, Purpose::Fit).is_ok());
    folder.refuses(&with("[camera]", "border = \"clamp\"\n[camera]"), &["object.exr", "uniform"]);
}

#[test]
fn observed_pixels_may_be_negative_and_where_masked_out_anything() {
    let folder = Folder::new();
    let noisy = spoilt(spoilt(texture(SEEN), 1, 2, -0.1), 3, 4, f32::NAN);
    folder.put("observed.exr", &[("Y", noisy)]);
    folder.refuses(SCENE, &["observed.exr", "channel Y", "pixel (3, 4)"]);
    folder.put("mask.exr", &[("Y", spoilt(Image::filled(8, 6, 1.0), 3, 4, 0.0))]);
    let observation = folder.read(SCENE, Purpose::Fit).unwrap().observation.unwrap();
    assert_eq!(observation.image[0].image.at(1, 2), -0.1);
    assert_eq!(observation.image[0].image.at(3, 4), 0.0);
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
    let b = folder.read(&text, Purpose::Render).unwrap().medium_values([None; 3]).unwrap()[0].b;
    assert!((b - 8f64.to_radians().powi(2) / 4.0).abs() < 1e-15);
}

#[test]
fn the_command_line_completes_the_medium() {
    let folder = Folder::new();
    let scene = folder.read(&with("b = 0.0049", ""), Purpose::Render).unwrap();
    let message = scene.medium_values([None; 3]).unwrap_err().to_string();
    assert!(message.contains("scene.toml") && message.contains("[medium] b is missing"), "{message}");
    let medium = scene.medium_values([Some(2.0), None, Some(0.01)]).unwrap()[0];
    assert_eq!((medium.sigma_s, medium.sigma_a, medium.b), (2.0, 0.05, 0.01));
    let message = scene.medium_values([Some(-2.0), None, Some(0.01)]).unwrap_err().to_string();
    assert!(message.contains("--sigma-s = -2"), "{message}");
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
    let options = folder.read(&text, Purpose::Fit).unwrap().fit[0];
    assert_eq!((options.fixed[1], options.bounds[2]), (Some(0.0), Some([1e-5, 1.0])));
}

#[test]
fn three_channels_have_three_values() {
    let folder = Folder::new();
    let rgb = |size| ["R", "G", "B"].map(|name| (name, texture(size)));
    folder.put("object.exr", &rgb(SIZE));
    folder.put("observed.exr", &rgb(SEEN));
    let text = with("0.95", "[1, 2, 3]")
        + "[fit]\nstart = { b = [0.1, 0.2, 0.3] }\nbounds = { sigma_s = [[1, 2], [2, 3], [3, 4]] }\n";
    let scene = folder.read(&text, Purpose::Fit).unwrap();
    let media = scene.medium_values([None; 3]).unwrap();
    assert_eq!(media.iter().map(|m| m.sigma_s).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    assert_eq!(media[2].sigma_a, 0.05);
    assert_eq!((scene.fit[1].start[2], scene.fit[1].bounds[0]), (Some(0.2), Some([2.0, 3.0])));
    folder.put("observed.exr", &[("Y", texture(SEEN))]);
    folder.refuses(&text, &["observed.exr: has no channel R, G, B", "it holds Y"]);
}

#[test]
fn the_view_is_the_centre_or_where_it_is_put() {
    let folder = Folder::new();
    let at = |offset: &str| with("noise", &format!("offset_px = {offset}\nnoise"));
    let view = folder.read(&at("[4, 0]"), Purpose::Fit).unwrap().view;
    assert_eq!((view.x, view.y), (4, 0));
    folder.refuses(&at("[5, 0]"), &["scene.toml", "[observation] offset_px = [5, 0]"]);
}

#[test]
fn a_view_needs_no_observed_image_to_be_rendered() {
    let folder = Folder::new();
    let whole = View::whole(SIZE.0, SIZE.1);
    let without = SCENE.split("[observation]").next().unwrap();
    assert_eq!(folder.read(without, Purpose::Render).unwrap().view, whole);

    let seen = folder.read(SCENE, Purpose::Render).unwrap();
    assert_eq!((seen.view.width, seen.view.height), SEEN);
    assert!(seen.observation.is_none());

    std::fs::remove_file(folder.file("observed.exr")).unwrap();
    assert_eq!(folder.read(SCENE, Purpose::Render).unwrap().view, whole);
    let sized = |size: &str| with("noise", &format!("size_px = {size}\nnoise"));
    let view = folder.read(&sized("[4, 4]"), Purpose::Render).unwrap().view;
    assert_eq!(view, View { x: 4, y: 3, width: 4, height: 4 });
    let message = folder.read(&sized("[13, 4]"), Purpose::Render).unwrap_err().to_string();
    assert!(message.contains("[observation] size_px = [13, 4]"), "{message}");

    let folder = Folder::new();
    folder.refuses(&sized("[4, 4]"), &["[observation] size_px = [4, 4]", "observed.exr is 8x6 px"]);
}

#[test]
fn the_truth_is_read_beside_other_tables() {
    let folder = Folder::new();
    let path = folder.file("truth.toml");
    std::fs::write(
        &path,
        "[provenance]\nseed = 1\n[medium]\nsigma_s = 1\nsigma_a = 0\nspread_angle_deg = 6\n",
    )
    .unwrap();
    let truth = read_truth(&path).unwrap();
    assert_eq!((truth.len(), truth[0].sigma_s), (1, 1.0));
    std::fs::write(&path, "[medium]\nsigma_s = [1, 2, 3]\nb = 0.1\n").unwrap();
    let message = read_truth(&path).unwrap_err().to_string();
    assert!(message.contains("truth.toml") && message.contains("sigma_a"), "{message}");
}
