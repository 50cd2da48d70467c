//! The optimisers, as argmin solvers: Levenberg-Marquardt within bounds (argmin has none) and argmin's Nelder-Mead.
//! The only file that mentions argmin.

use super::bounded_step::least_within;
use super::equations::NormalEquations;
use super::problem::Problem;
use crate::error::{Error, Result};
use crate::fit::Method;
use crate::fit::parameters::{Bounds, Parameter};
use crate::forward::Quantity;
use argmin::core::{
    CostFunction, Executor, IterState, KV, Operator, Problem as Counted, Solver, State, TerminationReason,
    TerminationStatus,
};
use argmin::solver::neldermead::NelderMead;
use nalgebra::DVector;

/// Where an optimiser stopped.
pub(crate) struct Outcome {
    pub point: DVector<f64>,
    pub equations: NormalEquations,
    pub converged: bool,
    pub stop: String,
    pub iterations: u64,
    pub evaluations: u64,
}

/// Minimises `problem` from its parameters' values, in at most `max_iterations`.
pub(crate) fn run(problem: Problem, method: Method, max_iterations: u64) -> Result<Outcome> {
    match method {
        Method::LevenbergMarquardt => run_levenberg_marquardt(problem, max_iterations),
        Method::NelderMead => run_nelder_mead(problem, max_iterations),
    }
}

/// The library's own error out of argmin's.
fn ours(error: argmin::core::Error) -> Error {
    error.downcast::<Error>().unwrap_or_else(|other| Error::NotFinite(other.to_string()))
}

impl Operator for Problem<'_> {
    type Param = DVector<f64>;
    type Output = NormalEquations;

    fn apply(&self, u: &DVector<f64>) -> std::result::Result<NormalEquations, argmin::core::Error> {
        Ok(self.equations(u)?)
    }
}

/// Damping at the start, relative to the matrix' diagonal, and beyond which no step can help.
const FIRST_DAMPING: f64 = 1e-3;
const LAST_DAMPING: f64 = 1e12;
/// Least curvature for damping, relative to the diagonal before the linear terms were eliminated.
const LEAST_CURVATURE: f64 = 1e-9;

/// Levenberg-Marquardt on normal equations, within bounds.
struct LevenbergMarquardt {
    bounds: Vec<Bounds>,
    longest_steps: DVector<f64>,
    held: Vec<bool>,
    damping: f64,
    current: NormalEquations,
    status: TerminationStatus,
}

type Iteration = IterState<DVector<f64>, (), (), (), (), f64>;

impl LevenbergMarquardt {
    fn new(problem: &Problem) -> Self {
        let parameters = problem.parameters();
        Self {
            bounds: problem.bounds(),
            longest_steps: parameters.vector(|p| p.descriptor().longest_step),
            held: parameters.iter().map(|(_, p)| !p.is_free()).collect(),
            damping: FIRST_DAMPING,
            current: NormalEquations::empty(parameters.count()),
            status: TerminationStatus::NotTerminated,
        }
    }

    /// The step from `u` to the least value of the damped quadratic model within the bounds.
    fn step(&self, u: &DVector<f64>) -> DVector<f64> {
        let NormalEquations { gradient, matrix, diagonal, .. } = &self.current;
        let mut damped = matrix.clone();
        for i in 0..u.len() {
            damped[(i, i)] += self.damping * matrix[(i, i)].max(LEAST_CURVATURE * diagonal[i]);
        }
        let room = |i: usize| {
            // A held sigma_s may be 0, whose logarithm no step must touch.
            let still = self.held[i] || diagonal[i] == 0.0;
            if still { [0.0; 2] } else { self.bounds[i].map(|bound| bound - u[i]) }
        };
        let bounds: Vec<Bounds> = (0..u.len()).map(room).collect();
        let step = least_within(&bounds, gradient, &damped);
        let excess = step.component_div(&self.longest_steps).amax();
        if excess > 1.0 { step / excess } else { step }
    }

    fn stop(&mut self, reason: TerminationReason) {
        self.status = TerminationStatus::Terminated(reason);
    }
}

impl<'a> Solver<Problem<'a>, Iteration> for LevenbergMarquardt {
    fn name(&self) -> &str {
        "Levenberg-Marquardt"
    }

    fn init(
        &mut self,
        problem: &mut Counted<Problem<'a>>,
        state: Iteration,
    ) -> std::result::Result<(Iteration, Option<KV>), argmin::core::Error> {
        let u = state.get_param().expect("the executor is given a start").clone();
        self.current = problem.apply(&u)?;
        let cost = self.current.cost;
        Ok((state.cost(cost), None))
    }

    fn next_iter(
        &mut self,
        problem: &mut Counted<Problem<'a>>,
        state: Iteration,
    ) -> std::result::Result<(Iteration, Option<KV>), argmin::core::Error> {
        let u = state.get_param().expect("set at the start").clone();
        while self.damping < LAST_DAMPING {
            let step = self.step(&u);
            let predicted =
                -self.current.gradient.dot(&step) - 0.5 * (&self.current.matrix * &step).dot(&step);
            if predicted <= self.current.negligible() {
                self.stop(TerminationReason::SolverConverged);
                break;
            }
            let trial = &u + step;
            let equations = problem.apply(&trial)?;
            let ratio = (self.current.cost - equations.cost) / predicted;
            if ratio > 0.0 {
                // Nielsen's rule: the better the quadratic model, the less damping.
                self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(0.1, 2.0);
                self.current = equations;
                return Ok((state.param(trial).cost(self.current.cost), None));
            }
            self.damping *= 8.0;
        }
        if self.damping >= LAST_DAMPING {
            self.stop(TerminationReason::SolverExit("no step lowers the cost".into()));
        }
        Ok((state, None))
    }

