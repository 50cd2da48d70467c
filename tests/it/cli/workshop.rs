//! A folder with a scene, the program to run on it, and what it said.

use crate::common::program::{narrowbeam, write_exr};
use narrowbeam::image::Image;
use std::path::PathBuf;
use tempfile::TempDir;

/// Side of the test images, px.
pub const SIDE: usize = 48;

/// A scene whose observation `Workshop::observe` makes.
pub const SCENE: &str = "[object]
radiance = \"object.exr\"
depth = 2.0
[camera]
pixel_pitch = 0.03
[observation]
image = \"observed.exr\"
[medium]
sigma_s = 0.8
sigma_a = 0.1
b = 0.004
";

pub struct Workshop(TempDir);

/// How a run of the program ended.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Workshop {
    pub fn new() -> Self {
        let shop = Self(tempfile::tempdir().unwrap());
        shop.put("object.exr", &[("Y", texture(0))]);
        shop
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn put(&self, name: &str, channels: &[(&str, Image)]) {
        write_exr(&self.file(name), channels);
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.file(name), text).unwrap();
    }

    /// Runs the program in the folder.
    pub fn run(&self, arguments: &str) -> Run {
        let output = narrowbeam(self.0.path(), &arguments.split_whitespace().collect::<Vec<_>>());
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Run {
            code: output.status.code().expect("ended by itself"),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// Writes `scene` as scene.toml and makes observed.exr with its own [medium].
    pub fn observe(&self, scene: &str) {
        self.write("scene.toml", scene);
        let run = self.run("render scene.toml --model small-angle --output observed.exr");
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
}

/// A scene of two surfaces: `depth.exr` has stripes of `width` px, the near one at the left.
pub fn striped(shop: &Workshop, width: usize) -> String {
    let depth = Image::from_fn(SIDE, SIDE, |x, _| if (x / width).is_multiple_of(2) { 1.0 } else { 2.0 });
    shop.put("depth.exr", &[("Z", depth)]);
    SCENE.replace("depth = 2.0", "depth = \"depth.exr\"")
}

/// A pattern of edges and slow changes; `seed` makes others.
pub fn texture(seed: usize) -> Image {
    Image::from_fn(SIDE, SIDE, |x, y| {
        let checker = if (x / (5 + seed) + y / 7).is_multiple_of(2) { 0.7 } else { 0.1 };
        checker + 0.2 * (1.0 + (0.31 * x as f32 + 0.17 * y as f32).sin())
    })
}
