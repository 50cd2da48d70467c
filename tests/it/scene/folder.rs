//! A folder with a small scene, sound until a test breaks it.

use crate::common::program::write_exr;
use narrowbeam::image::Image;
use narrowbeam::scene::{ObservedScene, Scene};
use std::path::PathBuf;
use tempfile::TempDir;

pub const SIZE: (usize, usize) = (12, 10);
pub const SEEN: (usize, usize) = (8, 6);

pub const SCENE: &str = "[object]
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
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.put("object.exr", &[("Y", texture(SIZE))]);
        folder.put("depth.exr", &[("Z", Image::filled(SIZE.0, SIZE.1, 2.0))]);
        folder.put("surface.exr", &[("Y", Image::filled(SIZE.0, SIZE.1, 0.5))]);
        folder.put("observed.exr", &[("Y", texture(SEEN))]);
        folder.put("mask.exr", &[("Y", Image::filled(SEEN.0, SEEN.1, 1.0))]);
        folder
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn put(&self, name: &str, channels: &[(&str, Image)]) {
        write_exr(&self.file(name), channels);
    }

    /// The scene to render.
    pub fn read(&self, text: &str) -> Result<Scene, narrowbeam::Error> {
        std::fs::write(self.file("scene.toml"), text).unwrap();
        Scene::read(&self.file("scene.toml"))
    }

    /// The scene to fit.
    pub fn observed(&self, text: &str) -> Result<ObservedScene, narrowbeam::Error> {
        std::fs::write(self.file("scene.toml"), text).unwrap();
        ObservedScene::read(&self.file("scene.toml"))
    }

    /// Asserts that a fit of the scene fails with one line that holds all of `words`.
    pub fn refuses(&self, text: &str, words: &[&str]) {
        let error = self.observed(text).expect_err("bad input");
        let message = error.to_string();
        assert!(error.is_usage(), "{message}");
        assert!(!message.contains('\n'), "{message}");
        for word in words {
            assert!(message.contains(word), "{word} is not in: {message}");
        }
    }
}

pub fn texture((width, height): (usize, usize)) -> Image {
    Image::from_fn(width, height, |x, y| ((x * 3 + y * 5) % 7) as f32 / 7.0)
}

/// The sound scene with `old` replaced by `new`.
pub fn with(old: &str, new: &str) -> String {
    assert!(SCENE.contains(old), "{old}");
    SCENE.replace(old, new)
}

/// The sound scene and a further section.
pub fn and(section: &str) -> String {
    format!("{SCENE}{section}\n")
}

/// `image` with the value of one pixel replaced.
pub fn spoilt(mut image: Image, x: usize, y: usize, value: f32) -> Image {
    image.data[y * image.width + x] = value;
    image
}
