//! The model `traced`: renders made of paths that were traced for the scene at hand.
//!
//! Paths are traced once, in a medium near the one sought, and then reweighted: an evaluation is a sum over the same paths
//! (common random numbers), so the cost is a smooth function with exact derivatives. They serve as long as enough of them
//! carry the weight ([`Effective`](crate::trace::Effective)); then they are traced anew.
//!
//! - *A plane seen by parallel rays* has one kernel for all pixels, and paths make that ([`plane`]).
//! - *Depth maps and perspective views* have paths of their own at every pixel, followed to the real surface
//!   ([`Hits`]): edges, slopes and layers are what they are.
//!
//! **Noise that is squared is a bias**: of one noisy render least squares would make a fit whose noise is least. So the paths
//! are halved, and every product is that of a half with the other ([`Products::between`]); the cost has no part of
//! the noise, and so neither have chi² and the noise estimated from the residual. What the noise does to the estimate is
//! measured by batches of the paths (`fit::model_error`).

mod plane;
mod tracing;

pub use tracing::{MOST_PATHS, Tracing};

use super::Settings;
use super::equations::Products;
use super::observed::Observed;
use super::parameters::{Bounds, Parameters};
use super::with_optics;
use crate::error::Result;
use crate::filter::cpu::Rendering;
use crate::filter::{Optics, Target};
use crate::image::Image;
use crate::medium::Medium;
use crate::phase::{Family, Gaussian, HenyeyGreenstein};
use crate::spread::Model;
use crate::trace::{BATCHES, Hits, ImageConfig, Likelihood, Turbid};
use plane::Plane;
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// Paths of a plane: its kernel's light per octave of radius is then known to some .2 %.
const PLANE_PATHS: u64 = 1 << 20;
/// Paths of all pixels of a scene together, 12 to 28 bytes for each that meets light: at 128² px as noisy as an observation of 1 %.
const SURFACE_PATHS: u64 = 1 << 24;
/// What ends a fit whose chi² is not above 0: it is one of the halves' products, and the noise of the paths all that is left of it.
pub(super) const TOO_FEW: &str = "the noise of the traced paths hides the residual: too few paths";
/// The model whose fit says where tracing begins.
pub(super) const PILOT: Model = Model::SmallAngle;

/// Share of the paths that must carry the weight for a step to be trusted.
const TRUSTED: f64 = 1.0 / 3.0;
/// Share above which paths count as traced in the medium itself. Of scouts that is not asked: their noise alone may lead them
/// that far at every turn.
const FRESH: f64 = 0.9;

/// Paths that render a scene, all or some batches of them.
trait Paths {
    /// The image and its derivatives by some of the [`BATCHES`].
    fn render(&self, optics: &Optics, batches: Range<usize>) -> Result<Rendering>;

    /// How well the paths serve `optics`.
    fn effective_share(&self, optics: &Optics) -> Result<f64>;

    /// What a path knows of sigma_s, sigma_a and the lobe's shape, and how far ln B or ln(1 - g) may move.
    fn information(&self) -> ([f64; 3], f64);

    /// Paths traced.
    fn count(&self) -> u64;
}

/// Parameter values, and what both halves of the paths rendered there.
type Latest = ([f64; 3], Rc<[Rendering; 2]>);

/// A scene with its paths.
pub(super) struct Traced<'a> {
    paths: Box<dyn Paths + 'a>,
    /// Coordinates between which a step is trusted.
    pub trust: [Bounds; 3],
    /// Share of the paths that must carry the weight where the fit ends.
    enough: f64,
    latest: RefCell<Option<Latest>>,
}

