//! Seeded random damage of everything that users give: scene files, images, the command line. Nothing may panic, abort or hang,
//! and every refusal is one line that blames the input.
//!
//! `NARROWBEAM_FUZZ=500000 cargo test --release --test it fuzz:: -- --nocapture` tries so many files of each class (for every 200th
//! one command line, each a process). An input is made from its number alone, so a number found by a long run is tried again by itself:
//! `NARROWBEAM_FUZZ_FROM=NUMBER NARROWBEAM_FUZZ=1`. What was found stays in fuzz/corpus, from which inputs begin.

mod mutate;

use crate::photographs::made::{jpeg_with_exif, tiff16};
use crate::scene::folder::{Folder, SCENE};
use mutate::{Random, damaged_bytes, damaged_text};
use narrowbeam::Error;
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::exr::{ExrFile, size};
use narrowbeam::io::picture::{self, Picture};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Inputs of each class in an ordinary test run.
const INPUTS: u64 = 4000;
/// Inputs in process for each one by a process of its own.
const PER_PROCESS: u64 = 200;
/// What takes longer hangs.
const LONGEST: Duration = Duration::from_secs(20);

/// The numbers of the inputs to be tried, one of `per` each.
fn numbers(per: u64) -> std::ops::Range<u64> {
    let read = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().unwrap());
    let from = read("NARROWBEAM_FUZZ_FROM").unwrap_or(0);
    from..from + (read("NARROWBEAM_FUZZ").unwrap_or(INPUTS) / per).max(1)
}

/// The files of fuzz/corpus/`class`.
fn corpus(class: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(class);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

/// A file that is written over is flushed to the disk first; a new one is not.
fn replace(path: &Path, bytes: &[u8]) {
    let _ = std::fs::remove_file(path);
    std::fs::write(path, bytes).unwrap();
}

/// Tries inputs `of` this class and counts those that are accepted. Each must end in time, without panicking, and be accepted or
/// refused in one line for what it holds.
fn tried<T>(class: &str, mut of: impl FnMut(u64) -> Result<T, Error>) {
    let (mut accepted, mut slowest) = (0, Duration::ZERO);
    for number in numbers(1) {
        let clock = Instant::now();
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| of(number)));
        let result = result.unwrap_or_else(|_| panic!("{class}: input {number} panics"));
        slowest = slowest.max(clock.elapsed());
        assert!(clock.elapsed() < LONGEST, "{class}: input {number} takes {:?}", clock.elapsed());
        match result {
            Ok(_) => accepted += 1,
            Err(error) => {
                let message = error.to_string();
                assert!(!message.chars().any(char::is_control), "{class}: input {number}: {message:?}");
                assert!(message.len() < 2000, "{class}: input {number}: {message}");
                assert!(error.is_usage(), "{class}: input {number}: {message}");
            }
        }
    }
    println!("{class}: {} inputs, {accepted} accepted, slowest {slowest:?}", numbers(1).count());
}

#[test]
fn damaged_scene_files() {
    let mut texts = corpus("scene");
    texts.push(SCENE.as_bytes().to_vec());
    let folder = Folder::new();
    let path = folder.file("scene.toml");
    tried("scene files", |number| {
        let mut random = Random::new(number);
        replace(&path, &damaged_text(&mut random, &texts));
        // Rendering, fitting and synthesizing read different parts.
        narrowbeam::scene::Scene::read(&path)?;
        narrowbeam::scene::LitScene::read(&path).map(|_| ()).or_else(|error| match error.is_usage() {
            true => Ok(()),
            false => Err(error),
        })?;
        narrowbeam::scene::ObservedScene::read(&path).map(|_| ())
    });
}

#[test]
fn damaged_exr_files() {
    let files = corpus("exr");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("damaged.exr");
    tried("EXR files", |number| {
        let mut random = Random::new(number);
        replace(&path, &damaged_bytes(&mut random, &files));
        let _ = size(&path);
        let file = ExrFile::read(&path)?;
        file.depth().and(file.single()).and(file.radiance()).map(|_| ())
    });
}

