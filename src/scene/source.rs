//! The file that is being read: what its paths are relative to, and how its errors are worded.

use super::place::of_key;
use crate::error::{Error, Result, number};
use crate::io::input;
use std::path::{Path, PathBuf};

/// Bytes that a scene file has at most: far more than any person writes.
const MOST_BYTES: u64 = 1 << 22;

/// The largest number of a scene. The product of two, summed over the most pixels that there are (2^28), is still a number in f32.
pub(super) const LARGEST: f64 = 1e15;
/// The smallest above 0, whose product with another is still known to all digits.
pub(super) const SMALLEST: f64 = 1.0 / LARGEST;

/// A scene or truth file.
pub(super) struct Source<'a> {
    pub path: &'a Path,
    /// What it holds, if that is still known.
    pub text: String,
}

impl<'a> Source<'a> {
    /// Reads the file at `path`.
    pub fn read(path: &'a Path) -> Result<Self> {
        let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
        let text =
            String::from_utf8(input::read(path, MOST_BYTES)?).map_err(|e| failed(format!("no text: {e}")))?;
        Ok(Self { path, text })
    }

    /// Where a file lies that is named in this one.
    pub fn resolve(&self, named: &Path) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(named)
    }

    /// An error in the file itself, with the place of the key that `message` begins with.
    pub fn error(&self, message: impl Into<String>) -> Error {
        let message = message.into();
        let place = of_key(&self.text, &message);
        self.error_at(place, &message)
    }

    /// An error at this line and column of the file.
    pub fn error_at(&self, place: Option<[usize; 2]>, message: &str) -> Error {
        let place = place.map_or(String::new(), |[line, column]| format!("line {line}, column {column}: "));
        Error::Scene { path: self.path.to_path_buf(), message: format!("{place}{message}") }
    }

    /// `value` if `ok`, else an error that names the key.
    pub fn in_range(&self, key: &str, value: f64, ok: bool, allowed: &str) -> Result<f64> {
        if ok { Ok(value) } else { Err(self.error(format!("{key} = {}: must be {allowed}", number(value)))) }
    }

    /// `value` if it is above 0 and can be computed with.
    pub fn positive(&self, key: &str, value: f64) -> Result<f64> {
        let ok = (SMALLEST..=LARGEST).contains(&value);
        self.in_range(key, value, ok, "above 0, from 1e-15 to 1e15")
    }

    /// `value` if it is at least 0 and can be computed with.
    pub fn non_negative(&self, key: &str, value: f64) -> Result<f64> {
        self.in_range(key, value, (0.0..=LARGEST).contains(&value), "at least 0 and at most 1e15")
    }

    /// `value` if it can be the relative standard error of something: at least 0 and below 1.
    pub fn relative_error(&self, key: &str, value: f64) -> Result<f64> {
        self.in_range(
            key,
            value,
            (0.0..1.0).contains(&value),
            "at least 0 and below 1: a relative standard error",
        )
    }

    /// `value` if it can be computed with.
    pub fn finite(&self, key: &str, value: f64) -> Result<f64> {
        self.in_range(key, value, value.abs() <= LARGEST, "finite, from -1e15 to 1e15")
    }
}
