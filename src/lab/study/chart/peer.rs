//! The trajectory of the peer: estimates of Mitsuba's differentiable path tracer, iteration by iteration, as
//! `scripts/peer_mitsuba.py` writes them.

use super::dataset::Dataset;
use super::fits::relative_error;
use crate::error::{Error, Result};
use crate::forward::Quantity;
use std::path::Path;

/// Where the peer stands after an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Seconds since it began.
    pub seconds: f64,
    /// Seconds of all cores together that it had by then.
    pub cpu_seconds: f64,
    /// The largest error of sigma_s, sigma_a and B, relative to the truth.
    pub error: f64,
}

/// Columns that are read.
const COLUMNS: [&str; 5] = ["seconds", "cpu_seconds", "sigma_s", "sigma_a", "b"];

/// The trajectory in `path` against the truth of `set`, which has one channel; lines that begin with `#` are skipped.
///
/// # Errors
/// [`Error::Read`], which names the line.
pub fn read_trajectory(path: &Path, set: &Dataset) -> Result<Vec<Step>> {
    let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
    let text = std::fs::read_to_string(path).map_err(|e| failed(e.to_string()))?;
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    let head: Vec<&str> = lines.next().map_or(Vec::new(), |(_, line)| line.split(',').collect());
    let place = |name: &str| {
        let place = head.iter().position(|column| *column == name);
        place.ok_or_else(|| failed(format!("has no column {name}; a trajectory has {}", COLUMNS.join(", "))))
    };
    let places = COLUMNS.iter().map(|name| place(name)).collect::<Result<Vec<_>>>()?;
    let mut steps = Vec::new();
    for (i, line) in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |c: usize| {
            let value = cells.get(places[c]).and_then(|cell| cell.trim().parse::<f64>().ok());
            let fits = value.filter(|v| v.is_finite() && *v >= 0.0);
            fits.ok_or_else(|| {
                failed(format!("line {}: {} must be a number of at least 0", i + 1, COLUMNS[c]))
            })
        };
        let mut error = 0.0_f64;
        for (i, quantity) in Quantity::MEDIUM.into_iter().enumerate() {
            error = error.max(relative_error(quantity, number(2 + i)?, &set.truth[0], set.z).abs());
        }
        steps.push(Step { seconds: number(0)?, cpu_seconds: number(1)?, error });
    }
    Ok(steps)
}
