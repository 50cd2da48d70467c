//! Fitting a medium to observed images: sigma_s, sigma_a and B of one channel from any number of scenes.
//!
//! The residual of a pixel is r = (gain · I(sigma_s, sigma_a, B) + veil - observed) / noise, I being the rendered
//! object light. A free gain or veil enters linearly and is eliminated at every step (variable projection, Golub
//! and Pereyra 1973); the rest is a damped Gauss-Newton iteration in (ln sigma_s, sigma_a, ln B).

mod parameters;
mod residual;
mod solver;
mod start;
mod uncertainty;

pub mod report;

pub use parameters::{Bounds, NAMES, Parameters};
pub use residual::{Datum, Exposure, VeilTerm};
pub use solver::Method;
pub use uncertainty::{Status, Uncertainty};

use crate::error::{Error, Result};
use crate::filter::Optics;
use crate::filter::cpu::CpuFilter;
use crate::medium::Medium;
use crate::phase::Gaussian;
use crate::scene::FitOptions;
use crate::spread::Model;
use residual::{NormalEquations, Observed};
use solver::Outcome;

/// What to fit with.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    /// The spread model.
    pub model: Model,
    /// The optimiser.
    pub method: Method,
    /// Iterations after which a fit is given up.
    pub max_iterations: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { model: Model::SmallAngle, method: Method::LevenbergMarquardt, max_iterations: 60 }
    }
}

/// The fit of one channel.
#[derive(Debug, Clone)]
pub struct ChannelFit {
    /// Where the fit began.
    pub start: [f64; 3],
    /// sigma_s, sigma_a (1/length) and B (rad²) found, with what was free and the bounds.
    pub parameters: Parameters,
    /// Their covariance and what the data leave undetermined.
    pub uncertainty: Uncertainty,
    /// Gain, veil, noise and chi² of each scene.
    pub exposures: Vec<Exposure>,
    /// Half the sum of squared residuals in units of the noise.
    pub cost: f64,
    /// Sum of squared residuals over pixels minus fitted numbers.
    pub reduced_chi2: f64,
    /// Pixels that counted.
    pub pixels: usize,
    /// Median path length over all scenes, length.
    pub median_z: f64,
    /// Whether the optimiser converged.
    pub converged: bool,
    /// Why it stopped.
    pub stop: String,
    /// Iterations of the optimiser.
    pub iterations: u64,
    /// Renders, with and without derivatives.
    pub evaluations: u64,
    /// Real 2-D FFTs of one evaluation with derivatives, over all scenes.
    pub transforms: usize,
}

/// How much wider than at the start the kernels may become before a fit is planned anew.
pub const HEADROOM: f64 = 1.4;
/// Times a fit is planned anew, or the noise estimated anew, at most.
const MOST_ROUNDS: usize = 6;

