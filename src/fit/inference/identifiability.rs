//! What the data do determine where they leave a parameter open, or hold two only together.
//!
//! A named combination c of the parameters has, to first order, the relative variance g·C·g, with g the gradient of ln c in
//! their coordinates and C the covariance. Light scattered many times is spread by a Gaussian of
//! variance (2/3) sigma_s B z³ an axis (Fermi and Eyges), so it shows sigma_s·B; light scattered once, seen near the centre of
//! its kernel 1/r, shows sigma_s/√B; direct light sigma_t; and where a gain is free, the level of an image at one depth shows
//! gain·exp(-sigma_a z). For Henyey-Greenstein's phase function 1 - g takes the place of B.

use super::channel_fit::ChannelFit;
use super::combination::Combination;
use super::covariance::Status;
use crate::fit::observation::Observation;
use crate::fit::parameters::Id;
use crate::forward::Quantity;
use crate::geometry::path_lengths;
use crate::phase::Family;
use nalgebra::DVector;

/// Correlation of two errors above which what is known of both together is worth telling.
const ENTANGLED: f64 = 0.95;
/// Relative error above which a combination is not known either; as for parameters.
const MOST_ERROR: f64 = 0.5;
/// How many times better than the worst of its parts a combination must be known to be worth telling.
const SHARPER: f64 = 2.0;
/// How many times worse than the best a plainer power of B may be known to be preferred.
const PLAINER: f64 = 2.0;
/// Powers of B beside sigma_s that are tried, the plainest first.
const POWERS: [(f64, &str); 7] = [
    (1.0, "·b"),
    (0.5, "·√b"),
    (-0.5, "/√b"),
    (2.0, "·b²"),
    (1.5, "·b^(3/2)"),
    (-1.0, "/b"),
    (1.0 / 3.0, "·b^(1/3)"),
];

struct Candidate {
    name: String,
    value: f64,
    /// Change of ln c with the coordinates of the parameters that stand in its name.
    parts: DVector<f64>,
    /// Change of ln c with the coordinates, that of a free gain counted in.
    gradient: DVector<f64>,
    /// Variance of ln c at given coordinates.
    apart: f64,
    /// Whether a free gain takes part, whose error by the model is not known.
    exposed: bool,
}

impl Candidate {
    fn of(name: String, value: f64, gradient: DVector<f64>) -> Self {
        Self { name, value, parts: gradient.clone(), gradient, apart: 0.0, exposed: false }
    }

    /// Standard error of ln c; `None` if the data do not decide it.
    fn error(&self, fit: &ChannelFit) -> Option<f64> {
        Some((fit.variance_of(&self.gradient)? + self.apart).sqrt())
    }

    /// Whether it says more than its parts do, where one of them is in trouble.
    fn is_informative(&self, fit: &ChannelFit, error: f64) -> bool {
        let alone = |id: Id| fit.variance_of(&fit.parameters.along(id)).map_or(f64::INFINITY, f64::sqrt);
        let part = |id: Id| self.parts[id.row()].abs() * alone(id);
        let taking_part = || {
            let ids = fit.parameters.of_medium().map(|(id, _)| id);
            ids.filter(|id| self.parts[id.row()] != 0.0 && fit.covariance.status(*id) != Status::Fixed)
        };
        let reference = fit.model_error.as_ref().map_or(0.0, |m| m.reference_of(&self.gradient));
        taking_part().any(|id| is_in_trouble(fit, id))
            && error.max(reference) <= MOST_ERROR
            && taking_part().map(part).fold(0.0, f64::max) >= SHARPER * error
    }
}

