//! No more model than a scene needs: from the cheapest candidate on, the first that suffices.
//!
//! A model suffices if its fit converged and determines what is free, and if its predicted error
//! ([`ModelError`](super::ModelError)) stays under the tolerance or under half the standard error, and in the image under
//! the noise of a pixel. If the residual alone speaks against it, BIC decides between it and the next: a misfit that the
//! next model does not mend is none of the model's.

mod camera;
mod candidate;
mod escalation;
mod judgement;
mod prospect;

pub use camera::free_camera;
pub use escalation::{filter_is_weak, leave_out_tracing, trace_instead, tracing_seconds};
pub(super) use prospect::{Planned, PlannedExposure, Prospect, seen};

use super::Settings;
use super::report::Candidate;
use super::scenes::{SceneFit, fit_scenes, observations, reliefs};
use crate::error::Result;
use crate::filter::Filter;
use crate::relief::Relief;
use crate::scene::ObservedScene;
use crate::spread::Model;
use judgement::{Judgement, of_fit, of_prospect};
use std::time::Instant;

/// The models that are tried, cheapest first; the last is the reference of all errors.
pub const SEQUENCE: [Model; 6] = [
    Model::BeerLambert,
    Model::SingleScatter,
    Model::Gaussian,
    Model::NarrowBeam,
    Model::SmallAngle,
    Model::WideAngle,
];

/// BIC by which the next model must be better for a misfit to be the model's: very strong evidence (Kass and Raftery 1995).
const EVIDENCE: f64 = 10.0;
/// How much worse than allowed the error of a model may look from the pilot's medium for the model to be fitted in spite of that:
/// the pilot may be off, and the prediction is of first order.
const BENEFIT: f64 = 2.0;
/// The model whose fit says where the others are looked at first.
const PILOT: Model = Model::SmallAngle;

/// Fits `scenes` with one model after the other, `settings.model` aside, until one suffices to within the relative error
/// `tolerance`, and returns that fit with all candidates in its report. Cheap models are fitted only if they look good enough
/// at the medium that small-angle theory finds. If no model suffices, the one taken is the cheapest whose only fault is that
/// the data leave something undetermined, or else the last.
///
/// # Errors
/// As [`fit_scenes`].
pub fn select(
    scenes: &[ObservedScene],
    settings: &Settings,
    filter: Filter,
    tolerance: f64,
    progress: &dyn Fn(),
) -> Result<SceneFit> {
    let fit = |model| fit_scenes(scenes, &Settings { model, ..*settings }, filter, progress);
    let reliefs = reliefs(scenes, filter);
    let mut pilot = Some(fit(PILOT)?);
    let mut tried = Tried::default();
    for model in SEQUENCE {
        if let Some(pilot) = pilot.as_ref().filter(|_| model != PILOT) {
            let clock = Instant::now();
            let pilot = Pilot { fit: pilot, scenes, reliefs: &reliefs, progress };
            if let Some(why) = pilot.speaks_against(&Settings { model, ..*settings }, BENEFIT * tolerance)? {
                tried.add_unfitted(model, why, clock.elapsed().as_secs_f64());
                continue;
            }
        }
        let fitted = match pilot.take_if(|_| model == PILOT) {
            Some(pilot) => Ok(pilot),
            None => fit(model),
        };
        match fitted {
            Ok(fit) => tried.add(model, fit, tolerance),
            Err(error) if error.is_about_model() => tried.add_unfitted(model, error.to_string(), 0.0),
            Err(error) => return Err(error),
        }
        if tried.taken.is_some() {
            break;
        }
    }
    Ok(tried.into_fit())
}

/// The models that were tried so far.
#[derive(Default)]
struct Tried {
    candidates: Vec<Candidate>,
    fits: Vec<Option<SceneFit>>,
    /// The one that suffices.
    taken: Option<usize>,
    /// The first whose only fault is that the data leave something undetermined.
    undetermined: Option<usize>,
    /// The last one, if its only fault is a misfit.
    misfit: Option<usize>,
}

impl Tried {
    fn add_unfitted(&mut self, model: Model, why: String, seconds: f64) {
        self.candidates.push(Candidate::unfitted(model, why, seconds));
        self.fits.push(None);
    }

    fn add(&mut self, model: Model, fit: SceneFit, tolerance: f64) {
        let i = self.candidates.len();
        let mut candidate = Candidate::new(model, &fit);
        let bic = |candidate: &Candidate| candidate.bic.unwrap_or(f64::INFINITY);
        if let Some(before) = self.misfit.take()
            && bic(&self.candidates[before]) - bic(&candidate) < EVIDENCE
        {
            self.taken = Some(before);
        }
        match of_fit(&fit, model, tolerance) {
            Judgement::Suffices => self.taken = self.taken.or(Some(i)),
            Judgement::Misfit(why) => (self.misfit, candidate.shortcoming) = (Some(i), Some(why)),
            Judgement::Undetermined(why) => {
                (self.undetermined, candidate.shortcoming) = (self.undetermined.or(Some(i)), Some(why));
            }
            Judgement::Fails(why) => candidate.shortcoming = Some(why),
        }
        self.candidates.push(candidate);
        self.fits.push(Some(fit));
    }

    /// The fit of the model that is taken, with all candidates in its report.
    fn into_fit(mut self) -> SceneFit {
        let last = self.fits.iter().rposition(Option::is_some).expect("the pilot was fitted");
        let taken = self.taken.or(self.undetermined).unwrap_or(last);
        self.candidates[taken].taken = true;
        let mut fit = self.fits.swap_remove(taken).expect("what is taken was fitted");
        fit.report.candidates = self.candidates;
        fit
    }
}

/// A fit from whose medium other models are looked at.
struct Pilot<'x> {
    fit: &'x SceneFit,
    scenes: &'x [ObservedScene],
    reliefs: &'x [Option<Relief>],
    progress: &'x dyn Fn(),
}

impl Pilot<'_> {
    /// Why `settings.model` need not be fitted, seen from here; `None` if it should be.
    fn speaks_against(&self, settings: &Settings, tolerance: f64) -> Result<Option<String>> {
        for (i, (_, fit)) in self.fit.channels.iter().enumerate() {
            let observations = observations(self.scenes, self.reliefs, i);
            let options = &self.scenes[0].scene.fit[i];
            let prospect = Prospect::from_pilot(&observations, options, settings, fit, self.progress)?;
            let Some(prospect) = prospect else { continue };
            if let Judgement::Fails(why) = of_prospect(&prospect, settings.model, tolerance) {
                return Ok(Some(format!("{why}, seen from {PILOT}")));
            }
        }
        Ok(None)
    }
}
