//! What the files that a command writes say of how they were made.

use super::console::detail;
use super::results::sha256;
use crate::fit::InputFile;
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use rayon::prelude::*;
use std::path::PathBuf;

/// The command line, the program's name first.
pub(super) fn arguments() -> Vec<String> {
    let program = std::iter::once("narrowbeam".to_string());
    program.chain(std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned())).collect()
}

/// Software and command line.
pub(super) fn provenance() -> Vec<(String, String)> {
    vec![
        ("software".into(), concat!("narrowbeam ", env!("CARGO_PKG_VERSION")).into()),
        ("command".into(), arguments().join(" ")),
    ]
}

/// The time now, UTC, as RFC 3339 has it.
pub(super) fn now() -> String {
    humantime::format_rfc3339_seconds(std::time::SystemTime::now()).to_string()
}

/// The media of the channels; one value per channel.
pub(super) fn record_of(media: &[Medium]) -> Vec<(String, String)> {
    let each =
        |value: fn(&Medium) -> f64| media.iter().map(|m| value(m).to_string()).collect::<Vec<_>>().join(" ");
    let parameter = media[0].phase().family().parameter_name();
    let pairs = [
        ("sigma_s", each(Medium::sigma_s)),
        ("sigma_a", each(Medium::sigma_a)),
        (parameter, each(|m| m.phase().parameter())),
    ];
    pairs.map(|(key, value)| (key.to_string(), value)).to_vec()
}

/// Tells which files are read, if that is wanted.
pub(super) fn tell_inputs(paths: &[PathBuf]) {
    paths.iter().for_each(|path| detail(|| format!("reading {}", path.display())));
}

/// The files at `paths`, each once, with their SHA-256.
pub(super) fn inputs(paths: &[PathBuf]) -> Vec<InputFile> {
    let mut once: Vec<&PathBuf> = Vec::new();
    for path in paths {
        if !once.contains(&path) {
            once.push(path);
        }
    }
    let read = |path: &&PathBuf| InputFile { path: path.display().to_string(), sha256: sha256(path).ok() };
    once.par_iter().map(read).collect()
}
