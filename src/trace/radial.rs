//! Radial tallies: where a pencil beam crosses planes at many depths.
//!
//! The beam enters the half-space z > 0 on the axis. Of each path the *first* crossing of every plane is recorded,
//! so all planes share the same paths; a path that leaves through z = 0 is lost to the planes not yet reached.
//! Every quantity is absolute, per launched path, and comes with its standard error.

use super::path::{Path, free_path};
use super::rng::Stream;
use super::tally::{Bins, Tally};
use super::{Estimate, OPAQUE};
use crate::error::{Error, Result, in_range};
use crate::medium::Medium;
use crate::phase::{Phase, PhaseFunction};
use glam::Vec3;
use libm::j1;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Paths of one unit of work. Its tally is summed on its own and then added in order, so that rounding does not
/// depend on the number of threads.
const CHUNK: u64 = 16_384;

/// Chunks traced between two summations: enough for any number of cores, and little memory.
const BATCH: u64 = 128;

/// What to trace.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialConfig<P = Phase> {
    /// The medium that fills z > 0.
    pub medium: Medium<P>,
    /// Depths of the planes, increasing (length).
    pub depths: Vec<f64>,
    /// Radii between the bins, increasing (length); see [`log_spaced`].
    pub edges: Vec<f64>,
    /// Paths to launch.
    pub paths: u64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// `count` radii from `first` to `last`, evenly spaced in their logarithm.
pub fn log_spaced(first: f64, last: f64, count: usize) -> Vec<f64> {
    let step = (last / first).ln() / (count.max(2) - 1) as f64;
    (0..count).map(|i| first * (step * i as f64).exp()).collect()
}

impl<P> RadialConfig<P> {
    fn check(&self) -> Result<()> {
        let depths = "finite, above 0 and increasing (length)";
        let edges = "between 1e-15 and 1e15 and increasing (length)";
        increasing("depth of a plane", &self.depths, 0.0, f64::MAX, depths)?;
        increasing("edge of a radius bin", &self.edges, 1e-15, 1e15, edges)?;
        in_range("paths", self.paths as f64, self.paths > 0, "at least 1")?;
        Ok(())
    }
}

/// Refuses an empty list, and the first of `values` that is not above its predecessor, `low` and below `high`.
fn increasing(name: &str, values: &[f64], low: f64, high: f64, allowed: &'static str) -> Result<()> {
    in_range(&format!("count of {name}"), values.len() as f64, !values.is_empty(), "at least 1")?;
    let mut last = low;
    for &value in values {
        last = in_range(name, value, value > last && value < high, allowed)?;
    }
    Ok(())
}

/// Traces the beam; `progress` receives the number of paths of each finished chunk, from any thread.
///
/// # Errors
/// [`Error::OutOfRange`] for depths or edges that do not increase, or no paths.
pub fn trace_radial<P: PhaseFunction>(
    config: &RadialConfig<P>,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Vec<RadialProfile>> {
    config.check()?;
    let beam = Beam {
        sigma_s: config.medium.sigma_s() as f32,
        sigma_a: config.medium.sigma_a() as f32,
        depths: config.depths.iter().map(|&z| z as f32).collect(),
        bins: Bins::new(&config.edges),
        phase: config.medium.phase(),
    };
    let empty = || vec![Tally::new(config.edges.len() + 1); config.depths.len()];
    let key = Stream::key(config.seed);
    let mut total = empty();
    let chunks = config.paths.div_ceil(CHUNK);
    for batch in (0..chunks).step_by(BATCH as usize) {
        let tallies: Vec<_> = (batch..chunks.min(batch + BATCH))
            .into_par_iter()
            .map(|chunk| {
                let mut tally = empty();
                let paths = chunk * CHUNK..config.paths.min((chunk + 1) * CHUNK);
                let count = paths.end - paths.start;
                paths.for_each(|i| beam.trace(&mut Stream::new(key, i), &mut tally));
                progress(count);
                tally
            })
            .collect();
        tallies.iter().flat_map(|t| t.iter().enumerate()).for_each(|(i, tally)| total[i].add(tally));
    }
    let profile = |(tally, &z): (Tally, &f64)| RadialProfile {
        z,
        edges: config.edges.clone(),
        paths: config.paths,
        unabsorbed: (-config.medium.sigma_a() * z).exp(),
        tally,
    };
    let profiles: Vec<_> = total.into_iter().zip(&config.depths).map(profile).collect();
    if profiles.iter().all(|p| p.scattered().value.is_finite()) {
        Ok(profiles)
    } else {
        Err(Error::NotFinite("the radial tally is not finite".into()))
    }
}

/// What is shared by all paths.
struct Beam<'a, P> {
    sigma_s: f32,
    sigma_a: f32,
    depths: Vec<f32>,
    bins: Bins,
    phase: &'a P,
}

