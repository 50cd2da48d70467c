//! Fitting a medium to observed images: sigma_s, sigma_a and B or g of one channel from any number of scenes.
//!
//! The residual of a pixel is r = (gain · I(sigma_s, sigma_a, B) + veil - observed) / noise, I being the rendered
//! object light, and noise one number a scene or the root of each pixel's variance. A free gain or veil enters linearly and
//! is eliminated at every step (variable projection, Golub and Pereyra 1973); the rest is a damped Gauss-Newton iteration in
//! (ln sigma_s, sigma_a, ln B), or ln(1 - g) in place of ln B for Henyey-Greenstein's phase function.

mod advice;
mod bounded_step;
mod channel_fit;
mod comparison;
mod datum;
mod displacement;
mod equations;
mod exposure;
mod foresee;
mod identifiability;
mod input_error;
mod intervals;
mod model_error;
mod observed;
mod parameters;
mod path_lengths;
mod problem;
mod renders;
mod search;
mod solver;
mod start;
mod structure;
mod sums;
mod traced;
mod uncertainty;

pub mod forecast;
pub mod ladder;
pub mod noise;
pub mod report;
pub mod scenes;

pub use advice::{Advice, advise};
pub use channel_fit::ChannelFit;
pub use datum::{Datum, NoiseTerm, VeilTerm};
pub use exposure::Exposure;
pub use identifiability::Combination;
pub use input_error::InputError;
pub use intervals::{Intervals, bootstrap, profile};
pub use model_error::ModelError;
pub use parameters::{Bounds, NAMES, Parameters, names};
pub use path_lengths::{PathLengths, path_lengths};

pub use solver::Method;
pub use traced::{MOST_PATHS, Tracing, render_traced};
pub use uncertainty::{Status, Uncertainty};

use crate::error::Result;
use crate::filter::{Backend, Coverage, hidden_share};
use crate::geometry::Geometry;
use crate::image::Image;
use crate::relief::Relief;
use crate::scene::{FitOptions, Gain};
use crate::spread::Model;
use displacement::Displacement;
use exposure::exposures;
use foresee::foresee;
use nalgebra::Vector3;
use observed::Observed;
use problem::{Problem, Source, with_optics};
use renders::Renders;
use start::Split;
use sums::Sums;

/// What to fit with.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// The spread model.
    pub model: Model,
    /// What renders.
    pub backend: Backend<'a>,
    /// The optimiser.
    pub method: Method,
    /// Iterations after which a fit is given up.
    pub max_iterations: u64,
    /// Whether to find the optimum by sums over the image where a scene allows it, instead of by renders.
    pub sums: bool,
    /// What the model `traced` traces.
    pub tracing: Tracing,
    /// Called after every render.
    pub progress: &'a dyn Fn(),
}

impl Settings<'_> {
    /// The same with fewer paths if the medium is yet `sought`.
    fn for_search(&self, sought: bool) -> Self {
        Self { tracing: if sought { self.tracing.fewer() } else { self.tracing }, ..*self }
    }
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self {
            model: Model::SmallAngle,
            backend: Backend::Cpu,
            method: Method::LevenbergMarquardt,
            max_iterations: 200,
            sums: true,
            tracing: Tracing::default(),
            progress: &|| (),
        }
    }
}

/// How much wider than at the start the kernels may become before a fit is planned anew.
pub const HEADROOM: f64 = 1.4;
/// Reduced chi² above which a fit is said not to describe the image: half as much misfit as noise.
const MISFIT: f64 = 1.5;
/// Relative change of the estimated noise below which the scenes' weights are settled.
const NOISE_SETTLED: f64 = 0.02;
/// Times a fit is planned anew, or the noise estimated anew, at most; and times that paths are traced anew, whose steps are
/// shorter.
const MOST_ROUNDS: usize = 6;
const MOST_TRACED_ROUNDS: usize = 16;
/// Those of them that make do with few paths, whose noise may keep them from coming to rest.
const MOST_SCOUTING_ROUNDS: usize = 8;

