//! The model `traced`: images made of photon paths that were traced for the scene at hand and are replayed for others.
//!
//! Paths are traced once, in a medium near the one sought, and then replayed with the weights of another medium
//! (perturbation Monte Carlo). An evaluation is a sum over the same paths, so the cost is a smooth function with exact
//! derivatives. They serve as long as the relative effective sample size
//! ([`EffectiveSampleSize`](crate::trace::EffectiveSampleSize)) is large enough; then they are traced again.
//!
//! - *A plane seen by parallel rays* has one kernel for all pixels, and paths make that ([`plane`]).
//! - *Depth maps and perspective views* have paths of their own at every pixel, followed to the real surface ([`surface`]).
//!
//! **Noise that is squared is a bias**: of one noisy render least squares would make a fit whose noise is least. So the paths
//! are halved, and every product is that of one half with the other ([`Products::between`]). The cost has no part of the
//! noise, and so neither have chi² and the noise estimated from the residual. What the noise does to the estimate is
//! measured by batches of the paths ([`ModelNoise`]).

mod plane;
mod surface;
mod tracing;

pub use tracing::{MOST_PATHS, Tracing};

use super::products::{Pixels, Products};
use super::quantity::{Quantity, State};
use super::{ForwardModel, ModelNoise, Radius, Rendering, Trust};
use crate::error::{Error, Result};
use crate::filter::{Coverage, Target};
use crate::image::{Image, Sampling};
use crate::medium::Medium;
use crate::phase::{Phase, PhaseFunction};
use crate::trace::{BATCHES, Likelihood};
use plane::Plane;
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// Paths of a plane: its kernel's light per octave of radius is then known to some 0.2 %.
const PLANE_PATHS: u64 = 1 << 20;

/// Share of the paths that must carry the weight for a step to be trusted.
const TRUSTED: f64 = 1.0 / 3.0;
/// Share above which paths count as traced in the medium itself. Of the few paths that seek the medium this is not asked: their noise alone may
/// lead them that far at every turn.
const FRESH: f64 = 0.9;

/// Paths that render a scene, all or some batches of them.
trait Paths {
    /// The image and its derivatives by some of the [`BATCHES`].
    fn render(&self, medium: &Medium, batches: Range<usize>) -> Result<Rendering>;

    /// Relative effective sample size in `medium`.
    fn relative_sample_size(&self, medium: &Medium) -> Result<f64>;

    /// What a path knows of sigma_s, sigma_a and the phase-function parameter.
    fn information(&self) -> [f64; 3];

    /// How far ln B or ln(1 - g) may move.
    fn farthest(&self) -> f64;

    /// Paths traced.
    fn count(&self) -> u64;
}

/// A state, and what both halves of the paths rendered there.
struct Latest {
    state: State,
    halves: Rc<[Rendering; 2]>,
}

/// Paths that `tracing` traces for a depth map or a perspective view.
pub(super) fn surface_paths(tracing: Tracing) -> u64 {
    tracing.count(surface::SURFACE_PATHS)
}

/// A scene with its paths.
pub(super) struct Replayed<'a> {
    paths: Box<dyn Paths + 'a>,
    trust: Trust,
    /// Relative effective sample size that is asked for where the fit ends.
    enough: f64,
    latest: RefCell<Option<Latest>>,
}

impl<'a> Replayed<'a> {
    /// Traces the paths of scene number `scene` at `state`.
    pub(super) fn new(target: Target<'a>, state: &State, tracing: Tracing, scene: u64) -> Result<Self> {
        if state.shift_px.is_some() {
            return Err(Error::NotShifted);
        }
        let paths = trace(target, &state.medium, tracing, scene)?;
        // The share falls like exp(-u·F u), F the information; each of three coordinates may use a third of that.
        let linear = paths.information().map(|information| (-TRUSTED.ln() / 3.0 / information).sqrt());
        let radius = |(quantity, linear): (Quantity, f64)| {
            let logarithmic = if quantity == Quantity::Phase { paths.farthest() } else { f64::INFINITY };
            Radius { quantity, linear, logarithmic }
        };
        let radii = Quantity::MEDIUM.into_iter().zip(linear).map(radius).collect();
        let enough = if tracing.are_few() { TRUSTED } else { FRESH };
        let trust = Trust { origin: *state, radii };
        Ok(Self { paths, trust, enough, latest: RefCell::new(None) })
    }

