//! The driver of a fit: from a start to an optimum at which everything that depends on it has settled.
//!
//! Noise that is estimated, light that may be hidden, and the plan or the paths of the models all depend on the optimum. So
//! the fit goes in rounds: optimise, look what has changed, prepare the models again if they no longer serve.

use super::begin::Begun;
use super::equations::NormalEquations;
use super::problem::Problem;
use super::scene_models::SceneModels;
use super::solver::{self, Outcome};
use super::task::Task;
use crate::error::Result;
use crate::filter::Coverage;
use crate::fit::observation::{Fitted, Observed, Unseen};
use crate::fit::parameters::Parameters;
use crate::image::Image;

/// Relative change of the estimated noise below which the scenes' weights are settled.
const NOISE_SETTLED: f64 = 0.02;
/// Rounds at most; and of a model whose paths are traced again, since its steps are shorter.
const MOST_ROUNDS: usize = 6;
const MOST_TRACED_ROUNDS: usize = 16;
/// Those of them that make do with few paths, whose noise may keep them from coming to rest.
const MOST_SCOUTING_ROUNDS: usize = 8;
/// What ends a fit whose chi² is not above 0: it is one of two halves' products, and the noise of the paths all that is left
/// of it.
const TOO_FEW: &str = "the noise of the traced paths hides the residual: too few paths";

/// What the models of a round are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// To find the neighbourhood with few paths.
    Scouting,
    /// To find the optimum.
    Fitting,
}

/// Where a fit has ended.
pub(crate) struct Optimum<'a> {
    pub start: Parameters,
    pub parameters: Parameters,
    pub observed: Vec<Observed<'a>>,
    pub models: SceneModels<'a>,
    pub equations: NormalEquations,
    /// Each scene's best fit, gain · object light + veil.
    pub images: Vec<Image>,
    pub unseen: Vec<Unseen>,
    pub converged: bool,
    pub stop: String,
    /// Whether noise, plans and the pixels left out have settled.
    pub settled: bool,
    pub cut: bool,
    pub iterations: u64,
    pub evaluations: u64,
    /// What Gram matrices found in the last round, before renders confirmed it.
    pub by_gram: Option<Parameters>,
    pub gram_evaluations: u64,
}

/// What a round has changed.
struct Settlement {
    images: Vec<Image>,
    unseen: Vec<Unseen>,
    coverage: Coverage,
    settled: bool,
}

/// A fit under way.
pub(crate) struct Driver<'x, 'a> {
    task: &'x Task<'x, 'a>,
    gram: Option<&'x SceneModels<'x>>,
    observed: Vec<Observed<'a>>,
    models: SceneModels<'a>,
    phase: Phase,
    round: usize,
    start: Parameters,
    parameters: Parameters,
    by_gram: Option<Parameters>,
    iterations: u64,
    evaluations: u64,
    gram_evaluations: u64,
}

impl<'x, 'a> Driver<'x, 'a> {
    /// The fit that begins at `begun`.
    pub(crate) fn new(task: &'x Task<'x, 'a>, begun: Begun<'x>) -> Result<Self> {
        let Begun { start, parameters, gram, evaluations, gram_evaluations } = begun;
        let mut observed = task.observations.iter().map(Observed::new).collect::<Result<Vec<_>>>()?;
        let engine = task.settings.engine();
        let phase = if engine.scouting().is_some() { Phase::Scouting } else { Phase::Fitting };
        let first = engine.scouting().unwrap_or(engine);
        for observed in &mut observed {
            let gain = observed.pixels().reference.gain;
            observed.weigh(&Fitted {
                model: engine.model,
                medium: parameters.medium()?,
                gain,
                image: None,
            })?;
        }
        let models = SceneModels::prepare(task.observations, &observed, &parameters, &first)?;
        Ok(Self {
            task,
            gram,
            observed,
            models,
            phase,
            round: 0,
            start,
            parameters,
            by_gram: None,
            iterations: 0,
            evaluations,
            gram_evaluations,
        })
    }

