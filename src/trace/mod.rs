//! Photon tracer: an independent check of the kernels and the filter.
//!
//! Light is followed through the full three-dimensional transport equation of a homogeneous, index-matched
//! medium, without small angles. A path starts at the medium's surface, flies free distances of density
//! sigma_s exp(-sigma_s t), and is turned by the [`PhaseFunction`](crate::phase::PhaseFunction) in between;
//! absorption is continuous, a weight exp(-sigma_a L) on the total path length L in the medium. By reciprocity
//! (Gordon, Appl. Opt. 33, 1120, 1994) paths started at the camera see the object as its light sees the camera.
//! A path that leaves through the medium's front surface is lost, and the object's first crossing ends it.
//!
//! [`trace_radial`] tallies where a pencil beam crosses planes at many depths; [`trace_image`] makes the image
//! of a scene with its variance. [`trace_paths`] and [`Hits`] record what the likelihood of every path depends on, and
//! replay the paths for neighbouring media. All results are the same, bit for bit, for any number of threads.
//! This module uses nothing of the kernels, the filter or the fit, so their agreement with it is evidence.
//!
//! Not modelled: refraction at the surface, light scattered in from the illumination, light between objects.

mod config;
mod hits;
mod image;
mod likelihood;
mod march;
mod meeting;
mod patches;
mod path;
mod path_records;
mod radial;
mod replay;
mod rng;
mod scene;
mod surface;
mod tally;

pub use config::ImageConfig;
pub use hits::{BATCHES, Hits};
pub use image::{TracedImage, trace_image};
pub use likelihood::{Change, EffectiveSampleSize, Information, Likelihood, Replay, Weight};
pub use path::{Path, free_path};
pub use path_records::{PathRecord, PathRecords, Scattered, trace_paths};
pub(crate) use radial::annulus_mean;
pub use radial::{RadialConfig, RadialProfile, log_spaced, trace_radial};
pub use replay::ReplayedSum;
pub use rng::Stream;

/// sigma_a L at which a path is abandoned: it carries 1e-26 of its light.
const OPAQUE: f32 = 60.0;

/// A Monte Carlo mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The mean over all paths.
    pub value: f64,
    /// Standard deviation of that mean.
    pub std_error: f64,
}

impl Estimate {
    /// Mean and standard error over `paths` independent paths from the sums of their scores and squared scores.
    fn from_sums(sum: f64, sum_of_squares: f64, paths: u64) -> Self {
        let n = paths as f64;
        let value = sum / n;
        let variance = (sum_of_squares / n - value * value).max(0.0);
        Self { value, std_error: (variance / (n - 1.0).max(1.0)).sqrt() }
    }

    /// How many standard errors the estimate lies above `truth`.
    pub fn z_score(&self, truth: f64) -> f64 {
        (self.value - truth) / self.std_error
    }
}
