//! No more model than a scene needs: from the cheapest model up, the first that suffices.
//!
//! A model suffices if its fit converged and determines what is free, and if its predicted error
//! ([`ModelError`]) stays under the tolerance or under half the standard error, and in the image under
//! the noise of a pixel. If the residual alone speaks against it, BIC decides between it and the next: a misfit that the
//! next model does not mend is none of the model's.

use super::scenes::{SceneFit, data, fit_scenes, reliefs};
use super::uncertainty::Status;
use super::{ChannelFit, ModelError, Parameters, Settings, Uncertainty, foresee};
use crate::error::Result;
use crate::filter::Filter;
use crate::phase::Family;
use crate::relief::Relief;
use crate::scene::ObservedScene;
use crate::spread::Model;
use nalgebra::Vector3;
use serde::Serialize;
use std::time::Instant;

/// The models that are tried, cheapest first; the last is the reference of all errors.
pub const RUNGS: [Model; 6] = [
    Model::BeerLambert,
    Model::SingleScatter,
    Model::Gaussian,
    Model::NarrowBeam,
    Model::SmallAngle,
    Model::WideAngle,
];

/// Standard deviations of chi² by which a residual exceeds its expectation before it counts as structure.
const STRUCTURE: f64 = 5.0;
/// BIC by which the next model must be better for a misfit to be the model's: very strong evidence (Kass and Raftery 1995).
const EVIDENCE: f64 = 10.0;

/// One model that was tried.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rung {
    /// Its name.
    pub model: &'static str,
    /// sigma_s, sigma_a and b or g of each channel, as far as determined; empty if the model was not fitted.
    pub estimates: Vec<[Option<f64>; 3]>,
    /// Root mean square error of a pixel by the model, in units of the noise, of the worst channel; `None` if not known.
    pub image_error: Option<f64>,
    /// Reduced chi² over all channels, of a fit.
    pub reduced_chi2: Option<f64>,
    /// Bayesian information criterion, over all channels, of a fit.
    pub bic: Option<f64>,
    /// Time that it took, seconds.
    pub seconds: f64,
    /// Why it does not suffice; `None` if it does.
    pub shortcoming: Option<String>,
    /// Whether it is the one that was taken.
    pub taken: bool,
}

/// What speaks against a model.
enum Verdict {
    Suffices,
    /// Only that the residual holds more than noise.
    Misfit(String),
    /// Only that the data do not determine everything.
    Undetermined(String),
    Fails(String),
}

/// How much worse than allowed the error of a model may look from the pilot's medium for the model to be fitted all the same:
/// the pilot may be off, and the prediction is of first order.
const BENEFIT: f64 = 2.0;
/// The model whose fit says where the others are looked at first.
const PILOT: Model = Model::SmallAngle;

/// Fits `scenes` with one model after the other, `settings.model` aside, until one suffices to within the relative error
/// `tolerance`, and returns that fit with the ladder in its report. Cheap models are fitted only if they look good enough at
/// the medium that small-angle theory finds. If no model suffices, the one taken is the cheapest whose only fault is that the
/// data leave something undetermined, or else the last.
///
/// # Errors
/// As [`fit_scenes`].
pub fn climb(
    scenes: &[ObservedScene],
    settings: &Settings,
    filter: Filter,
    tolerance: f64,
) -> Result<SceneFit> {
    let reliefs = reliefs(scenes, filter);
    let mut pilot = Some(fit_scenes(scenes, &Settings { model: PILOT, ..*settings }, filter)?);
    let mut rungs: Vec<Rung> = Vec::new();
    let mut fits: Vec<Option<SceneFit>> = Vec::new();
    let (mut taken, mut undetermined, mut misfit) = (None, None, None::<usize>);
    for model in RUNGS {
        let settings = Settings { model, ..*settings };
        if let Some(pilot) = pilot.as_ref().filter(|_| model != PILOT) {
            let clock = Instant::now();
            if let Some(why) = foreseen((scenes, &reliefs), &settings, pilot, BENEFIT * tolerance)? {
                rungs.push(Rung::unfitted(model, why, clock.elapsed().as_secs_f64()));
                fits.push(None);
                continue;
            }
        }
        let fit = match pilot.take_if(|_| model == PILOT) {
            Some(pilot) => Ok(pilot),
            None => fit_scenes(scenes, &settings, filter),
        };
        let fit = match fit {
            Ok(fit) => fit,
            Err(error) if error.is_about_model() => {
                rungs.push(Rung::unfitted(model, error.to_string(), 0.0));
                fits.push(None);
                continue;
            }
            Err(error) => return Err(error),
        };
        let i = rungs.len();
        let mut rung = Rung::new(model, &fit);
        let bic = |rung: &Rung| rung.bic.unwrap_or(f64::INFINITY);
        if let Some(before) = misfit.take()
            && bic(&rungs[before]) - bic(&rung) < EVIDENCE
        {
            taken = Some(before);
        }
        match verdict(&fit, model, tolerance) {
            Verdict::Suffices => taken = taken.or(Some(i)),
            Verdict::Misfit(why) => (misfit, rung.shortcoming) = (Some(i), Some(why)),
            Verdict::Undetermined(why) => {
                (undetermined, rung.shortcoming) = (undetermined.or(Some(i)), Some(why));
            }
            Verdict::Fails(why) => rung.shortcoming = Some(why),
        }
        rungs.push(rung);
        fits.push(Some(fit));
        if taken.is_some() {
            break;
        }
    }
    let last = fits.iter().rposition(Option::is_some).expect("the pilot was fitted");
    let taken = taken.or(undetermined).unwrap_or(last);
    rungs[taken].taken = true;
    let mut fit = fits.swap_remove(taken).expect("what is taken was fitted");
    fit.report.ladder = rungs;
    Ok(fit)
}

