//! One experiment: a pencil beam traced through a medium, and every kernel, as light per radius in rings of equal width.

use super::models;
use crate::error::{Error, Result};
use crate::lab::compare::{RmsError, rms_error};
use crate::medium::Medium;
use crate::phase::b_of_spread_angle;
use crate::spread::{Model, SpreadKernel};
use crate::trace::{Estimate, RadialConfig, RadialProfile, trace_radial};
use rayon::prelude::*;

/// A beam, the planes that it crosses, and the rings in which they are read.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// Single-scattering albedo sigma_s / sigma_t; sigma_t = 1.
    pub albedo: f64,
    /// sqrt(4 B), degrees.
    pub spread_angle_deg: f64,
    /// The planes, in order of depth.
    pub planes: Vec<Plane>,
    /// Rings at each plane, from the axis outwards.
    pub rings: usize,
    /// Finest width of a ring (length).
    pub step: f64,
    /// Paths to launch.
    pub paths: u64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// A plane at which light is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Depth (length).
    pub z: f64,
    /// Width of its rings in steps of the experiment.
    pub steps: usize,
}

/// The light per radius at one plane: means of 2 pi r Psi over each ring, per length, a share of all light.
#[derive(Debug, Clone, PartialEq)]
pub struct Rings {
    /// Single-scattering albedo; sigma_t = 1.
    pub albedo: f64,
    /// sqrt(4 B), degrees.
    pub spread_angle_deg: f64,
    /// Depth of the plane (length).
    pub z: f64,
    /// Width of a ring (length).
    pub width: f64,
    /// Traced scattered light, ring by ring from the axis outwards.
    pub traced: Vec<Estimate>,
    /// The scattered light of each model.
    pub kernels: Vec<(Model, Vec<f64>)>,
    /// Paths traced.
    pub paths: u64,
}

impl Experiment {
    /// Traces the beam and evaluates the kernels; `progress` receives the number of paths of each finished chunk.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for an experiment with impossible numbers; [`Error::NotFinite`] with model and place.
    pub fn run(&self, progress: &(dyn Fn(u64) + Sync)) -> Result<Vec<Rings>> {
        let b = b_of_spread_angle(self.spread_angle_deg.to_radians());
        let medium = Medium::gaussian(self.albedo, 1.0 - self.albedo, b)?;
        let widest = self.planes.iter().map(|p| p.steps).max().unwrap_or(0);
        let config = RadialConfig {
            medium,
            depths: self.planes.iter().map(|p| p.z).collect(),
            edges: (1..=self.rings * widest).map(|i| self.step * i as f64).collect(),
            paths: self.paths,
            seed: self.seed,
        };
        let profiles = trace_radial(&config, progress)?;
        let kernels = |z: f64, width: f64| -> Result<Vec<(Model, Vec<f64>)>> {
            let of = |model: Model| {
                let kernel = model.kernel(&medium, z)?;
                Ok((model, light_per_radius(model, &*kernel, self.rings, width)?))
            };
            models().map(of).collect()
        };
        let at = |(plane, profile): (&Plane, &RadialProfile)| {
            let width = self.step * plane.steps as f64;
            Ok(Rings {
                albedo: self.albedo,
                spread_angle_deg: self.spread_angle_deg,
                z: plane.z,
                width,
                traced: traced_light_per_radius(profile, self.rings, plane.steps, width),
                kernels: kernels(plane.z, width)?,
                paths: self.paths,
            })
        };
        self.planes.par_iter().zip(&profiles).map(at).collect()
    }
}

fn traced_light_per_radius(profile: &RadialProfile, rings: usize, steps: usize, width: f64) -> Vec<Estimate> {
    let per_length =
        |light: Estimate| Estimate { value: light.value / width, std_error: light.std_error / width };
    (0..rings).map(|i| per_length(profile.in_bins(i * steps..(i + 1) * steps))).collect()
}

fn light_per_radius(model: Model, kernel: &dyn SpreadKernel, rings: usize, width: f64) -> Result<Vec<f64>> {
    let within = |i: usize| match kernel.encircled_energy(width * i as f64) {
        light if light.is_finite() => Ok(light),
        light => Err(Error::NotFinite(format!("{model}: r = {:e} gives {light}", width * i as f64))),
    };
    let outer = (1..=rings).into_par_iter().map(within).collect::<Result<Vec<f64>>>()?;
    let inner = std::iter::once(&0.0).chain(&outer);
    Ok(outer.iter().zip(inner).map(|(outer, inner)| (outer - inner) / width).collect())
}

