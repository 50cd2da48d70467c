//! Fitting a medium to observed images: sigma_s, sigma_a and B or g of one channel from any number of scenes.
//!
//! The residual of a pixel is r = (gain · I(sigma_s, sigma_a, B) + veil - observed) / noise, I being the rendered
//! object light, and noise one number a scene or the root of each pixel's variance. A free gain or veil enters linearly and
//! is eliminated at every step (variable projection, Golub and Pereyra 1973); the rest is a damped Gauss-Newton iteration in
//! (ln sigma_s, sigma_a, ln B), or ln(1 - g) in place of ln B for Henyey-Greenstein's phase function.

mod advice;
mod comparison;
mod datum;
mod displacement;
mod equations;
mod exposure;
mod identifiability;
mod input_error;
mod intervals;
mod model_error;
mod observed;
mod parameters;
mod renders;
mod search;
mod solver;
mod start;
mod structure;
mod sums;
mod uncertainty;

pub mod forecast;
pub mod ladder;
pub mod noise;
pub mod report;
pub mod scenes;

pub use advice::{Advice, advise};
pub use datum::{Datum, NoiseTerm, VeilTerm};
pub use exposure::Exposure;
pub use identifiability::Combination;
pub use input_error::InputError;
pub use intervals::{Intervals, bootstrap, profile};
pub use model_error::ModelError;
pub use parameters::{Bounds, NAMES, Parameters, PathLengths, names};

pub use solver::Method;
pub use uncertainty::{Status, Uncertainty};

use crate::error::{Error, Result};
use crate::filter::{Backend, Coverage, Optics, hidden_share};
use crate::geometry::Geometry;
use crate::image::Image;
use crate::medium::Medium;
use crate::relief::Relief;
use crate::scene::{FitOptions, Gain};
use crate::spread::Model;
use displacement::Displacement;
use equations::{NormalEquations, Products};
use exposure::exposures;
use nalgebra::Vector3;
use observed::Observed;
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
    /// Called after every render.
    pub progress: &'a dyn Fn(),
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self {
            model: Model::SmallAngle,
            backend: Backend::Cpu,
            method: Method::LevenbergMarquardt,
            max_iterations: 200,
            sums: true,
            progress: &|| (),
        }
    }
}

/// The fit of one channel.
#[derive(Debug, Clone)]
pub struct ChannelFit {
    /// The spread model.
    pub model: Model,
    /// Where the fit began.
    pub start: [f64; 3],
    /// sigma_s, sigma_a (1/length) and the shape of the phase function, B (rad²) or g, found, with what was free and the bounds.
    pub parameters: Parameters,
    /// Their covariance and what the data leave undetermined.
    pub uncertainty: Uncertainty,
    /// What the model's own error does to them; `None` where it is not known.
    pub model_error: Option<ModelError>,
    /// What errors of the input do to them.
    pub input_error: InputError,
    /// How far the data would move the coordinates on from the optimum, were there no bounds: a Gauss-Newton step.
    pub pull: Vector3<f64>,
    /// By how many standard deviations blocks of residuals exceed what noise leaves in them.
    pub structure: f64,
    /// Gain, veil, noise and chi² of each scene.
    pub exposures: Vec<Exposure>,
    /// Half the sum of squared residuals in units of the noise.
    pub cost: f64,
    /// Sum of squared residuals over pixels minus fitted numbers.
    pub reduced_chi2: f64,
    /// Numbers that were fitted: free parameters, gains and veils.
    pub fitted: usize,
    /// Pixels that counted.
    pub pixels: usize,
    /// Pixels left out because of hidden light.
    pub hidden_pixels: usize,
    /// Median path length over all scenes, length.
    pub median_z: f64,
    /// Median length of a pixel at the object of the first scene.
    pub pixel_pitch: f64,
    /// Shorter side of the first scene's view, px.
    pub view_px: usize,
    /// Whether the optimiser converged.
    pub converged: bool,
    /// Whether the noise of the scenes, the planning of the renders and the pixels left out settled.
    pub settled: bool,
    /// Whether the kernels reach beyond the padding, [`Coverage::cut`](crate::filter::Coverage).
    pub cut: bool,
    /// Why it stopped.
    pub stop: String,
    /// Iterations of the optimiser.
    pub iterations: u64,
    /// Renders, with and without derivatives.
    pub evaluations: u64,
    /// sigma_s, sigma_a and the shape as sums over the image had them, before renders confirmed them; `None` if renders alone found
    /// the optimum.
    pub by_sums: Option<[f64; 3]>,
    /// Evaluations by sums.
    pub sum_evaluations: u64,
    /// Real 2-D FFTs of one evaluation with derivatives, over all scenes.
    pub transforms: usize,
    /// Whether some scene's gain was free.
    pub free_gain: bool,
    /// Each scene's best fit, gain · object light + veil, over its view: to compare with the observation.
    pub renders: Vec<Image>,
    /// Share of hidden light of each scene's pixels at the best fit; `None` for a scene in which nothing is hidden.
    pub hidden_shares: Vec<Option<Image>>,
    /// What the data determine where they leave a parameter open, or hold two only together.
    pub determined: Vec<Combination>,
}