impl<'a> Traced<'a> {
    /// Traces the paths of scene number `scene` in the medium of `parameters`.
    pub(super) fn new(
        target: Target<'a>,
        parameters: &Parameters,
        settings: &Settings,
        scene: u64,
    ) -> Result<Self> {
        let paths =
            with_optics(parameters, Model::Traced, |optics| trace(target, optics, settings.tracing, scene))?;
        let (information, farthest) = paths.information();
        let (here, chain) = (parameters.internal(), parameters.chain(&parameters.internal()));
        let trust = std::array::from_fn(|i| {
            // The share falls like exp(-u·F u), F the information; each of three coordinates may use a third of that.
            let squared = (-TRUSTED.ln() / 3.0) / (information[i] * chain[i] * chain[i]);
            let most = if i == 2 { farthest } else { f64::INFINITY };
            let step = squared.sqrt().min(most);
            [here[i] - step, here[i] + step]
        });
        let enough = if settings.tracing.are_scouts() { TRUSTED } else { FRESH };
        Ok(Self { paths, trust, enough, latest: RefCell::new(None) })
    }

    /// The sums of a render and its derivatives at `parameters`.
    pub(super) fn products(&self, parameters: &Parameters, observed: &Observed) -> Result<Products> {
        let halves = self.halves(parameters)?;
        Ok(observed.products_between([&halves[0], &halves[1]]))
    }

    /// The products of one batch's renders with those of all others.
    pub(super) fn products_of_batch(
        &self,
        parameters: &Parameters,
        observed: &Observed,
        batch: usize,
    ) -> Result<Products> {
        let one =
            with_optics(parameters, Model::Traced, |optics| self.paths.render(optics, batch..batch + 1))?;
        let all = self.mean(parameters)?;
        let n = BATCHES as f32;
        let others = combined(&all, &one, |all, one| (n * all - one) / (n - 1.0));
        Ok(observed.products_between([&one, &others]))
    }

    /// Both halves of the paths' images.
    pub(super) fn halves(&self, parameters: &Parameters) -> Result<Rc<[Rendering; 2]>> {
        let values = parameters.values();
        if let Some((of, halves)) = &*self.latest.borrow()
            && *of == values
        {
            return Ok(Rc::clone(halves));
        }
        let halves = with_optics(parameters, Model::Traced, |optics| {
            let half = BATCHES / 2;
            Ok(Rc::new([self.paths.render(optics, 0..half)?, self.paths.render(optics, half..BATCHES)?]))
        })?;
        *self.latest.borrow_mut() = Some((values, Rc::clone(&halves)));
        Ok(halves)
    }

    /// The image at `parameters`.
    pub(super) fn image(&self, parameters: &Parameters) -> Result<Image> {
        Ok(self.mean(parameters)?.image)
    }

    fn mean(&self, parameters: &Parameters) -> Result<Rendering> {
        let halves = self.halves(parameters)?;
        Ok(combined(&halves[0], &halves[1], |a, b| 0.5 * (a + b)))
    }

    /// Share of the paths that carry the weight at `parameters`.
    pub(super) fn effective_share(&self, parameters: &Parameters) -> Result<f64> {
        with_optics(parameters, Model::Traced, |optics| self.paths.effective_share(optics))
    }

    /// Whether that is enough, and no step was cut short for lack of trust.
    pub(super) fn serves(&self, parameters: &Parameters) -> Result<bool> {
        let inside = |(u, [low, high]): (f64, Bounds)| {
            let margin = 1e-6 * (high - low);
            margin.is_infinite() || (low + margin..high - margin).contains(&u)
        };
        let whole = parameters.internal().into_iter().zip(self.trust).all(inside);
        Ok(whole && self.effective_share(parameters)? >= self.enough)
    }

    /// Paths traced.
    pub(super) fn count(&self) -> u64 {
        self.paths.count()
    }
}

/// `target` through the medium of `optics`, by paths traced for it.
///
/// # Errors
/// Those of the tracer.
pub fn render_traced(target: Target, optics: &Optics, tracing: Tracing) -> Result<Image> {
    render_stretched(target, optics, tracing, (0, 1.0))
}

