//! A folder with a scene, the program to run on it, and what it said.

use crate::common::program::{narrowbeam, write_exr};
use narrowbeam::image::Image;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
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

impl Run {
    fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self {
            code: output.status.code().expect("ended by itself"),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }
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
        Run::of(narrowbeam(self.0.path(), &arguments.split_whitespace().collect::<Vec<_>>()))
    }

    /// The program in the folder, to be run in another way.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_narrowbeam"));
        command.current_dir(self.0.path()).args(arguments.split_whitespace());
        command.stdout(Stdio::null()).stderr(Stdio::null());
        command
    }

    /// Runs the program in the folder by a line for the shell, in which `narrowbeam` is its name, and returns how it ended.
    pub fn shell(&self, line: &str) -> Run {
        let line = line.replace("narrowbeam", "\"$NARROWBEAM\"");
        let mut shell = Command::new("sh");
        shell
            .current_dir(self.0.path())
            .args(["-c", &line])
            .env("NARROWBEAM", env!("CARGO_BIN_EXE_narrowbeam"));
        Run::of(shell.output().unwrap())
    }

    /// The bytes of a file of the folder.
    pub fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.file(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Names of what is in a folder of the folder, in order.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.file(folder)).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort_unstable();
        names
    }

    /// Writes `scene` as scene.toml and makes observed.exr with its own [medium].
    pub fn observe(&self, scene: &str) {
        self.write("scene.toml", scene);
        // The program does not write over an image that the scene names.
        let _ = std::fs::remove_file(self.file("observed.exr"));
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
