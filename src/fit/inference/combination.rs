//! A combination of parameters.

use serde::{Deserialize, Serialize};

/// A combination of parameters that the data determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Combination {
    /// What it is, in the names of the parameters.
    pub combination: String,
    /// Its value at the estimate.
    pub value: f64,
    /// Standard error from the noise and from stated errors of depth and gain.
    pub std_error: f64,
    /// The same over the value.
    pub relative_error: f64,
    /// Error of the model; `None` where it is not known, as where a free gain takes part.
    pub model_error: Option<f64>,
}
