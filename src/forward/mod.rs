//! From parameters to an image, and to what a fit needs of it.
//!
//! A [`ForwardModel`] is one scene as one model sees it. There are three: spread kernels through the depth-dependent filter
//! (`kernels`), the Gram matrix of images that do not depend on the medium (`gram`), and replayed photon paths
//! (`replay`). Fits, renders and studies see the trait only.

#[cfg(feature = "gpu")]
mod device;
mod gram;
mod kernels;
mod products;
mod quantity;
mod replay;

pub use gram::GramModel;
pub use products::{Exposure, Pixel, Pixels, Products};
pub(crate) use quantity::derivatives;
pub use quantity::{Quantity, State};
pub use replay::{MOST_PATHS, Tracing};

use crate::error::Result;
use crate::filter::{Backend, Coverage, Optics, Rendering, Target, hidden_share};
use crate::image::Image;
use crate::medium::Medium;
use crate::spread::Model;
use kernels::Filtered;
use replay::Replayed;

/// One scene as a model sees it.
pub trait ForwardModel {
    /// The object's light through the medium, over the view.
    ///
    /// # Errors
    /// Where the model has no kernels for the medium, or the device fails.
    fn image(&self, state: &State) -> Result<Image>;

    /// The same and its derivatives, in the medium and in what else the state has.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    fn rendering(&self, state: &State) -> Result<Rendering>;

    /// Inner products of the image, its derivatives and the observation over `pixels`.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    fn products(&self, state: &State, pixels: &Pixels) -> Result<Products>;

    /// The same without derivatives, if that is cheaper.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    fn levels(&self, state: &State, pixels: &Pixels) -> Result<Products> {
        self.products(state, pixels)
    }

    /// Takes the pixels that count from now on.
    ///
    /// # Errors
    /// If the device cannot hold them.
    fn observe(&mut self, _pixels: &Pixels) -> Result<()> {
        Ok(())
    }

    /// Forms residuals at this exposure from now on: the nearer to the best one, the less cancels.
    fn refer_to(&self, _exposure: Exposure) {}

    /// How far what was prepared serves this state too.
    ///
    /// # Errors
    /// As [`image`](Self::image).
    fn coverage(&self, state: &State) -> Result<Coverage>;

    /// Where the model may be trusted; `None` if anywhere.
    fn trust(&self) -> Option<&Trust> {
        None
    }

    /// The model's own noise; `None` if it has none.
    fn noise(&self) -> Option<&dyn ModelNoise> {
        None
    }

    /// Real 2-D FFTs of one evaluation with derivatives.
    fn transforms(&self) -> usize {
        0
    }
}

/// The noise of a model that is a sample of paths.
pub trait ModelNoise {
    /// Two images of independent halves of the paths.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    fn halves(&self, state: &State) -> Result<[Image; 2]>;

    /// Number of batches that are independent of each other.
    fn batches(&self) -> usize;

    /// The products of the renders of one batch with those of all others.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    fn batch_products(&self, state: &State, pixels: &Pixels, batch: usize) -> Result<Products>;

    /// Paths traced.
    fn paths(&self) -> u64;

    /// Relative effective sample size: the share of equally weighted paths that would know the light as well.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    fn relative_sample_size(&self, state: &State) -> Result<f64>;
}

/// A neighbourhood of the state that a model was made for.
#[derive(Debug, Clone, PartialEq)]
pub struct Trust {
    /// That state.
    pub origin: State,
    /// How far each quantity may move from it.
    pub radii: Vec<Radius>,
}

/// How far a quantity may move: no farther than either says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radius {
    /// What may move.
    pub quantity: Quantity,
    /// In its own unit, to first order.
    pub linear: f64,
    /// In its coordinate, ln B or ln(1 - g).
    pub logarithmic: f64,
}

/// Paths that are traced to see how long all of them take.
const SAMPLE_PATHS: u64 = 1 << 18;

/// How much farther than the state's shift a prepared model may be shifted, px: a fit starts from a shift known to less.
const SHIFT_MARGIN_PX: f64 = 2.0;

/// What makes forward models: a model, where it runs, and how many paths it traces if it does.
#[derive(Clone, Copy)]
pub struct Engine<'a> {
    /// The spread model.
    pub model: Model,
    /// What renders.
    pub backend: Backend<'a>,
    /// What the model `traced` traces.
    pub tracing: Tracing,
}