impl<P: PhaseFunction> Beam<'_, P> {
    /// Follows one path from the origin along +z and scores it in the tally of each plane.
    #[inline]
    fn trace(&self, stream: &mut Stream, planes: &mut [Tally]) {
        let mut path = Path::new(Vec3::ZERO, Vec3::Z);
        let mut scattered = false;
        let mut next = 0;
        loop {
            let step = free_path(self.sigma_s, stream);
            let end = path.position.z + step * path.direction.z;
            while end >= self.depths[next] {
                if scattered {
                    let rest = (self.depths[next] - path.position.z) / path.direction.z;
                    let weight = (-self.sigma_a * (path.length + rest)).exp();
                    let x = path.position.x + rest * path.direction.x;
                    let y = path.position.y + rest * path.direction.y;
                    let r2 = x * x + y * y;
                    planes[next].score(self.bins.of(r2), f64::from(weight), f64::from(r2));
                } else {
                    planes[next].direct += 1;
                }
                next += 1;
                if next == self.depths.len() {
                    return;
                }
            }
            path.advance(step);
            if end < 0.0 || self.sigma_a * path.length > OPAQUE {
                planes[next..].iter_mut().for_each(|plane| plane.lost += 1);
                return;
            }
            path.scatter(self.phase, stream);
            scattered = true;
        }
    }
}

/// Where the light of a pencil beam crosses one plane, per launched path.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialProfile {
    /// Depth of the plane.
    pub z: f64,
    /// Radii between the bins.
    pub edges: Vec<f64>,
    /// Paths launched.
    pub paths: u64,
    unabsorbed: f64,
    tally: Tally,
}

impl RadialProfile {
    /// Light that reaches the plane unscattered; its expectation is exp(-sigma_t z).
    pub fn direct(&self) -> Estimate {
        let (n, w) = (self.tally.direct as f64, self.unabsorbed);
        Estimate::from_sums(n * w, n * w * w, self.paths)
    }

    /// Light that reaches the plane scattered, at whatever radius.
    pub fn scattered(&self) -> Estimate {
        self.in_bins(0..self.tally.bins.len())
    }

    /// Share of the paths that left through z = 0 before they reached the plane (or that absorption extinguished
    /// to below 1e-26). Without absorption `direct` + `scattered` + `lost` is 1.
    pub fn lost(&self) -> Estimate {
        let n = self.tally.lost as f64;
        Estimate::from_sums(n, n, self.paths)
    }

    /// Paths that were scattered and reached the plane.
    pub fn scattered_paths(&self) -> u64 {
        self.tally.scattered
    }

    /// Second radial moment R = ∫ r² psf dA of the scattered light, length².
    pub fn second_moment(&self) -> Estimate {
        Estimate::from_sums(self.tally.moment[0], self.tally.moment[1], self.paths)
    }

    /// Scattered light within radius `edges[i]`.
    pub fn encircled_energy(&self, i: usize) -> Estimate {
        self.in_bins(0..i + 1)
    }

    /// Radius within which the share `share` of the scattered light falls, interpolated in ln r between two edges; at
    /// least the first edge and at most the last.
    pub fn quantile_radius(&self, share: f64) -> f64 {
        let wanted = share * self.scattered().value;
        let mut before = 0.0;
        for (i, bin) in self.tally.bins[..self.edges.len()].iter().enumerate() {
            let within = before + bin[0] / self.paths as f64;
            if within >= wanted && within > before {
                let inner = self.edges[i.max(1) - 1];
                return inner * (self.edges[i] / inner).powf((wanted - before) / (within - before));
            }
            before = within;
        }
        self.edges[self.edges.len() - 1]
    }

    /// Mean of the point spread function of the scattered light between radii `edges[lo]` and `edges[hi]`, 1/area.
    pub fn density(&self, lo: usize, hi: usize) -> Estimate {
        let area = PI * (self.edges[hi] * self.edges[hi] - self.edges[lo] * self.edges[lo]);
        let light = self.in_bins(lo + 1..hi + 1);
        Estimate { value: light.value / area, std_error: light.std_error / area }
    }

    /// Transfer function at `k` rad/length, direct light included: M(0) is all light that arrives.
    ///
    /// The mean of J0(k r) over each annulus is exact for light spread evenly over it,
    /// 2 (r2 J1(k r2) - r1 J1(k r1)) / (k (r2² - r1²)). Light beyond the last edge is taken to average out.
    pub fn mtf(&self, k: f64) -> Estimate {
        let (n, w) = (self.tally.direct as f64, self.unabsorbed);
        let (mut sum, mut squares) = (n * w, n * w * w);
        let mut inner = 0.0;
        for (&outer, bin) in self.edges.iter().zip(&self.tally.bins) {
            let j = annulus_mean(k, inner, outer);
            sum += bin[0] * j;
            squares += bin[1] * j * j;
            inner = outer;
        }
        let beyond = self.tally.bins[self.edges.len()];
        if k == 0.0 {
            sum += beyond[0];
            squares += beyond[1];
        }
        Estimate::from_sums(sum, squares, self.paths)
    }

    /// Scattered light in the radius bins `range`: bin 0 lies within the first edge, bin i between the edges i - 1 and i.
    pub fn in_bins(&self, range: std::ops::Range<usize>) -> Estimate {
        let (mut sum, mut squares) = (0.0, 0.0);
        for bin in &self.tally.bins[range] {
            sum += bin[0];
            squares += bin[1];
        }
        Estimate::from_sums(sum, squares, self.paths)
    }
}

/// Mean of J0(k r) over the annulus between two radii.
pub(crate) fn annulus_mean(k: f64, inner: f64, outer: f64) -> f64 {
    if k == 0.0 {
        return 1.0;
    }
    let primitive = |r: f64| r * j1(k * r);
    2.0 * (primitive(outer) - primitive(inner)) / (k * (outer * outer - inner * inner))
}