/// Fits one channel's medium to `data`; all scenes share it.
///
/// If the fit from the automatic start does not describe the images or ends on a bound, it may have ended in a false
/// minimum: kernels of other widths are then tried as starts too, and the best of all fits counts; by sums they always are.
/// Edges and slopes explain a misfit in another way, so scenes that have some are not tried again.
///
/// # Errors
/// [`NothingToFit`](crate::Error::NothingToFit) if no pixel counts or every parameter is fixed,
/// [`OutOfRange`](crate::Error::OutOfRange) for contradictory options, [`NotFinite`](crate::Error::NotFinite) if a render is not
/// finite, those of [`Model::range`].
pub fn fit_channel(data: &[Datum], options: &FitOptions, settings: &Settings) -> Result<ChannelFit> {
    let observed = data.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
    if settings.model == Model::Traced {
        let pilot = fit_channel(data, options, &Settings { model: traced::PILOT, ..*settings })?;
        let found = pilot.parameters.values();
        let start = std::array::from_fn(|i| options.start[i].or(Some(found[i])));
        return fit_from((data, observed), &FitOptions { start, ..*options }, settings, (None, None));
    }
    let sums = settings.sums.then(|| Sums::of_all(&observed)).flatten();
    let fit = |width, sums| fit_from((data, observed.clone()), options, settings, (width, sums));
    let mut best = fit(None, sums.as_deref())?;
    let automatic = settings.model.spreads() && options.start == [None; 3];
    let flat = || data.iter().all(|d| Relief::new(d.target.geometry).is_flat());
    let doubtful = best.reduced_chi2 > MISFIT
        || best.structure > structure::STRUCTURED
        || best.parameters.at_bound().iter().any(|&i| Parameters::is_logarithmic(i));
    if doubtful && automatic && best.by_sums.is_none() && flat() {
        for width in start::OTHER_WIDTHS {
            let other = fit(Some(width), None)?;
            if other.reduced_chi2 < best.reduced_chi2 {
                best = other;
            }
        }
    }
    Ok(best)
}