/// The same for scene number `scene`, by paths traced in a medium that is thinner by the factor `stretch`, and reweighted. So a
/// scene and another that is deeper by that factor are seen by paths of the same shapes, whose noise they share.
pub(super) fn render_stretched(
    target: Target,
    optics: &Optics,
    tracing: Tracing,
    (scene, stretch): (u64, f64),
) -> Result<Image> {
    let medium = Medium::new(optics.medium.sigma_s() / stretch, optics.medium.sigma_a() / stretch)?;
    let paths = trace(target, &Optics { medium, ..*optics }, tracing, scene)?;
    Ok(paths.render(optics, 0..BATCHES)?.image)
}

/// Traces the paths of scene number `scene`.
fn trace<'a>(
    target: Target<'a>,
    optics: &Optics,
    tracing: Tracing,
    scene: u64,
) -> Result<Box<dyn Paths + 'a>> {
    let shape = optics.phase.shape();
    match optics.phase.family() {
        Family::Gaussian => trace_lobe(target, optics, Gaussian::new(shape)?, tracing, scene),
        Family::HenyeyGreenstein => trace_lobe(target, optics, HenyeyGreenstein::new(shape)?, tracing, scene),
    }
}

fn trace_lobe<'a, P: Likelihood + 'static>(
    target: Target<'a>,
    optics: &Optics,
    phase: P,
    tracing: Tracing,
    scene: u64,
) -> Result<Box<dyn Paths + 'a>> {
    // The golden ratio's fraction: whoever counts seeds does not meet another scene's.
    let seed = tracing.seed.wrapping_add(scene.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let medium = Turbid { sigma_s: optics.medium.sigma_s(), sigma_a: optics.medium.sigma_a(), phase };
    if let Some(plane) = Plane::of(target) {
        return Ok(Box::new(plane.traced(medium, tracing.count(PLANE_PATHS), seed)?));
    }
    let samples = tracing.count(SURFACE_PATHS).div_ceil(target.view.pixels() as u64) as u32;
    let config = ImageConfig {
        geometry: target.geometry,
        radiance: target.radiance,
        behind: target.behind,
        border: target.border,
        view: target.view,
        medium: optics.medium,
        samples: samples.max(2 * BATCHES as u32),
        seed,
    };
    Ok(Box::new(Hits::trace(&config, &phase, &|_| ())?))
}

/// The medium of `optics`, whose lobe is of the family of `P`.
fn turbid<P: Likelihood>(optics: &Optics) -> Result<Turbid<P>> {
    let (sigma_s, sigma_a) = (optics.medium.sigma_s(), optics.medium.sigma_a());
    Ok(Turbid { sigma_s, sigma_a, phase: P::of_shape(optics.phase.shape())? })
}

impl<P: Likelihood> Paths for Hits<P> {
    fn render(&self, optics: &Optics, batches: Range<usize>) -> Result<Rendering> {
        let [image, s, a, shape] = self.image(&turbid(optics)?, batches)?;
        Ok(Rendering { image, gradient: Some([s, a, shape]), motion: None })
    }

    fn effective_share(&self, optics: &Optics) -> Result<f64> {
        Ok(Hits::effective_share(self, &turbid(optics)?))
    }

    fn information(&self) -> ([f64; 3], f64) {
        let [s, _, shape] = Hits::information(self).of_a_path();
        // Absorption takes no part in the drawing of the paths: any serves.
        ([s, 0.0, shape], P::FARTHEST)
    }

    fn count(&self) -> u64 {
        self.paths()
    }
}

/// `f` of the pixels of two renders and of their derivatives.
fn combined(a: &Rendering, b: &Rendering, f: impl Fn(f32, f32) -> f32) -> Rendering {
    let image = |a: &Image, b: &Image| Image {
        data: a.data.iter().zip(&b.data).map(|(&a, &b)| f(a, b)).collect(),
        ..*a
    };
    let gradient = match (&a.gradient, &b.gradient) {
        (Some(a), Some(b)) => Some(std::array::from_fn(|c| image(&a[c], &b[c]))),
        _ => None,
    };
    Rendering { image: image(&a.image, &b.image), gradient, motion: None }
}
