//! A number with its error.

use serde::{Deserialize, Serialize};

/// A number that was fitted of a scene, or given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Term {
    /// Its value.
    pub value: f64,
    /// Its standard error; null if it was given or the data leave it undetermined.
    pub std_error: Option<f64>,
}