    fn terminate(&mut self, _state: &Iteration) -> TerminationStatus {
        self.status.clone()
    }
}

fn run_levenberg_marquardt(problem: Problem, max_iterations: u64) -> Result<Outcome> {
    let solver = LevenbergMarquardt::new(&problem);
    let start = problem.parameters().point();
    let run = Executor::new(problem, solver)
        .configure(|state| state.param(start).max_iters(max_iterations))
        .timer(false)
        .run()
        .map_err(ours)?;
    let reason = run.state.get_termination_reason();
    Ok(Outcome {
        point: run.state.get_param().expect("a run ends with a point").clone(),
        converged: reason == Some(&TerminationReason::SolverConverged),
        stop: reason.map_or_else(|| "unknown".into(), |r| r.text().to_string()),
        iterations: run.state.get_iter(),
        evaluations: run.problem.counts.get("operator_count").copied().unwrap_or(0),
        equations: run.solver.current,
    })
}

/// The cost over the free coordinates, for the simplex; beyond a bound it grows with the distance.
struct Simplex<'a> {
    problem: Problem<'a>,
    start: DVector<f64>,
    bounds: Vec<Bounds>,
    free: Vec<usize>,
}

impl<'a> Simplex<'a> {
    fn new(problem: Problem<'a>) -> Self {
        let parameters = problem.parameters();
        let free = parameters.iter().filter(|(_, p)| p.is_free()).map(|(id, _)| id.row()).collect();
        Self { start: parameters.point(), bounds: problem.bounds(), free, problem }
    }

    /// The free coordinates of the start, and of a corner of the simplex along each of them.
    fn corners(&self) -> Vec<Vec<f64>> {
        let first: Vec<f64> = self.free.iter().map(|&i| self.start[i]).collect();
        let edges: Vec<f64> = self.problem.parameters().iter().map(|(_, p)| self.edge(p)).collect();
        let corner = |(n, &i): (usize, &usize)| {
            let mut corner = first.clone();
            let inward = if corner[n] + edges[i] > self.bounds[i][1] { -1.0 } else { 1.0 };
            corner[n] += inward * edges[i];
            corner
        };
        std::iter::once(first.clone()).chain(self.free.iter().enumerate().map(corner)).collect()
    }

    /// A quarter of a logarithm and of a pixel; of sigma_a a quarter of sigma_t, the natural scale at hand.
    fn edge(&self, parameter: &Parameter) -> f64 {
        if parameter.descriptor().quantity != Quantity::SigmaA {
            return 0.25;
        }
        let sigma_t = self.problem.parameters().value(Quantity::SigmaS) + parameter.value();
        0.25 * sigma_t.max(1e-3 * parameter.bounds()[1])
    }

    fn place(&self, free: &[f64]) -> (DVector<f64>, f64) {
        let (mut u, mut outside) = (self.start.clone(), 0.0);
        for (&i, &v) in self.free.iter().zip(free) {
            let [low, high] = self.bounds[i];
            u[i] = v.clamp(low, high);
            outside += (v - u[i]).abs() / (high - low);
        }
        (u, outside)
    }
}

impl CostFunction for Simplex<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, free: &Vec<f64>) -> std::result::Result<f64, argmin::core::Error> {
        let (u, outside) = self.place(free);
        Ok(self.problem.cost(&u)? * (1.0 + outside))
    }
}

/// Spread of the simplex' costs, relative to the cost at the start, at which it has converged.
const SIMPLEX_CONVERGED: f64 = 1e-10;
/// Iterations of the simplex for each that Levenberg-Marquardt would be given.
const SIMPLEX_ITERATIONS: u64 = 10;

fn run_nelder_mead(problem: Problem, max_iterations: u64) -> Result<Outcome> {
    let simplex = Simplex::new(problem);
    let corners = simplex.corners();
    let tolerance = SIMPLEX_CONVERGED * simplex.cost(&corners[0]).map_err(ours)?;
    let solver =
        NelderMead::new(corners).with_sd_tolerance(tolerance.max(f64::MIN_POSITIVE)).map_err(ours)?;
    let mut run = Executor::new(simplex, solver)
        .configure(|state| state.max_iters(SIMPLEX_ITERATIONS * max_iterations))
        .timer(false)
        .run()
        .map_err(ours)?;
    let reason = run.state.get_termination_reason().cloned();
    let best = run.state.get_best_param().expect("a run ends with a point").clone();
    let evaluations = run.problem.counts.get("cost_count").copied().unwrap_or(0);
    let simplex = run.problem.take_problem().expect("the executor hands the problem back");
    let (point, _) = simplex.place(&best);
    Ok(Outcome {
        equations: simplex.problem.equations(&point)?,
        point,
        converged: reason == Some(TerminationReason::SolverConverged),
        stop: reason.map_or_else(|| "unknown".into(), |r| r.text().to_string()),
        iterations: run.state.get_iter(),
        evaluations: evaluations + 1,
    })
}
