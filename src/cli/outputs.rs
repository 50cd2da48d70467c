//! Outputs that would destroy what a command reads are refused before any work.

use super::console::detail;
use crate::error::{Error, Result};
use crate::io::{atomic, identity};
use std::path::{Path, PathBuf};

/// Refuses `output` if it is one of the files `inputs`, in whatever spelling or by whatever link, or cannot be written.
///
/// # Errors
/// [`Error::Protected`] or [`Error::Write`] with the path.
pub(super) fn check(output: &Path, inputs: &[PathBuf]) -> Result<()> {
    detail(|| format!("to be written: {}", output.display()));
    spare(output, inputs, "write elsewhere, or move it away first")?;
    atomic::check_writable(output)
}

/// Refuses to touch `path` if it is one of the files `inputs`.
///
/// # Errors
/// [`Error::Protected`] with the path.
pub(super) fn spare(path: &Path, inputs: &[PathBuf], advice: &str) -> Result<()> {
    // Pipes and devices lose nothing.
    let input = inputs.iter().find(|input| input.is_file() && identity::same(input, path));
    input.map_or(Ok(()), |input| {
        let whose = if input == path { "an input".into() } else { format!("the input {}", input.display()) };
        Err(Error::Protected { path: path.into(), why: format!("is {whose}, and would be lost; {advice}") })
    })
}