impl Rings {
    /// The radius in the middle of ring `i` (length).
    pub fn radius(&self, i: usize) -> f64 {
        self.width * (i as f64 + 0.5)
    }

    /// The same light in rings `count` times as wide; those that do not fill one are left out. A path ends in one ring at
    /// most, so that cov(t_i, t_j) = -t_i t_j / (n - 1), as variances are estimated.
    pub fn merged(&self, count: usize) -> Self {
        let (n, k) = (self.paths as f64 - 1.0, count as f64);
        let join = |rings: &[Estimate]| {
            let value = rings.iter().map(|t| t.value).sum::<f64>() / k;
            let squares =
                rings.iter().map(|t| t.std_error * t.std_error + t.value * t.value / n).sum::<f64>();
            Estimate { value, std_error: (squares / (k * k) - value * value / n).max(0.0).sqrt() }
        };
        let mean = |rings: &[f64]| rings.iter().sum::<f64>() / k;
        Self {
            width: self.width * k,
            traced: self.traced.chunks_exact(count).map(join).collect(),
            kernels: self
                .kernels
                .iter()
                .map(|(model, light)| (*model, light.chunks_exact(count).map(mean).collect()))
                .collect(),
            ..self.clone()
        }
    }

    /// The relative rms error of each model; see [`rms_error`].
    ///
    /// # Errors
    /// [`Error::NotFinite`] if so few paths were traced that their light is lost in its noise.
    pub fn errors(&self) -> Result<Vec<(Model, RmsError)>> {
        let dark = || Error::NotFinite(format!("no traced light at depth {}", self.z));
        let of = |(model, kernel): &(Model, Vec<f64>)| {
            Ok((*model, rms_error(kernel, &self.traced, Some(self.paths)).ok_or_else(dark)?))
        };
        self.kernels.iter().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faint light at 5 degrees: in the outer rings some ten photons each.
    fn experiment(seed: u64, paths: u64) -> Experiment {
        let planes = vec![Plane { z: 1.0, steps: 1 }];
        Experiment { albedo: 1.0, spread_angle_deg: 5.0, planes, rings: 60, step: 0.01, paths, seed }
    }

    fn error_of(model: Model, seed: u64, paths: u64) -> RmsError {
        let rings = experiment(seed, paths).run(&|_| ()).unwrap().remove(0);
        rings.errors().unwrap().into_iter().find(|e| e.0 == model).unwrap().1
    }

    #[test]
    fn the_error_does_not_depend_on_the_number_of_photons() {
        // The noise of the few photons alone is 0.06, and would raise an error of 0.09 to 0.11.
        let (few, many) = (error_of(Model::NarrowBeam, 1, 4_000), error_of(Model::NarrowBeam, 2, 2_000_000));
        assert!(few.noise > 20.0 * many.noise);
        let bound = 4.0 * few.error.std_error.hypot(many.error.std_error);
        assert!((few.error.value - many.error.value).abs() < bound, "{few:?} {many:?}");
        let noisy = few.error.value.hypot(few.noise);
        assert!(noisy - many.error.value > 0.01, "{few:?} {many:?}");
    }

    #[test]
    fn the_stated_error_is_the_scatter_between_seeds() {
        let errors: Vec<_> = (0..80).map(|seed| error_of(Model::Gaussian, seed, 4_000).error).collect();
        let n = errors.len() as f64;
        let mean = errors.iter().map(|e| e.value).sum::<f64>() / n;
        let scatter = (errors.iter().map(|e| (e.value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        let stated = errors.iter().map(|e| e.std_error).sum::<f64>() / n;
        // The standard deviation of 80 values is itself known to 8 %.
        assert!((stated / scatter - 1.0).abs() < 0.3, "stated {stated}, scatter {scatter}");
    }

    #[test]
    fn merged_rings_are_those_of_a_coarser_tally() {
        let fine = experiment(1, 20_000).run(&|_| ()).unwrap().remove(0).merged(5);
        let coarse = Experiment { rings: 12, step: 0.05, ..experiment(1, 20_000) };
        let coarse = coarse.run(&|_| ()).unwrap().remove(0);
        // Photons on an edge may fall to either side of it in f32; none does here.
        for (a, b) in fine.traced.iter().zip(&coarse.traced) {
            assert!((a.value - b.value).abs() < 1e-12 && (a.std_error - b.std_error).abs() < 1e-12);
        }
        for (a, b) in fine.kernels.iter().zip(&coarse.kernels) {
            assert!(a.0 == b.0 && a.1.iter().zip(&b.1).all(|(x, y)| (x - y).abs() < 1e-9), "{}", a.0);
        }
    }
}
