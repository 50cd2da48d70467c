//! One model that was tried.

use serde::{Deserialize, Serialize};

/// One model that was tried.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(schemars::JsonSchema))]
pub struct Candidate {
    /// Its name.
    pub model: String,
    /// The medium's parameters of each channel, as far as determined; empty if the model was not fitted.
    pub estimates: Vec<Vec<Option<f64>>>,
    /// Root mean square error of a pixel by the model, in units of the noise, of the worst channel; `None` if not known.
    pub image_error: Option<f64>,
    /// Reduced chi² over all channels, of a fit.
    pub reduced_chi2: Option<f64>,
    /// Bayesian information criterion, over all channels, of a fit.
    pub bic: Option<f64>,
    /// Time that it took, seconds.
    pub seconds: f64,
    /// Why it does not suffice; `None` if it does.
    pub shortcoming: Option<String>,
    /// Whether it is the one that was taken.
    pub taken: bool,
}

impl Candidate {
    /// A line for people.
    pub fn line(&self) -> String {
        let outcome = match (&self.shortcoming, self.taken) {
            (None, _) => "suffices".to_string(),
            (Some(why), true) => format!("taken though {why}"),
            (Some(why), false) => why.clone(),
        };
        let fitted = self.reduced_chi2.map_or("not fitted".into(), |chi2| format!("reduced chi² {chi2:.4}"));
        format!("{:<15} {:>7.3} s   {fitted:<20} {outcome}", self.model, self.seconds)
    }
}