impl ChannelFit {
    /// Akaike's information criterion, chi² + 2 k with k fitted numbers (Akaike 1974): the log-likelihood of a normal noise
    /// that is known, or held at its estimate.
    pub fn aic(&self) -> f64 {
        2.0 * self.cost + 2.0 * self.fitted as f64
    }

    /// Variance of the linear function `gradient`·u of the coordinates by noise and by errors of the input; `None` if the
    /// data do not decide it.
    pub fn variance_of(&self, gradient: &Vector3<f64>) -> Option<f64> {
        Some(self.uncertainty.variance_of(gradient)? + self.input_error.variance_of(gradient))
    }

    /// Bayesian information criterion, chi² + k ln n over n pixels (Schwarz 1978).
    pub fn bic(&self) -> f64 {
        2.0 * self.cost + self.fitted as f64 * (self.pixels as f64).ln()
    }
}

/// How much wider than at the start the kernels may become before a fit is planned anew.
pub const HEADROOM: f64 = 1.4;
/// Reduced chi² above which a fit is said not to describe the image: half as much misfit as noise.
const MISFIT: f64 = 1.5;
/// Relative change of the estimated noise below which the scenes' weights are settled.
const NOISE_SETTLED: f64 = 0.02;
/// Times a fit is planned anew, or the noise estimated anew, at most.
const MOST_ROUNDS: usize = 6;

/// Fits one channel's medium to `data`; all scenes share it.
///
/// If the fit from the automatic start does not describe the images or ends on a bound, it may have ended in a false
/// minimum: kernels of other widths are then tried as starts too, and the best of all fits counts; by sums they always are.
/// Edges and slopes explain a misfit in another way, so scenes that have some are not tried again.
///
/// # Errors
/// [`Error::NothingToFit`] if no pixel counts or every parameter is fixed, [`Error::OutOfRange`] for contradictory
/// options, [`Error::NotFinite`] if a render is not finite, those of [`Model::range`].
pub fn fit_channel(data: &[Datum], options: &FitOptions, settings: &Settings) -> Result<ChannelFit> {
    let observed = data.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
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
    let mut renders = Renders::new(data, &observed, &parameters, settings)?;
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
        let outcome = solver::run(problem, settings)?;
        iterations += outcome.iterations;
        evaluations += outcome.evaluations;
        parameters.set_internal(&outcome.point);
        let unsettled = exposures(&outcome.equations, &observed, None);
        let images = renders.exposed(&parameters, settings, &unsettled, data)?;
        // Only the ratio of the scenes' weights moves the optimum, so one scene is settled whatever its noise.
        let mut change: f64 = 0.0;
        for ((o, datum), render) in observed.iter_mut().zip(data).zip(&images) {
            if datum.noise.is_none() {
                let noise = o.fine_noise(render);
                change = change.max((noise / o.noise - 1.0).abs());
                o.noise = noise;
            }
        }
        let hidden_shares = hidden_shares(data, &parameters, settings)?;
        let mut uncovered = false;
        for (i, (o, share)) in observed.iter_mut().zip(&hidden_shares).enumerate() {
            if let Some(share) = share
                && round < MOST_ROUNDS
                && o.leave_out_hidden(share)?
            {
                renders.observe(i, o)?;
                uncovered = true;
            }
        }
        let settled = !uncovered && (data.len() == 1 || change < NOISE_SETTLED);
        let Coverage { served, cut } = renders.coverage(&parameters, settings)?;
        let settled = settled && served;
        if settled || round == MOST_ROUNDS || !outcome.converged {
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
            let transforms = renders.transforms();
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
                uncertainty.distrust(|i| error.reference_of(&Vector3::ith(i, 1.0)), median_z);
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
                free_gain: data.iter().any(|d| d.gain == Gain::Free),
                parameters,
            };
            fit.determined = identifiability::determined(data, &fit);
            return Ok(fit);
        }
        if !served {
            renders = Renders::new(data, &observed, &parameters, settings)?;
        }
    }
}