/// One small image in each format that cameras and editors write.
fn pictures() -> Vec<Vec<u8>> {
    let dir = tempfile::tempdir().unwrap();
    let channel = |name: &str, shift: usize| Channel {
        name: name.into(),
        image: Image::from_fn(7, 5, |x, y| ((3 * x + 5 * y + shift) % 11) as f32 / 11.0),
    };
    let colours = [channel("R", 0), channel("G", 4), channel("B", 7)];
    let written = |(i, name): (usize, &str)| {
        let path = dir.path().join(name);
        picture::write(&path, if i % 2 == 0 { &colours[..] } else { &colours[..1] }, &[]).unwrap();
        std::fs::read(path).unwrap()
    };
    let names = ["a.png", "b.png", "c.tif", "d.tif", "e.hdr", "f.pfm", "g.pfm"];
    let codes: Vec<u16> = (0..35).map(|i| 1000 * i).collect();
    let jpeg = jpeg_with_exif(8, 8, |x, y| (20 * x + 7 * y) as u8, 6);
    let made = [tiff16(7, 5, 1, &codes), jpeg];
    names.into_iter().enumerate().map(written).chain(made).collect()
}

#[test]
fn damaged_pictures() {
    let files = pictures();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("damaged");
    tried("pictures", |number| {
        let mut random = Random::new(number);
        replace(&path, &damaged_bytes(&mut random, &files));
        let _ = picture::size(&path);
        let read = Picture::read(&path)?;
        read.single().map(|_| ()).or_else(|_| read.file.radiance().map(|_| ()))
    });
}

/// Options and their values, some of them wrong.
const WORDS: [&str; 40] = [
    "--sigma-s",
    "--sigma-a",
    "--b",
    "--g",
    "--spread-angle-deg",
    "--model",
    "--filter",
    "--backend",
    "--output",
    "--samples",
    "--seed",
    "--paths",
    "--out",
    "--memory",
    "--tolerance",
    "--json",
    "--profile",
    "--bootstrap",
    "--hidden-share",
    "--parts",
    "0",
    "1",
    "-1",
    "0.5",
    "8",
    "1e300",
    "nan",
    "inf",
    "1e-300",
    "18446744073709551616",
    "auto",
    "cpu",
    "traced",
    "small-angle",
    "eq29",
    "result",
    "out.exr",
    "scene.toml",
    "missing.toml",
    "\u{1b}[2K\n",
];

#[test]
fn random_command_lines() {
    let folder = Folder::new();
    replace(&folder.file("scene.toml"), SCENE.as_bytes());
    let mut codes = std::collections::BTreeMap::new();
    for number in numbers(PER_PROCESS) {
        let mut random = Random::new(number);
        let command = random.of(&["render", "trace", "synthesize", "fit", "forecast", "melt"]);
        let mut arguments = vec![*command, "scene.toml"];
        if matches!(*command, "render" | "trace" | "synthesize") {
            arguments.extend(["--output", "out.exr"]);
        }
        arguments.extend((0..random.below(4)).map(|_| *random.of(&WORDS)));
        let log = folder.file("stderr");
        let mut child = Command::new(env!("CARGO_BIN_EXE_narrowbeam"))
            .current_dir(folder.file("."))
            .args(&arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(std::fs::File::create(&log).unwrap())
            .spawn()
            .unwrap();
        let clock = Instant::now();
        let status = loop {
            match child.try_wait().unwrap() {
                Some(status) => break status,
                None if clock.elapsed() > LONGEST => {
                    child.kill().unwrap();
                    panic!("input {number} hangs: {arguments:?}");
                }
                None => std::thread::sleep(Duration::from_millis(2)),
            }
        };
        let said = String::from_utf8_lossy(&std::fs::read(&log).unwrap()).into_owned();
        let code = status.code();
        assert!(matches!(code, Some(0..=3)), "input {number}: {arguments:?}: {status}: {said}");
        assert!(!said.contains("panicked"), "input {number}: {arguments:?}: {said}");
        *codes.entry(code).or_insert(0) += 1;
    }
    println!("command lines: {} runs, exit codes {codes:?}", numbers(PER_PROCESS).count());
}
