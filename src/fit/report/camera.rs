//! What was freed of a camera, and why.

use crate::fit::inference::Cause;
use serde::{Deserialize, Serialize};

/// A key of `[observation]` that was left to the fit and changed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct CameraStep {
    /// Number of the scene, from 0.
    pub scene: usize,
    /// The key with its new value, as in a scene file.
    pub set: String,
    /// What the residual spoke of.
    pub cause: Cause,
    /// Drop of chi² that it promised; null where the observation was seen to lie far off, where the noise of the clear image hides that
    /// from the residual, or where what was freed came out as nothing.
    pub delta_chi2: Option<f64>,
    /// Reduced chi² of the fit that followed; null for the last one, which is the report's.
    pub reduced_chi2: Option<f64>,
    /// Time of that fit, seconds.
    pub seconds: f64,
}

impl CameraStep {
    /// A step in scene number `scene`.
    pub(in crate::fit) fn new(scene: usize, set: String, cause: Cause, delta_chi2: Option<f64>) -> Self {
        Self { scene, set, cause, delta_chi2, reduced_chi2: None, seconds: 0.0 }
    }

    /// A line for people.
    pub fn line(&self) -> String {
        let why = match self.delta_chi2 {
            Some(drop) => format!("the residual shows {} (chi² would drop by {drop:.0})", self.cause),
            None => format!("{} is looked at first", self.cause),
        };
        let after = self.reduced_chi2.map_or(String::new(), |chi2| format!(": reduced chi² {chi2:.4}"));
        format!("scene {}: {} set, {why}{after}", self.scene + 1, self.set)
    }
}
