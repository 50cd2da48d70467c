//! The best optimum by sums, whose evaluations cost next to nothing: from a dense choice of starts, and from kernels of very
//! different widths, which a fit by renders tries only where it failed.

use super::datum::Datum;
use super::observed::Observed;
use super::start::{OTHER_WIDTHS, Scan, Split, place};
use super::sums::Sums;
use super::{Parameters, Problem, Settings, Source, solver, with_optics};
use crate::error::Result;
use crate::scene::FitOptions;

/// Blur widths and factors on the scattering depth tried where a trial costs nothing.
const MANY_WIDTHS: [f64; 12] = [0.002, 0.005, 0.01, 0.017, 0.025, 0.04, 0.06, 0.09, 0.14, 0.2, 0.3, 0.5];
const MANY_DEPTHS: [f64; 5] = [0.5, 1.0, 1.6, 2.5, 4.0];

/// The best that a search has found.
pub(super) struct Search {
    /// Where it began, and the optimum; `None` if the sums cannot tell of the medium there.
    pub best: Option<([f64; 3], Parameters)>,
    /// Evaluations by sums.
    pub evaluations: u64,
}

/// The best of the optima that sums find from the automatic start and from kernels of other widths, or from the values that
/// the user starts with.
pub(super) fn search(
    parameters: &Parameters,
    options: &FitOptions,
    (data, observed, sums): (&[Datum], &[Observed], &[Sums]),
    settings: &Settings,
    median_z: f64,
) -> Result<Search> {
    let mut starts = vec![parameters.clone()];
    let trials = (&MANY_WIDTHS[..], &MANY_DEPTHS[..]);
    let split = Split::mean(data, median_z);
    let scan = Scan { data, observed, split: &split, settings, median_z };
    let mut evaluations = scan.best(&mut starts[0], options, trials, |i, optics| sums[i].products(optics))?;
    if settings.model.spreads() && options.start == [None; 3] {
        for width in OTHER_WIDTHS {
            let mut wide = parameters.clone();
            place(&mut wide, (data, &split), width, median_z);
            starts.push(wide);
        }
    }
    let mut least = f64::INFINITY;
    let mut best = None;
    for start in starts {
        let outcome = solver::run(Problem::new(Source::Sums(sums), observed, &start, settings), settings)?;
        evaluations += outcome.evaluations;
        // Of starts that lead to one optimum the first counts.
        if outcome.equations.cost + outcome.equations.negligible() < least {
            least = outcome.equations.cost;
            let mut found = start.clone();
            found.set_internal(&outcome.point);
            best = Some((start.values(), found));
        }
    }
    let serve = |found: &Parameters| {
        with_optics(found, settings.model, |optics| {
            sums.iter().try_fold(true, |all, sums| Ok(all && sums.serves(optics)?))
        })
    };
    let served = best.as_ref().map_or(Ok(false), |(_, found)| serve(found))?;
    Ok(Search { best: best.filter(|_| served), evaluations })
}
