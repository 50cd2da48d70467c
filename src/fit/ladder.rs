//! No more model than a scene needs: from the cheapest model up, the first that suffices.
//!
//! A model suffices if its fit converged and determines what is free, and if its predicted error
//! ([`ModelError`](super::ModelError)) stays under the tolerance or under half the standard error, and in the image under
//! the noise of a pixel. If the residual alone speaks against it, BIC decides between it and the next: a misfit that the
//! next model does not mend is none of the model's.

use super::scenes::{SceneFit, fit_scenes};
use super::uncertainty::Status;
use super::{ChannelFit, NAMES, Settings};
use crate::error::{Error, Result};
use crate::filter::Filter;
use crate::scene::Scene;
use crate::spread::Model;
use nalgebra::Vector3;
use serde::Serialize;

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
    /// sigma_s, sigma_a and b of each channel, as far as determined.
    pub estimates: Vec<[Option<f64>; 3]>,
    /// Root mean square error of a pixel by the model, in units of the noise, of the worst channel; `None` if not known.
    pub image_error: Option<f64>,
    /// Reduced chi² over all channels.
    pub reduced_chi2: f64,
    /// Bayesian information criterion, over all channels.
    pub bic: f64,
    /// Time of the fit, seconds.
    pub seconds: f64,
    /// Why it does not suffice; `None` if it does.
    pub shortcoming: Option<String>,
    /// Whether it is the one that was taken.
    pub taken: bool,
}

/// What speaks against a fit.
enum Verdict {
    Suffices,
    /// Only that the residual holds more than noise.
    Misfit(String),
    /// Only that the data do not determine everything.
    Undetermined(String),
    Fails(String),
}

/// Fits `scenes` with one model after the other, `settings.model` aside, until one suffices to within the relative error
/// `tolerance`, and returns that fit with the ladder in its report. If none does, the one taken is the last that could be
/// fitted, or the cheapest whose only fault the dearer ones have as well.
///
/// # Errors
/// As [`fit_scenes`].
pub fn climb(scenes: &[Scene], settings: &Settings, filter: Filter, tolerance: f64) -> Result<SceneFit> {
    let mut rungs: Vec<Rung> = Vec::new();
    let mut fits: Vec<Option<SceneFit>> = Vec::new();
    let mut taken = None;
    let mut undetermined = None;
    let mut misfit: Option<usize> = None;
    for model in RUNGS {
        let fit = match fit_scenes(scenes, &Settings { model, ..*settings }, filter) {
            Ok(fit) => fit,
            // What one model cannot be asked for, another may.
            Err(Error::OutOfRange { .. } | Error::NothingToFit(_)) if model != Model::SmallAngle => continue,
            Err(error) => return Err(error),
        };
        let i = rungs.len();
        let mut rung = Rung::new(model, &fit);
        if let Some(before) = misfit.take()
            && rungs[before].bic - rung.bic < EVIDENCE
        {
            taken = Some(before);
        }
        match verdict(&fit, model, tolerance) {
            Verdict::Suffices => taken = taken.or(Some(i)),
            Verdict::Misfit(why) => {
                misfit = Some(i);
                rung.shortcoming = Some(why);
            }
            Verdict::Undetermined(why) => {
                undetermined = undetermined.or(Some(i));
                rung.shortcoming = Some(why);
            }
            Verdict::Fails(why) => rung.shortcoming = Some(why),
        }
        rungs.push(rung);
        fits.push(Some(fit));
        if taken.is_some() {
            break;
        }
    }
    let taken = taken.or(undetermined).unwrap_or(rungs.len() - 1);
    rungs[taken].taken = true;
    let mut fit = fits.swap_remove(taken).expect("every rung has a fit");
    fit.report.ladder = rungs;
    Ok(fit)
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
        let bic = |fit: &ChannelFit| 2.0 * fit.cost + fit.fitted as f64 * (fit.pixels as f64).ln();
        Self {
            model: model.name(),
            estimates: channels().map(estimate).collect(),
            image_error: errors.collect::<Option<Vec<f64>>>().map(|e| e.into_iter().fold(0.0, f64::max)),
            reduced_chi2: fit.report.fit["reduced_chi2"].as_f64().unwrap_or(f64::NAN),
            bic: channels().map(bic).sum(),
            seconds: fit.report.fit["seconds"].as_f64().unwrap_or(f64::NAN),
            shortcoming: None,
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
        format!(
            "{:<15} {:>7.3} s  reduced chi² {:<8.4} {outcome}",
            self.model, self.seconds, self.reduced_chi2
        )
    }
}

/// What speaks against `model`, over all channels: the worst.
fn verdict(fit: &SceneFit, model: Model, tolerance: f64) -> Verdict {
    let mut misfit = None;
    let mut undetermined = None;
    for (_, fit) in &fit.channels {
        if !fit.converged {
            return Verdict::Fails("the fit did not converge".into());
        }
        let lost: Vec<&str> =
            (0..3).filter(|&i| fit.uncertainty.status(i) == Status::Undetermined).map(|i| NAMES[i]).collect();
        if !lost.is_empty() {
            let why = format!("{} undetermined", lost.join(" and "));
            if !model.spreads() {
                return Verdict::Fails(why);
            }
            undetermined = Some(why);
        }
        let Some(error) = fit.model_error else {
            return Verdict::Fails("its error here is not known".into());
        };
        for i in (0..3).filter(|&i| fit.uncertainty.status(i) == Status::Free) {
            let Some(noise) = fit.uncertainty.std_error(i) else { continue };
            let value = if i == 1 { fit.parameters.values()[1] } else { 1.0 };
            let bias = error.bias_of(&Vector3::ith(i, 1.0)).abs();
            if bias > (tolerance * value).max(0.5 * noise) {
                let share = if value > 0.0 { 100.0 * bias / value } else { f64::INFINITY };
                return Verdict::Fails(format!("{} off by {share:.2} %", NAMES[i]));
            }
        }
        if error.image > 1.0 {
            return Verdict::Fails(format!("off by {:.1} times the noise of a pixel", error.image));
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
