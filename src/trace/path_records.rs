//! Path records: what the likelihood of a traced path depends on, for scattered light that crosses a plane.
//!
//! A pencil beam enters the half-space z > 0, as in [`trace_radial`](super::trace_radial); lengths are in units of the
//! plane's depth, so that a medium is tau = sigma_s z, a = sigma_a z and its phase function. Four measures reduce the variance:
//!
//! - *The first scattering is drawn before the plane*, with density tau exp(-tau t)/(1 - exp(-tau)): no path is spent
//!   on direct light. Its depths are stratified, one in each of as many equal shares as there are paths.
//! - *So is the second*, if only light scattered more than once is wanted: the importance of a path is the probability that
//!   it scatters again before it leaves, and it is copied in proportion. Where small-angle theory holds, all such paths
//!   arrive, and their light has no noise.
//! - *Absorption of the excess length is sampled, not weighted.* A segment of length l and direction cosine mu exceeds
//!   its depth l mu by l (1 - mu), so a path dies at the rate a (1 - mu), and arrives with the probability
//!   E[exp(-a (L - 1))]: the weight exp(-a) remains, the same for all.
//! - *Multilevel splitting* (Kahn and Harris 1951; Garvels 2000): paths that reach the next of eight depths for the
//!   first time are copied until there are as many as at the start, and each counts for the share that got there. The
//!   product of the shares is an unbiased estimate of the light that arrives, even if it is exp(-20).
//!
//! Copies are drawn systematically (Kitagawa 1996): a path of m times the mean importance has m copies, rounded up or down, so
//! drawing them adds no noise to the light, and little to where it falls.

use super::likelihood::Likelihood;
use super::path::{Path, free_path};
use super::rng::Stream;
use crate::error::{Result, in_range};
use crate::medium::Medium;
use crate::memory::{product, reserve};
use glam::Vec3;
use rayon::prelude::*;

/// Depths, evenly spaced, at which paths are split; the last is the plane.
const LEVELS: u64 = 8;

/// One scattered path at its first crossing of the plane, lengths in units of the plane's depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathRecord<M> {
    /// Number of scatterings n, at least 1.
    pub scatterings: u32,
    /// What is recorded of its deflections.
    pub memory: M,
    /// Path length L.
    pub length: f32,
    /// Distance r of the crossing from the axis.
    pub radius: f32,
    /// Slope s of the path at the crossing, its component along r.
    pub slope: f32,
}

/// A sample of paths, all of one weight.
#[derive(Debug, Clone, PartialEq)]
pub struct PathRecords<P: Likelihood> {
    /// The medium they were traced in, lengths in units of the plane's depth.
    pub medium: Medium<P>,
    /// Light that each path represents, as a share of the light emitted.
    pub weight: f64,
    /// The paths that arrived.
    pub paths: Vec<PathRecord<P::Memory>>,
}

/// A path between two levels.
#[derive(Debug, Clone, Copy)]
struct Walker<M> {
    path: Path,
    /// The deepest level or scattering reached.
    reached: f32,
    scatterings: u32,
    memory: M,
}

/// Light by how often it was scattered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scattered {
    /// At least once.
    Once,
    /// At least twice.
    Twice,
}

/// Traces `paths` paths in `medium` that are `scattered` so often. The result does not depend on the number of threads.
///
/// # Errors
/// [`Error::OutOfRange`](crate::Error::OutOfRange) unless sigma_s z is finite and above 0, sigma_a z finite and at least 0, and
/// `paths` between 1 and 2^32; [`Error::Memory`](crate::Error::Memory).
pub fn trace_paths<P: Likelihood>(
    medium: Medium<P>,
    scattered: Scattered,
    paths: u64,
    seed: u64,
) -> Result<PathRecords<P>> {
    let (tau, absorption, phase) = (medium.sigma_s(), medium.sigma_a(), *medium.phase());
    in_range("sigma_s z", tau, tau.is_finite() && tau > 0.0, "finite and above 0")?;
    in_range("sigma_a z", absorption, absorption.is_finite() && absorption >= 0.0, "finite and at least 0")?;
    in_range("paths", paths as f64, (1..=1 << 32).contains(&paths), "between 1 and 2^32")?;
    // Walkers, those that they are copied to, and of each the number it is copied from and its importance.
    let each = 2 * size_of::<Walker<P::Memory>>() + size_of::<usize>() + size_of::<f64>();
    let _memory = reserve(|| format!("{paths} traced paths"), product(&[paths as usize, each]))?;
    let walk = Walk { tau: tau as f32, absorption: absorption as f32, phase, record: phase.recorder() };
    let seeds = Stream::key(seed);
    let key = |stage: u64| Stream::key(seeds.wrapping_add(stage));
    let copies = |importance: &[f64], stage: u64| {
        systematic(importance, paths, Stream::new(key(stage), paths).uniform_f64())
    };

    let mut weight = -(-tau).exp_m1() * (-absorption).exp() / paths as f64;
    let first = |i: u64| {
        let mut stream = Stream::new(key(0), i);
        let share = (i as f64 + stream.uniform_f64()) / paths as f64;
        walk.first_scattering(share, &mut stream)
    };
    let mut walkers: Vec<Walker<P::Memory>> = (0..paths).into_par_iter().map(first).collect();
    if scattered == Scattered::Twice {
        let importance: Vec<f64> = walkers.par_iter().map(|walker| walk.chance(walker)).collect();
        weight *= importance.iter().sum::<f64>() / paths as f64;
        let stage = LEVELS + 1;
        let again = |(i, from): (usize, usize)| {
            walk.next_scattering(walkers[from], importance[from], &mut Stream::new(key(stage), i as u64))
        };
        walkers = copies(&importance, stage).into_par_iter().enumerate().map(again).collect();
    }
    for level in 1..=LEVELS {
        let depth = level as f32 / LEVELS as f32;
        let onward = |(i, from): (usize, usize)| {
            walk.to_level(walkers[from], depth, &mut Stream::new(key(level), i as u64))
        };
        let set_out = copies(&vec![1.0; walkers.len()], level);
        let arrived: Vec<_> = set_out.into_par_iter().enumerate().filter_map(onward).collect();
        if level < LEVELS {
            weight *= arrived.len() as f64 / paths as f64;
        }
        walkers = arrived;
        if walkers.is_empty() {
            break;
        }
    }
    Ok(PathRecords { medium, weight, paths: walkers.iter().map(Walker::record).collect() })
}