/// Fits one channel's medium to `data`; all scenes share it.
///
/// # Errors
/// [`Error::NothingToFit`] if no pixel counts or the objects cannot show any blur, [`Error::OutOfRange`] for
/// contradictory options, [`Error::NotFinite`] if a render is not finite.
pub fn fit_channel(data: &[Datum], options: &FitOptions, settings: &Settings) -> Result<ChannelFit> {
    let mut observed = data.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
    let median_z = median_path_length(data);
    let mut parameters = Parameters::new(options, settings.model, median_z)?;
    let mut evaluations =
        start::choose(&mut parameters, options, data, &mut observed, settings.model, median_z)?;
    let start = parameters.values();
    let unknown_noise = data.iter().any(|d| d.noise.is_none());
    let mut iterations = 0;
    for round in 1.. {
        let filters = plan(data, &parameters, settings.model)?;
        let problem = Problem {
            filters: &filters,
            observed: &observed,
            parameters: &parameters,
            model: settings.model,
        };
        let outcome = solver::run(problem, settings.method, settings.max_iterations)?;
        let Outcome { point, equations, converged, stop, .. } = outcome;
        iterations += outcome.iterations;
        evaluations += outcome.evaluations;
        parameters.set_internal(&point);
        let estimated =
            if unknown_noise { residual::estimate_noise(&mut observed, data, &equations) } else { 0.0 };
        // Only the ratio of the scenes' weights moves the optimum.
        let settled = data.len() == 1 || estimated < 0.02;
        let served = with_optics(&parameters, settings.model, |optics| {
            filters.iter().map(|f| f.serves(optics)).collect::<Result<Vec<_>>>()
        })?;
        if (settled && served.iter().all(|s| *s)) || round == MOST_ROUNDS || !converged {
            let problem = Problem {
                filters: &filters,
                observed: &observed,
                parameters: &parameters,
                model: settings.model,
            };
            let last = if unknown_noise { problem.equations(&point)? } else { equations };
            let fitted = parameters.free_count() + data.iter().map(Datum::free_exposure).sum::<usize>();
            let pixels = observed.iter().map(Observed::pixels).sum::<usize>();
            let uncertainty = Uncertainty::new(&last, &parameters, median_z);
            return Ok(ChannelFit {
                start,
                uncertainty: uncertainty.clone(),
                exposures: last.exposures(&observed, &uncertainty),
                cost: last.cost,
                reduced_chi2: 2.0 * last.cost / pixels.saturating_sub(fitted).max(1) as f64,
                pixels,
                median_z,
                converged,
                stop,
                iterations,
                evaluations,
                transforms: filters.iter().map(|f| f.transforms().1).sum(),
                parameters,
            });
        }
    }
    unreachable!("the last round returns")
}

/// The optimisation problem handed to a solver: parameters in, normal equations out.
pub(crate) struct Problem<'a> {
    filters: &'a [CpuFilter<'a>],
    observed: &'a [Observed<'a>],
    parameters: &'a Parameters,
    model: Model,
}

impl Problem<'_> {
    pub(crate) fn parameters(&self) -> &Parameters {
        self.parameters
    }

    /// Cost, gradient and Gauss-Newton matrix at the internal point `u`.
    pub(crate) fn equations(&self, u: &[f64; 3]) -> Result<NormalEquations> {
        let scale = self.parameters.chain(u);
        let parameters = self.parameters.at(u);
        with_optics(&parameters, self.model, |optics| {
            let mut sum = NormalEquations::default();
            for (filter, observed) in self.filters.iter().zip(self.observed) {
                sum.add(observed.compare(&filter.render_with_gradient(optics)?, scale));
            }
            finite(sum, &parameters)
        })
    }

    /// Cost alone at the internal point `u`.
    pub(crate) fn cost(&self, u: &[f64; 3]) -> Result<f64> {
        let parameters = self.parameters.at(u);
        with_optics(&parameters, self.model, |optics| {
            let mut cost = 0.0;
            for (filter, observed) in self.filters.iter().zip(self.observed) {
                cost += observed.cost(&filter.render(optics)?);
            }
            Ok(cost)
        })
    }
}

fn finite(equations: NormalEquations, parameters: &Parameters) -> Result<NormalEquations> {
    if equations.is_finite() {
        Ok(equations)
    } else {
        let [s, a, b] = parameters.values();
        Err(Error::NotFinite(format!("the cost is not finite at sigma_s = {s}, sigma_a = {a}, b = {b}")))
    }
}

/// Calls `f` with the optics that the parameter values describe.
pub(crate) fn with_optics<T>(
    parameters: &Parameters,
    model: Model,
    f: impl FnOnce(&Optics) -> Result<T>,
) -> Result<T> {
    let [sigma_s, sigma_a, b] = parameters.values();
    let phase = Gaussian::new(b)?;
    f(&Optics { model, medium: Medium::new(sigma_s, sigma_a)?, phase: &phase })
}

fn plan<'a>(data: &[Datum<'a>], parameters: &Parameters, model: Model) -> Result<Vec<CpuFilter<'a>>> {
    with_optics(parameters, model, |optics| {
        data.iter().map(|d| CpuFilter::new(d.target, optics, HEADROOM)).collect()
    })
}

fn median_path_length(data: &[Datum]) -> f64 {
    let mut all: Vec<f64> = data.iter().flat_map(|d| d.target.geometry.sorted_path_lengths()).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}
