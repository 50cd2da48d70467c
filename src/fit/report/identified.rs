//! What is determined where not everything is, and what would free the rest.

use super::Fit;
use crate::fit::inference::{ChannelFit, Combination};
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

/// A combination that the data of a channel determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Determined {
    /// The combination.
    #[serde(flatten)]
    pub combination: Combination,
    /// The channel.
    pub channel: String,
}

/// A measurement, and what would be known with it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct AdviceReport {
    /// The channel.
    pub channel: String,
    /// What would be measured or known besides.
    pub measurement: String,
    /// Whether every free parameter would be determined.
    pub frees: bool,
    /// Standard errors of the parameters; null where fixed or still undetermined.
    pub std_errors: IndexMap<String, Option<f64>>,
    /// The same for people.
    pub message: String,
}

impl Fit {
    /// Adds the combinations that `channel` determines.
    pub(super) fn add_determined(&mut self, channel: &str, fit: &ChannelFit) {
        let determined = |combination: &Combination| Determined {
            combination: combination.clone(),
            channel: channel.into(),
        };
        self.determined.extend(fit.determined.iter().map(determined));
    }
}
