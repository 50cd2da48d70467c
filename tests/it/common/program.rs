//! Running the program as users do, and the images it reads.

use super::report;
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::exr;
use std::path::Path;
use std::process::{Command, Output};

/// Runs `narrowbeam` in `dir` with `arguments`, and reads the reports that it makes.
pub fn narrowbeam(dir: &Path, arguments: &[&str]) -> Output {
    let output =
        Command::new(env!("CARGO_BIN_EXE_narrowbeam")).current_dir(dir).args(arguments).output().unwrap();
    if matches!(output.status.code(), Some(0 | 3)) && matches!(arguments[0], "fit" | "forecast") {
        report::read_all(dir, arguments, std::str::from_utf8(&output.stdout).unwrap());
    }
    output
}

/// Standard output of a run that exits 0.
pub fn succeeds(dir: &Path, arguments: &[&str]) -> String {
    let output = narrowbeam(dir, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Asserts that a run exits 2 with a message that holds all of `words`, says nothing on stdout, and leaves as many
/// files in `dir` as before.
pub fn refuses(dir: &Path, arguments: &[&str], words: &[&str]) {
    let files = || std::fs::read_dir(dir).unwrap().count();
    let before = files();
    let output = narrowbeam(dir, arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert!(words.iter().all(|word| message.contains(word)), "{words:?} are not all in: {message}");
    assert!(output.stdout.is_empty(), "{arguments:?}");
    assert_eq!(files(), before, "{arguments:?} wrote something");
}

/// Writes an EXR file of named channels.
pub fn write_exr(path: &Path, channels: &[(&str, Image)]) {
    let channel = |(name, image): &(&str, Image)| Channel { name: name.to_string(), image: image.clone() };
    exr::write(path, &channels.iter().map(channel).collect::<Vec<_>>(), &[]).unwrap();
}
