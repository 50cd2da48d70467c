//! The best optimum by Gram matrices, whose evaluations cost next to nothing: from a dense choice of starts, and from kernels
//! of very different widths, which a fit by renders tries only where it failed.

use super::problem::Problem;
use super::scene_models::SceneModels;
use super::solver;
use super::start::{OTHER_WIDTHS, Start, Trials};
use crate::error::Result;
use crate::fit::Settings;
use crate::fit::observation::Observed;
use crate::fit::parameters::Parameters;

/// Blur widths and factors on the scattering depth tried where a trial costs nothing.
const MANY: Trials = Trials {
    widths: &[0.002, 0.005, 0.01, 0.017, 0.025, 0.04, 0.06, 0.09, 0.14, 0.2, 0.3, 0.5],
    depths: &[0.5, 1.0, 1.6, 2.5, 4.0],
};

/// An optimum and where the way to it began.
pub(crate) struct Found {
    pub start: Parameters,
    pub optimum: Parameters,
}

/// What a search has found.
pub(crate) struct Search {
    /// The best; `None` if the matrices do not serve the medium there.
    pub best: Option<Found>,
    /// Evaluations by Gram matrices.
    pub evaluations: u64,
}

/// The best of the optima that `models` find from the automatic `start` of `parameters` and from kernels of other widths, or
/// from the values that the user starts with.
pub(crate) fn search<'a>(
    parameters: &Parameters,
    start: &Start<'_, 'a>,
    observed: &[Observed<'a>],
    models: &SceneModels<'a>,
    settings: &Settings,
) -> Result<Search> {
    let mut first = parameters.clone();
    let mut evaluations = start.scan(&mut first, MANY, &|| (), || Ok(models))?;
    let mut starts = vec![first];
    if start.is_automatic() {
        for width in OTHER_WIDTHS {
            let mut wide = parameters.clone();
            start.place(&mut wide, width);
            starts.push(wide);
        }
    }
    let mut least = f64::INFINITY;
    let mut best: Option<Found> = None;
    for start in starts {
        let problem = Problem::new(models, observed, &start, &|| ());
        let outcome = solver::run(problem, settings.method, settings.max_iterations)?;
        evaluations += outcome.evaluations;
        // Of starts that lead to one optimum the first counts.
        if outcome.equations.cost + outcome.equations.negligible() < least {
            least = outcome.equations.cost;
            let optimum = start.at(&outcome.point);
            best = Some(Found { start, optimum });
        }
    }
    let served = match &best {
        Some(found) => models.coverage(&found.optimum)?.served,
        None => false,
    };
    Ok(Search { best: best.filter(|_| served), evaluations })
}