/// What `settings.model` would know, and what its error would be, at the medium of another model's fit `pilot`: one render
/// instead of a fit. `None` where the model has no kernels or nothing to fit.
fn foresee<'a>(
    data: &[Datum<'a>],
    options: &FitOptions,
    settings: &Settings<'a>,
    pilot: &ChannelFit,
) -> Result<Option<(Parameters, Uncertainty, Option<ModelError>)>> {
    let scenes: Vec<&Geometry> = data.iter().map(|d| d.target.geometry).collect();
    let mut parameters = match Parameters::new(options, settings.model, path_lengths(&scenes)) {
        Err(error) if error.is_about_model() => return Ok(None),
        parameters => parameters?,
    };
    parameters.set_internal(&pilot.parameters.internal());
    let mut observed = data.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
    for ((o, exposure), share) in observed.iter_mut().zip(&pilot.exposures).zip(&pilot.hidden_shares) {
        o.noise = exposure.noise;
        if let Some(share) = share {
            o.leave_out_hidden(share)?;
        }
    }
    let mut renders = Renders::new(data, &observed, &parameters, settings)?;
    let problem = Problem::new(Source::Renders(&renders), &observed, &parameters, settings);
    let equations = problem.equations(&parameters.internal())?;
    let uncertainty = Uncertainty::new(&equations, &parameters, pilot.median_z, 1.0);
    let error = ModelError::new(&mut Displacement {
        data,
        observed: &observed,
        renders: &mut renders,
        parameters: &parameters,
        uncertainty: &uncertainty,
        exposures: &pilot.exposures,
        settings,
    })?;
    Ok(Some((parameters, uncertainty, error)))
}

/// What the sums of products of a problem come from.
#[derive(Clone, Copy)]
enum Source<'a> {
    Renders(&'a Renders<'a>),
    Sums(&'a [Sums<'a>]),
}

/// The optimisation problem handed to a solver: parameters in, normal equations out.
pub(crate) struct Problem<'a> {
    source: Source<'a>,
    observed: &'a [Observed<'a>],
    parameters: &'a Parameters,
    settings: &'a Settings<'a>,
}

impl<'a> Problem<'a> {
    fn new(
        source: Source<'a>,
        observed: &'a [Observed<'a>],
        parameters: &'a Parameters,
        settings: &'a Settings<'a>,
    ) -> Self {
        Self { source, observed, parameters, settings }
    }

    pub(crate) fn parameters(&self) -> &Parameters {
        self.parameters
    }

    /// Cost, gradient and Gauss-Newton matrix at the internal point `u`.
    pub(crate) fn equations(&self, u: &[f64; 3]) -> Result<NormalEquations> {
        let parameters = self.parameters.at(u);
        let products = match self.source {
            Source::Renders(renders) => renders.products(&parameters, self.settings, self.observed)?,
            Source::Sums(sums) => with_optics(&parameters, self.settings.model, |optics| {
                sums.iter().map(|s| s.products(optics)).collect()
            })?,
        };
        finite(self.compare(&products, self.parameters.chain(u)), &parameters)
    }

    /// Cost alone at the internal point `u`.
    pub(crate) fn cost(&self, u: &[f64; 3]) -> Result<f64> {
        match self.source {
            Source::Renders(renders) => {
                let products = renders.levels(&self.parameters.at(u), self.settings, self.observed)?;
                Ok(self.compare(&products, [0.0; 3]).cost)
            }
            Source::Sums(_) => Ok(self.equations(u)?.cost),
        }
    }

    fn compare(&self, products: &[Products], chain: [f64; 3]) -> NormalEquations {
        let mut sum = NormalEquations::default();
        for (observed, products) in self.observed.iter().zip(products) {
            sum.add(observed.compare(products, chain));
        }
        sum
    }
}

fn finite(equations: NormalEquations, parameters: &Parameters) -> Result<NormalEquations> {
    if equations.is_finite() {
        Ok(equations)
    } else {
        let place: Vec<String> =
            parameters.names().iter().zip(parameters.values()).map(|(n, v)| format!("{n} = {v}")).collect();
        Err(Error::NotFinite(format!("the cost is not finite at {}", place.join(", "))))
    }
}

/// Calls `f` with the optics that the parameter values describe.
pub(crate) fn with_optics<T>(
    parameters: &Parameters,
    model: Model,
    f: impl FnOnce(&Optics) -> Result<T>,
) -> Result<T> {
    let [sigma_s, sigma_a, shape] = parameters.values();
    let phase = parameters.family().lobe(shape)?;
    f(&Optics { model, medium: Medium::new(sigma_s, sigma_a)?, phase: &phase })
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

/// Path lengths over the pixels of all scenes; a flat scene counts as many times as it has pixels.
///
/// # Panics
/// If no scene shows an object.
pub fn path_lengths(scenes: &[&Geometry]) -> PathLengths {
    let mut weighted: Vec<(f64, usize)> = Vec::new();
    for geometry in scenes {
        let lengths = geometry.path_lengths();
        let weight = if lengths.len() == 1 { geometry.width * geometry.height } else { 1 };
        weighted.extend(lengths.into_iter().map(|z| (z, weight)));
    }
    weighted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = weighted.iter().map(|(_, weight)| weight).sum::<usize>() / 2;
    let mut passed = 0;
    let reached = |&&(_, weight): &&(f64, usize)| {
        passed += weight;
        passed > half
    };
    let median = weighted.iter().find(reached).expect("checked: every scene shows an object").0;
    PathLengths { median, longest: weighted[weighted.len() - 1].0 }
}