/// The fit from one start, the automatic one or a kernel of a `width` in views; by `sums`, if there are any, from the best
/// of all starts.
fn fit_from<'a>(
    (data, mut observed): (&[Datum<'a>], Vec<Observed<'a>>),
    options: &FitOptions,
    settings: &Settings<'a>,
    (width, mut sums): (Option<f64>, Option<&[Sums]>),
) -> Result<ChannelFit> {
    let scenes: Vec<&Geometry> = data.iter().map(|d| d.target.geometry).collect();
    let lengths = path_lengths(&scenes);
    let median_z = lengths.median;
    let mut parameters = Parameters::new(options, settings.model, lengths)?;
    let (mut evaluations, mut sum_evaluations) = (0, 0);
    let mut start = None;
    if let Some(all) = sums {
        let search = search::search(&parameters, options, (data, &observed, all), settings, median_z)?;
        sum_evaluations += search.evaluations;
        match search.best {
            Some((from, best)) => (start, parameters) = (Some(from), best),
            None => sums = None,
        }
    }
    match (start, width) {
        (Some(_), _) => {}
        (None, None) => {
            evaluations += start::choose(&mut parameters, options, data, &observed, settings, median_z)?;
        }
        (None, Some(width)) => {
            let split = Split::mean(data, median_z);
            start::place(&mut parameters, (data, &split), width, median_z);
        }
    }
    let start = start.unwrap_or(parameters.values());
    let unknown_noise = data.iter().any(|d| d.noise.is_none());
    let mut iterations = 0;
    let mut round = 0;
    let mut scouting = settings.model == Model::Traced;
    let most_rounds = if scouting { MOST_TRACED_ROUNDS } else { MOST_ROUNDS };
    let mut renders = Renders::new(data, &observed, &parameters, &settings.for_search(scouting))?;
    loop {
        round += 1;
        if let Some(sums) = sums {
            let found =
                solver::run(Problem::new(Source::Sums(sums), &observed, &parameters, settings), settings)?;
            sum_evaluations += found.evaluations;
            parameters.set_internal(&found.point);
        }
        let by_sums = sums.map(|_| parameters.values());
        let problem = Problem::new(Source::Renders(&renders), &observed, &parameters, settings);
        let mut outcome = solver::run(problem, settings)?;
        iterations += outcome.iterations;
        evaluations += outcome.evaluations;
        if settings.model == Model::Traced && outcome.equations.cost <= 0.0 {
            (outcome.converged, outcome.stop) = (false, traced::TOO_FEW.into());
        }
        if scouting && !outcome.converged {
            scouting = false;
            renders = Renders::new(data, &observed, &parameters, settings)?;
            continue;
        }
        parameters.set_internal(&outcome.point);
        let unsettled = exposures(&outcome.equations, &observed, None);
        let images = renders.exposed(&parameters, settings, &unsettled, data)?;
        // Only the ratio of the scenes' weights moves the optimum, so one scene is settled whatever its noise.
        let mut change: f64 = 0.0;
        for (i, (o, datum)) in observed.iter_mut().zip(data).enumerate() {
            if datum.noise.is_none() {
                let noise = renders.noise(i, &parameters, (o, &unsettled[i], &images[i]))?;
                change = change.max((noise / o.noise - 1.0).abs());
                o.noise = noise;
            }
        }
        let hidden_shares = hidden_shares(data, &parameters, settings)?;
        let mut uncovered = false;
        for (i, (o, share)) in observed.iter_mut().zip(&hidden_shares).enumerate() {
            if let Some(share) = share
                && round < most_rounds
                && o.leave_out_hidden(share)?
            {
                renders.observe(i, o)?;
                uncovered = true;
            }
        }
        let settled = !uncovered && (data.len() == 1 || change < NOISE_SETTLED);
        let Coverage { served, cut } = renders.coverage(&parameters, settings)?;
        let settled = settled && served && !scouting;
        if settled || round == most_rounds || !outcome.converged {
            let problem = Problem::new(Source::Renders(&renders), &observed, &parameters, settings);
            let last = if unknown_noise { problem.equations(&outcome.point)? } else { outcome.equations };
            let fitted = parameters.free_count() + data.iter().map(Datum::free_exposure).sum::<usize>();
            let pixels = observed.iter().map(Observed::pixels).sum::<usize>();
            let reduced_chi2 = 2.0 * last.cost / pixels.saturating_sub(fitted).max(1) as f64;
            // Where the noise was only estimated, a misfit counts as noise for the error bars.
            let inflation = if unknown_noise { reduced_chi2.max(1.0) } else { 1.0 };
            let mut uncertainty = Uncertainty::new(&last, &parameters, median_z, inflation);
            let pull = uncertainty.step(&last.gradient);
            let exposures = exposures(&last, &observed, Some(&uncertainty));
            let (transforms, paths) = (renders.transforms(), renders.paths(&parameters)?);
            let mut at_optimum = Displacement {
                data,
                observed: &observed,
                renders: &mut renders,
                parameters: &parameters,
                uncertainty: &uncertainty,
                exposures: &exposures,
                settings,
            };
            let model_error = ModelError::new(&mut at_optimum)?;
            let input_error = InputError::new(&mut at_optimum)?;
            let structures = observed.iter().zip(&images).map(|(o, image)| structure::structure(o, image));
            let structure = structures.fold(0.0, f64::max);
            if let Some(error) = &model_error {
                let unknown = |g: &Vector3<f64>| error.reference_of(g) + error.variance_of(g).sqrt();
                uncertainty.distrust(|i| unknown(&Vector3::ith(i, 1.0)), median_z);
            }
            let mut fit = ChannelFit {
                determined: Vec::new(),
                model: settings.model,
                start,
                model_error,
                input_error,
                pull,
                structure,
                renders: images,
                hidden_shares,
                exposures,
                uncertainty,
                cost: last.cost,
                reduced_chi2,
                fitted,
                pixels,
                hidden_pixels: observed.iter().map(|o| o.hidden).sum(),
                median_z,
                pixel_pitch: scenes[0].median_pixel_pitch(),
                view_px: data[0].target.view.width.min(data[0].target.view.height),
                converged: outcome.converged,
                settled,
                cut,
                stop: outcome.stop,
                iterations,
                evaluations,
                by_sums,
                sum_evaluations,
                transforms,
                paths,
                free_gain: data.iter().any(|d| d.gain == Gain::Free),
                parameters,
            };
            fit.determined = identifiability::determined(data, &fit);
            return Ok(fit);
        }
        if !served || scouting {
            scouting &= !served && round < MOST_SCOUTING_ROUNDS;
            renders = Renders::new(data, &observed, &parameters, &settings.for_search(scouting))?;
        }
    }
}

/// Each scene's share of hidden light.
fn hidden_shares<'a>(
    data: &[Datum<'a>],
    parameters: &Parameters,
    settings: &Settings<'a>,
) -> Result<Vec<Option<Image>>> {
    let hides = |d: &Datum| d.target.relief.is_some_and(|relief| relief.hides());
    with_optics(parameters, settings.model, |optics| {
        let share =
            |d: &Datum<'a>| hides(d).then(|| hidden_share(&d.target, optics, settings.backend)).transpose();
        data.iter().map(share).collect()
    })
}
