//! The result of a fit as users read it, in programs, in `fit.json`, and on the terminal.
//!
//! A [`Fit`] holds plain values only. JSON is made of it at the edge, and read back as a [`Fit`].

mod build;
mod camera;
mod candidate;
mod derived;
mod diagnosis;
mod estimate;
mod exposure;
mod identified;
mod imaging;
mod number;
mod provenance;
mod regime;
mod summary;
mod term;
mod text;
mod warning;
mod warnings;

pub use camera::CameraStep;
pub use candidate::Candidate;
pub use derived::Derived;
pub use diagnosis::DiagnosisReport;
pub use estimate::{Estimate, Ways};
pub use exposure::ExposureReport;
pub use identified::{AdviceReport, Determined};
pub use imaging::{BlurReport, FieldReport, RegistrationErrors, RegistrationReport};
pub use provenance::{InputFile, Provenance, ResolvedSettings};
pub use regime::Regime;
pub use summary::{Summary, TracedSummary};
pub use term::Term;
pub use warning::{Severity, Warning, WarningCode};

pub(super) use build::suffix;

use super::inference::Status;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// Everything about a fit, over all its channels. Names of parameters end in `.R` and so on for colour.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Fit {
    /// Version of the program.
    pub version: String,
    /// Spread model.
    pub model: String,
    /// Family of the phase function.
    pub phase: String,
    /// Filter for depth maps.
    pub filter: String,
    /// What computed the renders.
    pub backend: BackendReport,
    /// sigma_s, sigma_a, b or g.
    pub parameters: IndexMap<String, Estimate>,
    /// Quantities that follow from them.
    pub derived: IndexMap<String, Derived>,
    /// Correlations of the parameters' errors, `sigma_s,sigma_a` and so on; null where one of the two is fixed or
    /// undetermined.
    pub correlations: IndexMap<String, Option<f64>>,
    /// How the fit went, over all channels.
    pub fit: Summary,
    /// Gain, veil, noise and misfit of every scene and channel.
    pub exposures: Vec<ExposureReport>,
    /// Starting values used.
    pub start: IndexMap<String, Option<f64>>,
    /// The command line, if there was one.
    pub command: Option<String>,
    /// Where the report comes from, if the program made it.
    #[serde(default)]
    pub provenance: Option<Provenance>,
    /// The other files of the set of results, by name, with their SHA-256 as hexadecimal digits; empty if nothing was written.
    #[serde(default)]
    pub files: IndexMap<String, String>,
    /// Combinations of the parameters that the data determine where they leave one open, or hold two only together.
    pub determined: Vec<Determined>,
    /// Which measurement would free what is undetermined, the best first; empty if nothing is.
    pub advice: Vec<AdviceReport>,
    /// The models that were tried, cheapest first; empty if one was asked for.
    #[serde(rename = "ladder", default, skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<Candidate>,
    /// What the scenes left open of their cameras and the images asked for, in the order in which it was freed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub camera: Vec<CameraStep>,
    /// What the residual says of the scenes, the largest drop of chi² first.
    pub diagnosis: Vec<DiagnosisReport>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

/// What computed the renders.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct BackendReport {
    /// `cpu` or `gpu`.
    pub kind: String,
    /// The graphics adapter, if one was used.
    pub adapter: Option<String>,
    /// Why there, if the program chose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl Fit {
    /// Whether every fit converged, no image contradicts its scene, and every free parameter, those of scenes included, is
    /// determined.
    pub fn is_complete(&self) -> bool {
        let determined = self.parameters.values().all(|p| matches!(p.status, Status::Free | Status::Fixed));
        let registered = self.exposures.iter().filter_map(|e| e.registration.as_ref());
        self.fit.converged && determined && registered.into_iter().all(RegistrationReport::is_determined)
    }

    /// Adds the 95 % interval of the parameter `name` that was found in this way.
    pub(super) fn add_interval(&mut self, name: &str, way: Ways, interval: Option<[Option<f64>; 2]>) {
        if let Some(estimate) = self.parameters.get_mut(name) {
            match way {
                Ways::Profile => estimate.profile95 = Some(interval),
                Ways::Bootstrap => estimate.bootstrap95 = Some(interval),
            }
        }
    }
}
