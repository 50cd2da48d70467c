//! Where a report comes from: what has to be done to have it again.

use serde::{Deserialize, Serialize};

/// Where a report comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// When the report was made, UTC, as RFC 3339 has it.
    pub date: String,
    /// The folder that the program ran in.
    pub working_directory: Option<String>,
    /// The command line, the program's name first.
    pub arguments: Vec<String>,
    /// What was computed, as it was after the program had chosen whatever was left to it.
    pub settings: ResolvedSettings,
    /// The scene files, and every file that they name.
    pub inputs: Vec<InputFile>,
    /// The graphics adapter, if one was used.
    pub adapter: Option<String>,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// The settings of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct ResolvedSettings {
    /// Spread model.
    pub model: String,
    /// Filter for depth maps.
    pub filter: String,
    /// What computed the renders, `cpu` or `gpu`.
    pub backend: String,
    /// Optimiser.
    pub solver: String,
    /// Iterations after which it gives up.
    pub max_iterations: u64,
    /// Relative error of a parameter up to which a cheaper model is accepted.
    pub tolerance: f64,
    /// Seconds that may be spent on traced paths where the program chooses the model.
    pub traced_limit: f64,
    /// Paths that were traced, over all scenes and channels; 0: none.
    pub paths: u64,
    /// Whether there are intervals by profile likelihood.
    pub profile: bool,
    /// Refits with new noise.
    pub bootstrap: u64,
}

/// A file that a report was made of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct InputFile {
    /// Its path, as it was given, or as the scene file names it.
    pub path: String,
    /// SHA-256 of its contents, as hexadecimal digits; null for a pipe.
    pub sha256: Option<String>,
}