    /// Goes round until everything has settled, or it is given up.
    pub(crate) fn run(mut self) -> Result<Optimum<'a>> {
        loop {
            self.round += 1;
            self.consult_gram()?;
            let outcome = self.optimise()?;
            if self.phase == Phase::Scouting && !outcome.converged {
                self.prepare(Phase::Fitting)?;
                continue;
            }
            self.parameters.set_point(&outcome.point);
            let settlement = self.settle(&outcome.equations)?;
            if settlement.settled || self.round == self.most_rounds() || !outcome.converged {
                return self.finish(outcome, settlement);
            }
            let served = settlement.coverage.served;
            if !served || self.phase == Phase::Scouting {
                let scouting = self.phase == Phase::Scouting && !served && self.round < MOST_SCOUTING_ROUNDS;
                self.prepare(if scouting { Phase::Scouting } else { Phase::Fitting })?;
            }
        }
    }

    fn most_rounds(&self) -> usize {
        if self.task.settings.engine().scouting().is_some() { MOST_TRACED_ROUNDS } else { MOST_ROUNDS }
    }

    /// Makes the models again, for where the parameters are now.
    fn prepare(&mut self, phase: Phase) -> Result<()> {
        let engine = self.task.settings.engine();
        let engine = match phase {
            Phase::Scouting => engine.scouting().unwrap_or(engine),
            Phase::Fitting => engine,
        };
        self.phase = phase;
        self.models =
            SceneModels::prepare(self.task.observations, &self.observed, &self.parameters, &engine)?;
        Ok(())
    }

    /// Takes the medium from the Gram matrices, if there are any. What they see is registered as it was at first, so a fit
    /// that registers listens to them once.
    fn consult_gram(&mut self) -> Result<()> {
        let once = self.task.has_nuisances() || self.observed.iter().any(Observed::weights_are_fitted);
        let Some(gram) = self.gram.filter(|_| self.round == 1 || !once) else {
            return Ok(());
        };
        let medium = self.parameters.medium_alone();
        let registered = self.task.weighted_as(&self.observed);
        let problem = Problem::new(gram, &registered, &medium, &|| ());
        let found = solver::run(problem, self.task.settings.method, self.task.settings.max_iterations)?;
        self.gram_evaluations += found.evaluations;
        self.parameters.take(&medium.at(&found.point));
        self.by_gram = Some(self.parameters.clone());
        Ok(())
    }

    fn optimise(&mut self) -> Result<Outcome> {
        let Self { models, observed, parameters, task, .. } = self;
        let problem = Problem::new(models, observed, parameters, task.progress);
        let mut outcome = solver::run(problem, task.settings.method, task.settings.max_iterations)?;
        self.iterations += outcome.iterations;
        self.evaluations += outcome.evaluations;
        if self.models.batches().is_some() && outcome.equations.cost <= 0.0 {
            (outcome.converged, outcome.stop) = (false, TOO_FEW.into());
        }
        Ok(outcome)
    }

    /// Estimates again what depends on the optimum, whose `equations` these are.
    fn settle(&mut self, equations: &NormalEquations) -> Result<Settlement> {
        let images = self.exposed(equations, self.models.images(&self.parameters)?);
        let change = self.estimate_noise(equations, &images)?;
        let reweighed = self.weigh(equations, &images)? > NOISE_SETTLED;
        let unseen = self.task.unseen(&self.parameters)?;
        let uncovered = self.leave_out(&unseen)?;
        let coverage = self.models.coverage(&self.parameters)?;
        // Only the ratio of the scenes' weights moves the optimum, so one scene is settled whatever its noise.
        let weighed = self.observed.len() == 1 || change < NOISE_SETTLED;
        let settled = !uncovered && !reweighed && weighed && coverage.served && self.phase == Phase::Fitting;
        Ok(Settlement { images, unseen, coverage, settled })
    }

    /// `images` of all scenes as they were observed.
    fn exposed(&self, equations: &NormalEquations, images: Vec<Image>) -> Vec<Image> {
        let scenes = images.into_iter().zip(&equations.scenes).zip(&self.observed);
        scenes.map(|((image, e), o)| o.observation.exposed(image, e.linear.exposure)).collect()
    }

    /// Estimates the noise of the scenes of which it is not known; returns its largest relative change.
    fn estimate_noise(&mut self, equations: &NormalEquations, images: &[Image]) -> Result<f64> {
        let mut change: f64 = 0.0;
        for (scene, (model, image)) in self.models.iter().zip(images).enumerate() {
            let observed = &mut self.observed[scene];
            if observed.observation.noise.is_some() || observed.weights_are_fitted() {
                continue;
            }
            let noise = match model.noise() {
                None => observed.fine_noise([image; 2]),
                Some(noise) => {
                    let exposure = equations.scenes[scene].linear.exposure;
                    let halves = noise.halves(&self.parameters.state(scene)?)?;
                    let halves = halves.map(|half| observed.observation.exposed(half, exposure));
                    observed.fine_noise(halves.each_ref())
                }
            };
            change = change.max((noise / observed.noise - 1.0).abs());
            observed.noise = noise;
        }
        Ok(change)
    }

    /// Weighs pixels anew whose noise depends on what is fitted; returns the largest relative change of a pixel's noise.
    fn weigh(&mut self, equations: &NormalEquations, images: &[Image]) -> Result<f64> {
        let mut change: f64 = 0.0;
        if self.round == self.most_rounds() {
            return Ok(change);
        }
        for (scene, image) in images.iter().enumerate() {
            let gain = equations.scenes[scene].linear.exposure.gain;
            let medium = self.parameters.state(scene)?.medium;
            let fitted = Fitted { model: self.models.model(), medium, gain, image: Some(image) };
            let observed = &mut self.observed[scene];
            change = change.max(observed.weigh(&fitted)?);
            if observed.weights_are_fitted() {
                self.models.observe(scene, observed)?;
            }
        }
        Ok(change)
    }

    /// Leaves out what sees too much that no image shows; returns whether that has changed.
    fn leave_out(&mut self, unseen: &[Unseen]) -> Result<bool> {
        let mut changed = false;
        if self.round == self.most_rounds() {
            return Ok(changed);
        }
        for (scene, unseen) in unseen.iter().enumerate() {
            if self.observed[scene].leave_out(unseen)? {
                self.models.observe(scene, &self.observed[scene])?;
                changed = true;
            }
        }
        Ok(changed)
    }

    fn finish(self, outcome: Outcome, settlement: Settlement) -> Result<Optimum<'a>> {
        let equations =
            if self.task.estimates_noise() || self.observed.iter().any(|o| o.object_noise.is_some()) {
                let Self { models, observed, parameters, task, .. } = &self;
                Problem::new(models, observed, parameters, task.progress).equations(&outcome.point)?
            } else {
                outcome.equations
            };
        let Settlement { images, unseen, coverage, settled } = settlement;
        Ok(Optimum {
            start: self.start,
            parameters: self.parameters,
            observed: self.observed,
            models: self.models,
            equations,
            images,
            unseen,
            converged: outcome.converged,
            stop: outcome.stop,
            settled,
            cut: coverage.cut,
            iterations: self.iterations,
            evaluations: self.evaluations,
            by_gram: self.by_gram,
            gram_evaluations: self.gram_evaluations,
        })
    }
}