/// Why `settings.model` need not be fitted, seen from the `pilot`'s medium; `None` if it should be.
fn foreseen(
    (scenes, reliefs): (&[ObservedScene], &[Option<Relief>]),
    settings: &Settings,
    pilot: &SceneFit,
    tolerance: f64,
) -> Result<Option<String>> {
    for (i, (_, fit)) in pilot.channels.iter().enumerate() {
        let data = data(scenes, reliefs, i);
        let Some((parameters, uncertainty, error)) = foresee(&data, &scenes[0].scene.fit[i], settings, fit)?
        else {
            continue;
        };
        let looks = judge((&parameters, &uncertainty, error.as_ref()), settings.model, tolerance);
        if let Verdict::Fails(why) = looks {
            return Ok(Some(format!("{why}, seen from {PILOT}")));
        }
    }
    Ok(None)
}

impl Rung {
    fn new(model: Model, fit: &SceneFit) -> Self {
        let channels = || fit.channels.iter().map(|(_, fit)| fit);
        let estimate = |fit: &ChannelFit| {
            let known = |i: usize| {
                let there =
                    !fit.parameters.is_placeholder(i) && fit.uncertainty.status(i) != Status::Undetermined;
                there.then(|| fit.parameters.values()[i])
            };
            std::array::from_fn(known)
        };
        let errors = channels().map(|fit| fit.model_error.map(|e| e.image));
        Self {
            model: model.name(),
            estimates: channels().map(estimate).collect(),
            image_error: errors.collect::<Option<Vec<f64>>>().map(|e| e.into_iter().fold(0.0, f64::max)),
            reduced_chi2: fit.report.fit["reduced_chi2"].as_f64(),
            bic: Some(channels().map(ChannelFit::bic).sum()),
            seconds: fit.report.fit["seconds"].as_f64().unwrap_or(f64::NAN),
            shortcoming: None,
            taken: false,
        }
    }

    /// Of a model that was not fitted, and why.
    fn unfitted(model: Model, why: String, seconds: f64) -> Self {
        Self {
            model: model.name(),
            estimates: Vec::new(),
            image_error: None,
            reduced_chi2: None,
            bic: None,
            seconds,
            shortcoming: Some(why),
            taken: false,
        }
    }

    /// A line for people.
    pub fn line(&self) -> String {
        let outcome = match (&self.shortcoming, self.taken) {
            (None, _) => "suffices".to_string(),
            (Some(why), true) => format!("taken though {why}"),
            (Some(why), false) => why.clone(),
        };
        let fitted = self.reduced_chi2.map_or("not fitted".into(), |chi2| format!("reduced chi² {chi2:.4}"));
        format!("{:<15} {:>7.3} s   {fitted:<20} {outcome}", self.model, self.seconds)
    }
}

/// What speaks against the `fit` of `model`, over all channels: the worst.
fn verdict(fit: &SceneFit, model: Model, tolerance: f64) -> Verdict {
    let (mut misfit, mut undetermined) = (None, None);
    for (_, fit) in &fit.channels {
        if !fit.converged {
            return Verdict::Fails("the fit did not converge".into());
        }
        match judge((&fit.parameters, &fit.uncertainty, fit.model_error.as_ref()), model, tolerance) {
            Verdict::Undetermined(why) => undetermined = Some(why),
            Verdict::Suffices => (),
            other => return other,
        }
        let freedom = fit.pixels.saturating_sub(fit.fitted).max(1) as f64;
        if fit.reduced_chi2 > 1.0 + STRUCTURE * (2.0 / freedom).sqrt() {
            misfit = Some(format!("the residual is more than noise, reduced chi² {:.3}", fit.reduced_chi2));
        }
    }
    match (undetermined, misfit) {
        (Some(why), _) => Verdict::Undetermined(why),
        (None, Some(why)) => Verdict::Misfit(why),
        (None, None) => Verdict::Suffices,
    }
}

/// What errors and uncertainty say of `model` at a medium.
fn judge(
    (parameters, uncertainty, error): (&Parameters, &Uncertainty, Option<&ModelError>),
    model: Model,
    tolerance: f64,
) -> Verdict {
    let names = |status: Status| (0..3).filter(move |&i| uncertainty.status(i) == status);
    let lost: Vec<&str> = names(Status::Undetermined).map(|i| parameters.names()[i]).collect();
    let undetermined = format!("{} undetermined", lost.join(" and "));
    if !lost.is_empty() && !model.spreads() {
        return Verdict::Fails(undetermined);
    }
    let Some(error) = error else {
        return Verdict::Fails("its error here is not known".into());
    };
    for i in names(Status::Free) {
        let noise = uncertainty.std_error(i).unwrap_or(f64::INFINITY);
        let value = if i == 1 { parameters.values()[1] } else { 1.0 };
        let bias = error.bias_of(&Vector3::ith(i, 1.0)).abs();
        if bias > (tolerance * value).max(0.5 * noise) {
            let share = if value > 0.0 { 100.0 * bias / value } else { f64::INFINITY };
            let name = match (i, parameters.family()) {
                (2, Family::HenyeyGreenstein) => "1 - g",
                _ => parameters.names()[i],
            };
            return Verdict::Fails(format!("{name} off by {share:.2} %"));
        }
    }
    if error.image > 1.0 {
        return Verdict::Fails(format!("off by {:.1} times the noise of a pixel", error.image));
    }
    if lost.is_empty() { Verdict::Suffices } else { Verdict::Undetermined(undetermined) }
}