impl<'a> Engine<'a> {
    /// The forward model of `target`, scene number `scene`, made for the `state` and kernels up to `headroom` times as wide.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn prepare(
        &self,
        target: Target<'a>,
        state: &State,
        headroom: f64,
        scene: usize,
    ) -> Result<Box<dyn ForwardModel + 'a>> {
        if self.model == Model::Traced {
            return Ok(Box::new(Replayed::new(target, state, self.tracing, scene as u64)?));
        }
        let farthest = state.shift_px.map_or(0.0, |[x, y]| x.abs().max(y.abs()) + SHIFT_MARGIN_PX);
        let optics = self.optics(state.medium);
        let filter = self.backend.prepare_for_shifts(target, &optics, headroom, farthest)?;
        Ok(Box::new(Filtered::new(self.model, filter)))
    }

    /// A rough forward model of `target` with at most `slices` depths and padding for kernels that reach `reach_px` pixels.
    ///
    /// # Errors
    /// If the device cannot hold it.
    pub fn prepare_roughly(
        &self,
        target: Target<'a>,
        slices: usize,
        reach_px: f64,
    ) -> Result<Box<dyn ForwardModel + 'a>> {
        let filter = self.backend.prepare_slices(target, slices, reach_px)?;
        Ok(Box::new(Filtered::new(self.model, filter)))
    }

    /// The share of hidden light of every pixel of `target`'s view; `None` where nothing is hidden. Where the model has no
    /// kernels, those of `small-angle` stand in.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn hidden_share(&self, target: Target<'a>, medium: Medium) -> Result<Option<Image>> {
        let hides = target.relief.is_some_and(|relief| relief.hides());
        hides.then(|| hidden_share(&target, &self.optics(medium), self.backend)).transpose()
    }

    /// An independent image of `target`, scene number `scene`, at `state`. If the model traces, its paths have the shapes of
    /// those of a scene that is nearer by the factor `stretch`, so that both share their noise.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn image(&self, target: Target<'a>, state: &State, scene: usize, stretch: f64) -> Result<Image> {
        if self.model == Model::Traced {
            return replay::render(target, state, self.tracing, (scene as u64, stretch));
        }
        self.prepare(target, state, 1.0, scene)?.image(state)
    }

    /// `target` through `medium`.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn render(&self, target: Target<'a>, medium: Medium) -> Result<Rendered> {
        let state = State::from(medium);
        if self.model == Model::Traced {
            return Ok(Rendered { image: self.image(target, &state, 0, 1.0)?, cut: false });
        }
        let model = self.prepare(target, &state, 1.0, 0)?;
        Ok(Rendered { cut: model.coverage(&state)?.cut, image: model.image(&state)? })
    }

    /// The object's light at `state` and at `others`, and the part of it that is not scattered, of `target`, by a model that has
    /// kernels.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub fn parts(&self, target: Target<'a>, state: &State, others: &[State]) -> Result<Parts> {
        let filter = self.backend.prepare(target, &self.optics(state.medium), 1.0)?;
        let model = Filtered::new(self.model, filter);
        let others = others.iter().map(|other| model.image(other)).collect::<Result<_>>()?;
        Ok(Parts { direct: model.direct(state)?, whole: model.image(state)?, others })
    }

    /// The model `traced` in place of this one.
    pub(crate) fn traced(&self) -> Self {
        Self { model: Model::Traced, ..*self }
    }

    /// Seconds that the paths of a fit of `target` by `traced` take on this machine, its depths being a map: a sample of
    /// them is traced.
    ///
    /// # Errors
    /// As [`ForwardModel::image`].
    pub(crate) fn tracing_seconds(&self, target: Target<'a>, state: &State) -> Result<f64> {
        let tracing = Tracing::new(Some(SAMPLE_PATHS), self.tracing.seed);
        let clock = std::time::Instant::now();
        Self { tracing, ..self.traced() }.image(target, state, 0, 1.0)?;
        let all = replay::surface_paths(self.tracing) as f64;
        Ok(clock.elapsed().as_secs_f64() * all / SAMPLE_PATHS as f64)
    }

    /// The model whose fit says where that of this one begins, if it needs one.
    pub fn pilot(&self) -> Option<Self> {
        (self.model == Model::Traced).then_some(Self { model: Model::SmallAngle, ..*self })
    }

    /// Whether the model renders shifted observations.
    pub fn renders_shifts(&self) -> bool {
        self.model != Model::Traced
    }

    /// The same with so few paths as are enough to seek the medium; `None` if there are none to be saved.
    pub fn scouting(&self) -> Option<Self> {
        (self.model == Model::Traced).then_some(Self { tracing: self.tracing.fewer(), ..*self })
    }

    /// The model with kernels that sees the same light: where noise of few paths would pass for want of information.
    pub fn without_noise(&self) -> Self {
        let model = if self.model == Model::Traced { Model::WideAngle } else { self.model };
        Self { model, ..*self }
    }

    fn optics(&self, medium: Medium) -> Optics {
        Optics { model: self.model, medium }
    }
}

/// A rendered scene.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The object's light through the medium, over the view.
    pub image: Image,
    /// Whether the kernels reach beyond the padding ([`Coverage::cut`]).
    pub cut: bool,
}

/// Light of a scene.
#[derive(Debug, Clone)]
pub struct Parts {
    /// All of it.
    pub whole: Image,
    /// What is not scattered.
    pub direct: Image,
    /// All of it, at other states.
    pub others: Vec<Image>,
}
