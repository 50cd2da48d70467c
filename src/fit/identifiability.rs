//! What the data do determine where they leave a parameter open, or hold two only together.
//!
//! A named combination c of the parameters has, to first order, the relative variance g·C·g, with g the gradient of ln c in
//! the coordinates (ln sigma_s, sigma_a, ln B) and C their covariance. Light scattered many times is spread by a Gaussian of
//! variance (2/3) sigma_s B z³ an axis (Fermi and Eyges), so it shows sigma_s·B; light scattered once, seen near the centre of
//! its kernel 1/r, shows sigma_s/√B; direct light sigma_t; and where a gain is free, the level of an image at one depth shows
//! gain·exp(-sigma_a z). For Henyey-Greenstein's phase function 1 - g takes the place of B.

use super::{ChannelFit, Datum, Status, path_lengths};
use crate::phase::Family;
use nalgebra::Vector3;
use serde::Serialize;

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

/// A combination of parameters that the data determine.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Combination {
    /// What it is, in the names of the parameters.
    pub combination: String,
    /// Its value at the estimate.
    pub value: f64,
    /// Standard error from the noise and from stated errors of depth and gain.
    pub std_error: f64,
    /// The same over the value.
    pub relative_error: f64,
    /// Error of the model; `None` where it is not known, as where a free gain takes part.
    pub model_error: Option<f64>,
}

struct Candidate {
    name: String,
    value: f64,
    /// Exponents of sigma_s and B, and change of ln c with sigma_a, where they stand in its name.
    parts: Vector3<f64>,
    /// Change of ln c with the coordinates, that of a free gain counted in.
    gradient: Vector3<f64>,
    /// Variance of ln c at given coordinates.
    apart: f64,
    /// Whether a free gain takes part, whose error by the model is not known.
    exposed: bool,
}

impl Candidate {
    fn of(name: String, value: f64, gradient: Vector3<f64>) -> Self {
        Self { name, value, parts: gradient, gradient, apart: 0.0, exposed: false }
    }

    /// Standard error of ln c; `None` if the data do not decide it.
    fn error(&self, fit: &ChannelFit) -> Option<f64> {
        Some((fit.variance_of(&self.gradient)? + self.apart).sqrt())
    }

    /// Whether it says more than its parts do, where one of them is in `trouble`.
    fn tells(&self, fit: &ChannelFit, error: f64, trouble: [bool; 3]) -> bool {
        let alone = |i: usize| fit.variance_of(&Vector3::ith(i, 1.0)).map_or(f64::INFINITY, f64::sqrt);
        let part = |i: usize| self.parts[i].abs() * alone(i);
        let taking_part =
            || (0..3).filter(|&i| self.parts[i] != 0.0 && fit.uncertainty.status(i) != Status::Fixed);
        let reference = fit.model_error.map_or(0.0, |m| m.reference_of(&self.gradient));
        taking_part().any(|i| trouble[i])
            && error.max(reference) <= MOST_ERROR
            && taking_part().map(part).fold(0.0, f64::max) >= SHARPER * error
    }
}

/// The combinations that the data determine, if they leave a parameter open or hold two only together.
pub(super) fn determined(data: &[Datum], fit: &ChannelFit) -> Vec<Combination> {
    let trouble = trouble(fit);
    if trouble == [false; 3] {
        return Vec::new();
    }
    let known = |candidate: Candidate| {
        let error = candidate.error(fit)?;
        let model = fit.model_error.filter(|_| !candidate.exposed).map(|m| m.of(&candidate.gradient));
        candidate.tells(fit, error, trouble).then_some(Combination {
            combination: candidate.name,
            value: candidate.value,
            std_error: candidate.value * error,
            relative_error: error,
            model_error: model.map(|m| m * candidate.value),
        })
    };
    product(fit).into_iter().chain(extinction(fit)).chain(levels(data, fit)).filter_map(known).collect()
}

/// Which parameters are undetermined, or known only together with another.
fn trouble(fit: &ChannelFit) -> [bool; 3] {
    let lost = |i: usize| fit.uncertainty.status(i) == Status::Undetermined;
    let entangled =
        |i: usize, j: usize| fit.uncertainty.correlation(i, j).is_some_and(|r| r.abs() > ENTANGLED);
    std::array::from_fn(|i| lost(i) || (0..3).any(|j| j != i && entangled(i, j)))
}

/// The product of sigma_s and a power of B: the plainest of those that are known nearly as well as the best.
fn product(fit: &ChannelFit) -> Option<Candidate> {
    let (sigma_s, b) = (fit.parameters.values()[0], fit.parameters.internal()[2].exp());
    let width = match fit.parameters.family() {
        Family::Gaussian => "b",
        Family::HenyeyGreenstein => "(1 - g)",
    };
    if !fit.model.spreads() {
        return None;
    }
    let candidate = |(power, text): (f64, &str)| {
        let name = format!("{}{}", fit.parameters.names()[0], text.replace('b', width));
        let candidate = Candidate::of(name, sigma_s * b.powf(power), Vector3::new(1.0, 0.0, power));
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
    let [sigma_s, sigma_a, _] = fit.parameters.values();
    let sigma_t = sigma_s + sigma_a;
    let gradient = Vector3::new(sigma_s, 1.0, 0.0) / sigma_t;
    (sigma_t > 0.0).then(|| Candidate::of("sigma_t".into(), sigma_t, gradient))
}

/// gain·exp(-sigma_a z) of each scene whose gain is free, at its median path length.
fn levels(data: &[Datum], fit: &ChannelFit) -> Vec<Candidate> {
    let level = |(i, datum): (usize, &Datum)| {
        let exposure = &fit.exposures[i];
        let (response, apart) = exposure.gain_response?;
        let z = path_lengths(&[datum.target.geometry]).median;
        let absorbed = Vector3::new(0.0, -z, 0.0);
        let scene = if data.len() > 1 { format!(" of scene {}", i + 1) } else { String::new() };
        Some(Candidate {
            name: format!("gain·exp(-sigma_a z){scene}"),
            value: exposure.gain * (-fit.parameters.values()[1] * z).exp(),
            parts: absorbed,
            gradient: response + absorbed,
            apart,
            exposed: true,
        })
    };
    data.iter().enumerate().filter_map(level).collect()
}
