//! The design of a measurement: its errors before anyone measures, and what would free what is undetermined.

mod advice;
mod forecast;

pub use advice::{Advice, advise};
pub use forecast::{Plan, forecast};

use super::Settings;
use super::scenes::{SceneFit, observations, reliefs};
use crate::error::Result;
use crate::filter::Filter;
use crate::scene::ObservedScene;

/// Adds to the report of `fit`, that of `scenes`, which measurement would free what is undetermined, if something is.
///
/// # Errors
/// As [`advise`].
pub fn add_advice(
    fit: &mut SceneFit,
    scenes: &[ObservedScene],
    settings: &Settings,
    filter: Filter,
    progress: &dyn Fn(),
) -> Result<()> {
    let reliefs = reliefs(scenes, filter);
    let channels = fit.channels.len();
    for (i, (name, channel)) in fit.channels.iter().enumerate() {
        let advice = advise(&observations(scenes, &reliefs, i), channel, settings, progress)?;
        fit.report.advice.extend(advice.iter().map(|one| one.report(name, channels)));
    }
    Ok(())
}