    fn rendered(&self, state: &State) -> Result<Rc<[Rendering; 2]>> {
        if let Some(latest) = &*self.latest.borrow()
            && latest.state == *state
        {
            return Ok(Rc::clone(&latest.halves));
        }
        let half = BATCHES / 2;
        let of = |batches| self.paths.render(&state.medium, batches);
        let halves = Rc::new([of(0..half)?, of(half..BATCHES)?]);
        *self.latest.borrow_mut() = Some(Latest { state: *state, halves: Rc::clone(&halves) });
        Ok(halves)
    }

    fn mean(&self, state: &State) -> Result<Rendering> {
        let halves = self.rendered(state)?;
        Ok(halves[0].combined(&halves[1], |a, b| 0.5 * (a + b)))
    }
}

impl ForwardModel for Replayed<'_> {
    fn image(&self, state: &State) -> Result<Image> {
        Ok(self.mean(state)?.image)
    }

    fn rendering(&self, state: &State) -> Result<Rendering> {
        self.mean(state)
    }

    fn products(&self, state: &State, pixels: &Pixels) -> Result<Products> {
        let halves = self.rendered(state)?;
        Ok(Products::between(pixels, [&halves[0], &halves[1]]))
    }

    fn coverage(&self, state: &State) -> Result<Coverage> {
        Ok(Coverage { served: self.relative_sample_size(state)? >= self.enough, cut: false })
    }

    fn trust(&self) -> Option<&Trust> {
        Some(&self.trust)
    }

    fn noise(&self) -> Option<&dyn ModelNoise> {
        Some(self)
    }
}

impl ModelNoise for Replayed<'_> {
    fn halves(&self, state: &State) -> Result<[Image; 2]> {
        Ok(self.rendered(state)?.each_ref().map(|half| half.image.clone()))
    }

    fn batches(&self) -> usize {
        BATCHES
    }

    fn batch_products(&self, state: &State, pixels: &Pixels, batch: usize) -> Result<Products> {
        let one = self.paths.render(&state.medium, batch..batch + 1)?;
        let all = self.mean(state)?;
        let n = BATCHES as f32;
        let others = all.combined(&one, |all, one| (n * all - one) / (n - 1.0));
        Ok(Products::between(pixels, [&one, &others]))
    }

    fn paths(&self) -> u64 {
        self.paths.count()
    }

    fn relative_sample_size(&self, state: &State) -> Result<f64> {
        self.paths.relative_sample_size(&state.medium)
    }
}

/// `target` at `state`, by paths traced for it: scene number `scene`, traced in a medium that is thinner by the factor
/// `stretch`, and replayed. So a scene and another that is deeper by that factor are seen by paths of the same shapes, whose
/// noise they share.
pub(super) fn render(
    target: Target,
    state: &State,
    tracing: Tracing,
    (scene, stretch): (u64, f64),
) -> Result<Image> {
    let medium = &state.medium;
    let thinner = Medium::new(medium.sigma_s() / stretch, medium.sigma_a() / stretch, *medium.phase())?;
    Ok(trace(target, &thinner, tracing, scene)?.render(medium, 0..BATCHES)?.image)
}

/// Traces the paths of scene number `scene`.
fn trace<'a>(
    target: Target<'a>,
    medium: &Medium,
    tracing: Tracing,
    scene: u64,
) -> Result<Box<dyn Paths + 'a>> {
    match *medium.phase() {
        Phase::Gaussian(phase) => trace_in(target, &medium.with_phase(phase), tracing, scene),
        Phase::HenyeyGreenstein(phase) => trace_in(target, &medium.with_phase(phase), tracing, scene),
    }
}

fn trace_in<'a, P: Likelihood + 'static>(
    target: Target<'a>,
    medium: &Medium<P>,
    tracing: Tracing,
    scene: u64,
) -> Result<Box<dyn Paths + 'a>> {
    // The golden ratio's fraction: whoever counts seeds does not meet another scene's.
    let seed = tracing.seed.wrapping_add(scene.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    if let Some(plane) = Plane::of(target)? {
        return Ok(Box::new(plane.traced(*medium, tracing.count(PLANE_PATHS), seed)?));
    }
    if target.sampling == Sampling::Bandlimited {
        return Err(Error::NotBandlimited);
    }
    Ok(Box::new(surface::traced(target, medium, tracing, seed)?))
}

/// `medium`, whose phase function is of the family of `P`.
fn of_family<P: Likelihood>(medium: &Medium) -> Result<Medium<P>> {
    Ok(medium.with_phase(P::of_parameter(medium.phase().parameter())?))
}
