//! The file that is being read: what its paths are relative to, and how its errors are worded.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};

/// A scene or truth file.
pub(super) struct Source<'a> {
    pub path: &'a Path,
}

impl Source<'_> {
    /// Where a file lies that is named in this one.
    pub fn resolve(&self, named: &Path) -> PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(named)
    }

    /// An error in the file itself.
    pub fn error(&self, message: impl Into<String>) -> Error {
        Error::Scene { path: self.path.to_path_buf(), message: message.into() }
    }

    /// `value` if `ok`, else an error that names the key.
    pub fn in_range(&self, key: &str, value: f64, ok: bool, allowed: &str) -> Result<f64> {
        if ok { Ok(value) } else { Err(self.error(format!("{key} = {value}: must be {allowed}"))) }
    }

    /// `value` if it is finite and above 0.
    pub fn positive(&self, key: &str, value: f64) -> Result<f64> {
        self.in_range(key, value, value.is_finite() && value > 0.0, "finite and above 0")
    }

    /// `value` if it is finite and at least 0.
    pub fn non_negative(&self, key: &str, value: f64) -> Result<f64> {
        self.in_range(key, value, value.is_finite() && value >= 0.0, "finite and at least 0")
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

    /// `value` if it is finite.
    pub fn finite(&self, key: &str, value: f64) -> Result<f64> {
        self.in_range(key, value, value.is_finite(), "finite")
    }
}