/// The combinations that the data determine, if they leave a parameter open or hold two only together.
pub(crate) fn determined(observations: &[Observation], fit: &ChannelFit) -> Vec<Combination> {
    if !fit.parameters.of_medium().any(|(id, _)| is_in_trouble(fit, id)) {
        return Vec::new();
    }
    let known = |candidate: Candidate| {
        let error = candidate.error(fit)?;
        let model =
            fit.model_error.as_ref().filter(|_| !candidate.exposed).map(|m| m.of(&candidate.gradient));
        candidate.is_informative(fit, error).then_some(Combination {
            combination: candidate.name,
            value: candidate.value,
            std_error: candidate.value * error,
            relative_error: error,
            model_error: model.map(|m| m * candidate.value),
        })
    };
    let candidates = product(fit).into_iter().chain(extinction(fit)).chain(levels(observations, fit));
    candidates.filter_map(known).collect()
}

/// Whether a parameter is undetermined, or known only together with another of the medium.
fn is_in_trouble(fit: &ChannelFit, id: Id) -> bool {
    let entangled = |other: Id| fit.covariance.correlation(id, other).is_some_and(|r| r.abs() > ENTANGLED);
    fit.covariance.status(id) == Status::Undetermined
        || fit.parameters.of_medium().any(|(other, _)| other != id && entangled(other))
}

/// The product of sigma_s and a power of B: the plainest of those that are known nearly as well as the best.
fn product(fit: &ChannelFit) -> Option<Candidate> {
    let (sigma_s, phase) = (fit.parameters.of(Quantity::SigmaS), fit.parameters.of(Quantity::Phase));
    let b = phase.coordinate().exp();
    let width = match fit.parameters.family() {
        Family::Gaussian => "b",
        Family::HenyeyGreenstein => "(1 - g)",
    };
    if !fit.model.spreads() {
        return None;
    }
    let candidate = |(power, text): (f64, &str)| {
        let name = format!("{}{}", sigma_s.name(), text.replace('b', width));
        let gradient = fit.parameters.direction(&[(Quantity::SigmaS, 1.0), (Quantity::Phase, power)]);
        let candidate = Candidate::of(name, sigma_s.value() * b.powf(power), gradient);
        Some((candidate.error(fit)?, candidate))
    };
    let all: Vec<(f64, Candidate)> = POWERS.into_iter().filter_map(candidate).collect();
    let best = all.iter().map(|(error, _)| *error).fold(MOST_ERROR, f64::min);
    all.into_iter()
        .find(|(error, _)| *error <= (PLAINER * best).min(MOST_ERROR))
        .map(|(_, candidate)| candidate)
}

/// sigma_t, of direct light.
fn extinction(fit: &ChannelFit) -> Option<Candidate> {
    let (sigma_s, sigma_a) = (fit.parameters.value(Quantity::SigmaS), fit.parameters.value(Quantity::SigmaA));
    let sigma_t = sigma_s + sigma_a;
    let gradient =
        fit.parameters.direction(&[(Quantity::SigmaS, sigma_s), (Quantity::SigmaA, 1.0)]) / sigma_t;
    (sigma_t > 0.0).then(|| Candidate::of("sigma_t".into(), sigma_t, gradient))
}

/// gain·exp(-sigma_a z) of each scene whose gain is free, at its median path length.
fn levels(observations: &[Observation], fit: &ChannelFit) -> Vec<Candidate> {
    let level = |(i, observation): (usize, &Observation)| {
        let exposure = &fit.exposures[i];
        let response = exposure.gain_response.as_ref()?;
        let z = path_lengths(&[(observation.target.geometry, observation.target.radiance)]).median;
        let absorbed = fit.parameters.direction(&[(Quantity::SigmaA, -z)]);
        let scene = if observations.len() > 1 { format!(" of scene {}", i + 1) } else { String::new() };
        Some(Candidate {
            name: format!("gain·exp(-sigma_a z){scene}"),
            value: exposure.gain * (-fit.parameters.value(Quantity::SigmaA) * z).exp(),
            gradient: &response.slope + &absorbed,
            parts: absorbed,
            apart: response.variance,
            exposed: true,
        })
    };
    observations.iter().enumerate().filter_map(level).collect()
}
