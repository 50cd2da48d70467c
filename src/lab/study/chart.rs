//! What accuracy costs: time against error, of renders and of fits, on scenes seen through a known medium.
//!
//! The truth of a render is the observation of a [`Dataset`], made by a program that does not use the models. Its noise
//! is known and subtracted in squares ([`rms_error`](crate::lab::compare::rms_error)). The truth of a fit is the medium. Both have
//! a *floor*: the error that a perfect render, or a perfect fit, would still show because of the noise.
//!
//! Times are medians of several runs.

mod dataset;
mod fits;
mod pareto;
mod peer;
mod renders;
mod timing;

pub use dataset::Dataset;
pub use fits::{FitTrial, Fitted};
pub use pareto::front;
pub use peer::{Step, read_trajectory};
pub use renders::{RenderTrial, Rendered, Way};
pub use timing::{Effort, Timing};

use crate::filter::Backend;

/// All that was found on one dataset.
#[derive(Debug, Clone)]
pub struct Charted {
    /// What was rendered and fitted.
    pub dataset: Dataset,
    /// Renders by every model, filter and backend, and traced ones.
    pub renders: Vec<RenderTrial>,
    /// Fits by every model and backend.
    pub fits: Vec<FitTrial>,
    /// The trajectory of the peer, if it is known.
    pub peer: Vec<Step>,
}

impl Charted {
    /// Renders and fits `dataset` in every way; `tick` is called after each.
    pub fn new(
        dataset: Dataset,
        peer: Vec<Step>,
        backends: &[Backend],
        effort: &Effort,
        tick: &dyn Fn(),
    ) -> Self {
        let renders = dataset.ways(backends.len(), effort).into_iter().map(|way| {
            let trial = way.try_on(&dataset, backends, effort);
            tick();
            trial
        });
        let renders = renders.collect();
        let fits = fits::all(&dataset, backends, effort, tick);
        Self { dataset, renders, fits, peer }
    }

    /// How many renders and fits [`new`](Self::new) makes.
    pub fn count(dataset: &Dataset, backends: usize, effort: &Effort) -> usize {
        dataset.ways(backends, effort).len() + fits::count(backends)
    }

    /// The largest relative standard error of a parameter with the automatic choice of a model; `None` if it leaves one
    /// undetermined.
    pub fn fit_floor(&self) -> Option<f64> {
        let automatic = self.fits.iter().find(|trial| trial.method.model.is_none())?;
        automatic.outcome.as_ref().ok().map(|fitted| fitted.std_error)
    }
}
