//! What `narrowbeam kernel --json` prints: the numbers of the [text](super::summary) for programs.

use super::Setting;
use super::summary::Kernels;
use crate::cli::options::validity;
use crate::lab::compare::worst_encircled_error;
use crate::phase::PhaseFunction;
use crate::spread::{SecondMoments, second_moments};
use crate::trace::{Estimate, RadialProfile};
use serde::Serialize;

/// The medium, its kernels, and traced light beside them; lengths are in the unit of the depth.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    sigma_s: f64,
    sigma_a: f64,
    /// Family of the phase function, and its parameter.
    phase: &'static str,
    phase_parameter: f64,
    depth: f64,
    tau: f64,
    optical_depth: f64,
    albedo: f64,
    validity: f64,
    /// Share of the light that is not scattered.
    direct: f64,
    /// Second moment of the scattered light, exact and as the paper prints it; null where it is infinite.
    second_moment: Option<f64>,
    second_moment_printed: Option<f64>,
    models: Vec<OfModel>,
    traced: Option<OfTraced>,
}

#[derive(Debug, Serialize)]
struct OfModel {
    model: &'static str,
    /// Share of the light that is scattered and arrives.
    scattered: f64,
    /// Largest error of the encircled energy, as a share of the traced scattered light.
    worst_encircled_error: Option<Measured>,
}

#[derive(Debug, Serialize)]
struct OfTraced {
    direct: Measured,
    scattered: Measured,
    second_moment: Measured,
}

#[derive(Debug, Serialize)]
struct Measured {
    value: f64,
    std_error: f64,
}

impl From<Estimate> for Measured {
    fn from(Estimate { value, std_error }: Estimate) -> Self {
        Self { value, std_error }
    }
}

impl Summary {
    pub(super) fn new(setting: &Setting, kernels: &Kernels, traced: Option<&RadialProfile>) -> Self {
        let Setting { medium, z } = *setting;
        let moments = second_moments(&medium, z);
        Self {
            sigma_s: medium.sigma_s(),
            sigma_a: medium.sigma_a(),
            phase: medium.phase().family().name(),
            phase_parameter: medium.phase().parameter(),
            depth: z,
            tau: medium.tau(z),
            optical_depth: medium.sigma_t() * z,
            albedo: medium.albedo(),
            validity: validity(&medium, z),
            direct: medium.transmittance(z),
            second_moment: moments.map(|SecondMoments { exact, .. }| exact),
            second_moment_printed: moments.map(|SecondMoments { printed, .. }| printed),
            models: kernels
                .iter()
                .map(|(model, kernel)| OfModel {
                    model: model.name(),
                    scattered: kernel.scattered(),
                    worst_encircled_error: traced
                        .and_then(|profile| worst_encircled_error(profile, &**kernel))
                        .map(|worst| worst.share.into()),
                })
                .collect(),
            traced: traced.map(|profile| OfTraced {
                direct: profile.direct().into(),
                scattered: profile.scattered().into(),
                second_moment: profile.second_moment().into(),
            }),
        }
    }
}