/// For each of `paths` copies, the index of the walker that it is a copy of. A walker has as many copies as its importance
/// relative to the mean, rounded up or down according to `offset`, between 0 and 1.
fn systematic(importance: &[f64], paths: u64, offset: f64) -> Vec<usize> {
    let step = importance.iter().sum::<f64>() / paths as f64;
    let (mut from, mut up_to) = (0, importance[0]);
    let copy = |i: u64| {
        while up_to <= (i as f64 + offset) * step && from + 1 < importance.len() {
            from += 1;
            up_to += importance[from];
        }
        from
    };
    (0..paths).map(copy).collect()
}

/// The medium in the precision of the paths.
struct Walk<P, R> {
    tau: f32,
    absorption: f32,
    phase: P,
    record: R,
}

impl<P: Likelihood, R: Fn(f32, &mut P::Memory)> Walk<P, R> {
    /// A path just after its first scattering, at the depth before which the `share` of all paths scatter.
    fn first_scattering(&self, share: f64, stream: &mut Stream) -> Walker<P::Memory> {
        // The inverse of (1 - exp(-tau t))/(1 - exp(-tau)).
        let scattered = share * (-f64::from(self.tau)).exp_m1();
        let depth = (-scattered.ln_1p() / f64::from(self.tau)) as f32;
        let mut path = Path::new(Vec3::ZERO, Vec3::Z);
        path.advance(depth);
        let mut walker = Walker { path, reached: depth, scatterings: 0, memory: P::Memory::default() };
        self.scatter(&mut walker, stream);
        walker
    }

    /// Absorption of the excess length per length in the direction of `path`.
    fn absorbed(&self, path: &Path) -> f32 {
        self.absorption * (1.0 - path.direction.z)
    }

    /// Probability that a path is scattered before it is absorbed or leaves the layer.
    fn chance(&self, walker: &Walker<P::Memory>) -> f64 {
        let Path { position, direction, .. } = walker.path;
        let way =
            if direction.z > 0.0 { (1.0 - position.z) / direction.z } else { position.z / -direction.z };
        let rate = self.tau + self.absorbed(&walker.path);
        -f64::from(self.tau / rate) * (-f64::from(rate * way)).exp_m1()
    }

    /// A path after its next scattering in the layer, whose `chance` is its importance.
    fn next_scattering(
        &self,
        mut walker: Walker<P::Memory>,
        chance: f64,
        stream: &mut Stream,
    ) -> Walker<P::Memory> {
        let rate = self.tau + self.absorbed(&walker.path);
        let scattered = stream.uniform_f64() * chance * f64::from(rate / self.tau);
        walker.path.advance((-(-scattered).ln_1p()) as f32 / rate);
        walker.reached = walker.reached.max(walker.path.position.z);
        self.scatter(&mut walker, stream);
        walker
    }

    fn scatter(&self, walker: &mut Walker<P::Memory>, stream: &mut Stream) {
        let angle = walker.path.scatter(&self.phase, stream);
        walker.scatterings += 1;
        (self.record)(angle, &mut walker.memory);
    }

    /// Follows a path to its first crossing of `level`; `None` if it leaves through the front surface or is absorbed.
    fn to_level(
        &self,
        mut walker: Walker<P::Memory>,
        level: f32,
        stream: &mut Stream,
    ) -> Option<Walker<P::Memory>> {
        while walker.reached < level {
            let Path { position, direction, .. } = walker.path;
            let absorbed = self.absorbed(&walker.path);
            let rate = self.tau + absorbed;
            let step = free_path(rate, stream);
            let end = position.z + step * direction.z;
            if end >= level {
                walker.path.advance((level - position.z) / direction.z);
                walker.path.position.z = level;
                walker.reached = level;
            } else if end < 0.0 || absorbed > 0.0 && stream.uniform() * rate < absorbed {
                return None;
            } else {
                walker.path.advance(step);
                self.scatter(&mut walker, stream);
            }
        }
        Some(walker)
    }
}

impl<M: Copy> Walker<M> {
    fn record(&self) -> PathRecord<M> {
        let Path { position, direction, length } = self.path;
        let radius = position.x.hypot(position.y);
        let along = position.x * direction.x + position.y * direction.y;
        let slope = if radius > 0.0 { along / (radius * direction.z) } else { 0.0 };
        PathRecord { scatterings: self.scatterings, memory: self.memory, length, radius, slope }
    }
}
