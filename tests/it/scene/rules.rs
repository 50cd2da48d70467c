//! The rules of the format for views, distances, channels and the medium hold.

use super::folder::{Folder, SCENE, SEEN, SIZE, spoilt, texture, with};
use narrowbeam::geometry::Field;
use narrowbeam::image::{Image, View};
use narrowbeam::scene::{Gain, Noise, ObservedScene, PartialMedium, Veil, read_truth};

#[test]
fn a_sound_scene_is_read() {
    let folder = Folder::new();
    let ObservedScene { scene, observation } = folder.observed(SCENE).unwrap();
    assert_eq!((observation.noise.clone(), observation.gain), (Some(Noise::Level(0.002)), Gain::Fixed(1.0)));
    assert_eq!(observation.veil, Veil::Fixed(0.0));
    assert_eq!(scene.view, View { x: 2, y: 2, width: 8, height: 6 });
    assert_eq!(scene.geometry.path_length(3, 4), Some(2.0));
    assert_eq!(scene.media(PartialMedium::default()).unwrap()[0].parameters()[2], 0.0049);
}

#[test]
fn variances_are_known_or_estimated_with_the_image() {
    let folder = Folder::new();
    let text = with("noise = 0.002", "variance = \"variance.exr\"");
    let variance = |channels: &[(&str, Image)]| {
        folder.put("variance.exr", channels);
        match folder.observed(&text).unwrap().observation.noise {
            Some(Noise::Variance(mut channels)) => channels.remove(0),
            other => panic!("{other:?}"),
        }
    };
    let one_louder = spoilt(Image::filled(SEEN.0, SEEN.1, 1e-4), 3, 2, 9e-4);
    let known = variance(&[("Y", one_louder.clone())]);
    assert_eq!((known.name.as_str(), &known.image), ("Y", &one_louder));
    // An estimate beside the image gives way to the mean over its neighbours, two pixels around.
    let estimated = variance(&[("Y", texture(SEEN)), ("Y.variance", one_louder)]);
    assert_eq!(estimated.name, "Y");
    assert!((estimated.image.at(3, 2) - 1e-4).abs() < 1e-10);
    assert!((estimated.image.at(4, 2) - (1e-4 + 8e-4 / 24.0)).abs() < 1e-10, "{}", estimated.image.at(4, 2));
    assert!((estimated.image.at(6, 2) - 1e-4).abs() < 1e-10);
    // What the mask excludes need not have a variance.
    folder.put("mask.exr", &[("Y", spoilt(Image::filled(SEEN.0, SEEN.1, 1.0), 5, 5, 0.0))]);
    variance(&[("Y", spoilt(Image::filled(SEEN.0, SEEN.1, 1e-4), 5, 5, f32::NAN))]);
}

#[test]
fn empty_pixels_of_a_depth_map_hold_no_object() {
    let folder = Folder::new();
    let mut depth = Image::filled(12, 10, 2.0);
    for (x, value) in [0.0, -1.0, f32::INFINITY, 2e9].into_iter().enumerate() {
        depth = spoilt(depth, x, 0, value);
    }
    folder.put("depth.exr", &[("Z", depth)]);
    let scene = folder.observed(SCENE).unwrap().scene;
    let z: Vec<_> = (0..5).map(|x| scene.geometry.path_length(x, 0)).collect();
    assert_eq!(z, [None, None, None, None, Some(2.0)]);
    folder.put("depth.exr", &[("Z", Image::filled(12, 10, 0.0))]);
    folder.refuses(SCENE, &["depth.exr", "no pixel"]);
}

#[test]
fn planar_distances_become_distances_along_the_ray() {
    let folder = Folder::new();
    let text = with("pixel_pitch = 0.01", "fov_x_deg = 90")
        .replace("depth = \"depth.exr\"", "depth = 2.0\ndepth_kind = \"planar\"\nsurface = 0.5");
    let scene = folder.observed(&text).unwrap().scene;
    // At 90 degrees the pixel (0, 0) of 12 x 10 lies at slopes (5.5, 4.5) / 6.
    let stretch = (1.0 + (5.5_f64 * 5.5 + 4.5 * 4.5) / 36.0).sqrt();
    assert!((scene.geometry.object_distance(0, 0).unwrap() - 2.0 * stretch).abs() < 1e-6);
    assert!((scene.geometry.path_length(0, 0).unwrap() - 1.5 * stretch).abs() < 1e-6);

    let text = with("depth = \"depth.exr\"", "depth = 2.0\ndepth_kind = \"planar\"");
    assert_eq!(folder.observed(&text).unwrap().scene.geometry.depth, Field::Uniform(2.0));
}

