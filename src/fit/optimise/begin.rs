//! Where a fit begins.

use super::scene_models::SceneModels;
use super::search::{Found, search};
use super::start::Start;
use super::task::Task;
use crate::error::Result;
use crate::fit::parameters::Parameters;

/// How a start is chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum From {
    /// From the images.
    Images,
    /// A kernel of this width, views.
    Width(f64),
}

/// The beginning of a fit.
pub(crate) struct Begun<'x> {
    /// Where the way to the optimum begins, as reports say it.
    pub start: Parameters,
    /// Where it has come so far.
    pub parameters: Parameters,
    /// Gram matrices, where they serve the medium.
    pub gram: Option<&'x SceneModels<'x>>,
    /// Renders so far.
    pub evaluations: u64,
    /// Evaluations by Gram matrices so far.
    pub gram_evaluations: u64,
}

impl<'x> Begun<'x> {
    /// The beginning of `task`, `from` somewhere, by Gram matrices if there are any.
    pub(crate) fn new(task: &Task<'x, '_>, from: From, gram: Option<&'x SceneModels<'x>>) -> Result<Self> {
        let lengths = task.lengths();
        let engine = task.settings.engine();
        let start = Start::new(task.registered, task.options, &engine, lengths.median);
        let mut medium = Parameters::new(task.options, engine.model, lengths)?;
        let begun =
            |start: Parameters, medium: Parameters, gram, [evaluations, gram_evaluations]: [u64; 2]| {
                let parameters = task.with_nuisances(medium);
                Self { start, parameters, gram, evaluations, gram_evaluations }
            };
        let mut searched = 0;
        if let Some(models) = gram {
            let search = search(&medium, &start, task.registered, models, task.settings)?;
            searched = search.evaluations;
            if let Some(Found { start, optimum }) = search.best {
                return Ok(begun(start, optimum, gram, [0, searched]));
            }
        }
        let evaluations = match from {
            From::Images => start.choose(&mut medium, task.progress)?,
            From::Width(width) => {
                start.place(&mut medium, width);
                0
            }
        };
        Ok(begun(medium.clone(), medium, None, [evaluations, searched]))
    }
}
