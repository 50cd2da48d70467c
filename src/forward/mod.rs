//! From parameters to an image, and to what a fit needs of it.
//!
//! A [`ForwardModel`] is one scene as one model sees it. There are three: spread kernels through the depth-dependent filter
//! (`kernels`), the Gram matrix of images that do not depend on the medium (`gram`), and replayed photon paths
//! (`replay`). Fits, renders and studies see the trait only.

#[cfg(feature = "gpu")]
mod device;
mod engine;
mod gram;
mod imaged;
mod kernel_power;
mod kernels;
mod products;
mod quantity;
mod rendering;
mod replay;

pub use engine::{Engine, Parts, Rendered};
pub use gram::GramModel;
pub(crate) use kernel_power::kernel_power;
pub use products::{Exposure, Pixel, Pixels, Products, Veil};
pub use quantity::{Quantity, State};
pub use rendering::Rendering;
pub use replay::{MOST_PATHS, Tracing};

use crate::error::Result;
use crate::filter::Coverage;
use crate::image::Image;

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