#[test]
fn observed_pixels_may_be_negative_and_where_masked_out_anything() {
    let folder = Folder::new();
    let noisy = spoilt(spoilt(texture(SEEN), 1, 2, -0.1), 3, 4, f32::NAN);
    folder.put("observed.exr", &[("Y", noisy)]);
    folder.refuses(SCENE, &["observed.exr", "channel Y", "pixel (3, 4)"]);
    folder.put("mask.exr", &[("Y", spoilt(Image::filled(8, 6, 1.0), 3, 4, 0.0))]);
    let observation = folder.observed(SCENE).unwrap().observation;
    assert_eq!(observation.image[0].image.at(1, 2), -0.1);
    assert_eq!(observation.image[0].image.at(3, 4), 0.0);
}

#[test]
fn the_command_line_completes_the_medium() {
    let folder = Folder::new();
    let scene = folder.read(&with("b = 0.0049", "")).unwrap();
    let message = scene.media(PartialMedium::default()).unwrap_err().to_string();
    assert!(message.contains("scene.toml") && message.contains("[medium] b is missing"), "{message}");
    let given = |sigma_s: f64| PartialMedium {
        sigma_s: Some(sigma_s),
        phase_parameter: Some(0.01),
        ..PartialMedium::default()
    };
    let medium = scene.media(given(2.0)).unwrap()[0];
    assert_eq!(medium.parameters(), [2.0, 0.05, 0.01]);
    let message = scene.media(given(-2.0)).unwrap_err().to_string();
    assert!(message.contains("--sigma-s = -2"), "{message}");
}

#[test]
fn three_channels_have_three_values() {
    let folder = Folder::new();
    let rgb = |size| ["R", "G", "B"].map(|name| (name, texture(size)));
    folder.put("object.exr", &rgb(SIZE));
    folder.put("observed.exr", &rgb(SEEN));
    let text = with("0.95", "[1, 2, 3]")
        + "[fit]\nstart = { b = [0.1, 0.2, 0.3] }\nbounds = { sigma_s = [[1, 2], [2, 3], [3, 4]] }\n";
    let scene = folder.observed(&text).unwrap().scene;
    let media = scene.media(PartialMedium::default()).unwrap();
    assert_eq!(media.iter().map(|m| m.sigma_s()).collect::<Vec<_>>(), [1.0, 2.0, 3.0]);
    assert_eq!(media[2].sigma_a(), 0.05);
    assert_eq!((scene.fit[1].phase.start, scene.fit[1].sigma_s.bounds), (Some(0.2), Some([2.0, 3.0])));
    folder.put("observed.exr", &[("Y", texture(SEEN))]);
    folder.refuses(&text, &["observed.exr: has no channel R, G, B", "it holds Y"]);
}

#[test]
fn the_view_is_the_centre_or_where_it_is_put() {
    let folder = Folder::new();
    let at = |offset: &str| with("noise", &format!("offset_px = {offset}\nnoise"));
    let view = folder.observed(&at("[4, 0]")).unwrap().scene.view;
    assert_eq!((view.x, view.y), (4, 0));
    folder.refuses(&at("[5, 0]"), &["scene.toml", "[observation] offset_px = [5, 0]"]);
}

#[test]
fn a_view_needs_no_observed_image_to_be_rendered() {
    let folder = Folder::new();
    let whole = View::whole(SIZE.0, SIZE.1);
    let without = SCENE.split("[observation]").next().unwrap();
    assert_eq!(folder.read(without).unwrap().view, whole);

    let seen = folder.read(SCENE).unwrap();
    assert_eq!((seen.view.width, seen.view.height), SEEN);

    std::fs::remove_file(folder.file("observed.exr")).unwrap();
    assert_eq!(folder.read(SCENE).unwrap().view, whole);
    let sized = |size: &str| with("noise", &format!("size_px = {size}\nnoise"));
    let view = folder.read(&sized("[4, 4]")).unwrap().view;
    assert_eq!(view, View { x: 4, y: 3, width: 4, height: 4 });
    let message = folder.read(&sized("[13, 4]")).unwrap_err().to_string();
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
    assert_eq!((truth.len(), truth[0].sigma_s()), (1, 1.0));
    std::fs::write(&path, "[medium]\nsigma_s = [1, 2, 3]\nb = 0.1\n").unwrap();
    let message = read_truth(&path).unwrap_err().to_string();
    assert!(message.contains("truth.toml") && message.contains("sigma_a"), "{message}");
}
