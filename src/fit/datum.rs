//! The data of a fit: one channel of one observed scene.

use crate::filter::Target;
use crate::image::Image;
use crate::scene::Gain;

/// The veil of one channel, in units of the observation.
#[derive(Debug, Clone, Copy)]
pub enum VeilTerm<'a> {
    /// A known number.
    Fixed(f64),
    /// A known image, of the view's size.
    Image(&'a Image),
    /// One constant, fitted.
    Free,
}

/// The noise of one channel.
#[derive(Debug, Clone, Copy)]
pub enum NoiseTerm<'a> {
    /// One standard deviation for all pixels.
    Level(f64),
    /// The variance of each pixel, an image of the view's size, above 0 where a pixel counts.
    Variance(&'a Image),
}

/// One channel of one scene, with its observation.
#[derive(Debug, Clone, Copy)]
pub struct Datum<'a> {
    /// The object and its view.
    pub target: Target<'a>,
    /// The observed image, of the view's size.
    pub observed: &'a Image,
    /// Pixels above 0 count.
    pub mask: Option<&'a Image>,
    /// Pixels of which a larger share of the light may be hidden do not count.
    pub hidden_share_max: f64,
    /// The noise of a pixel, if known.
    pub noise: Option<NoiseTerm<'a>>,
    /// Exposure.
    pub gain: Gain,
    /// Relative standard error of a gain that is given.
    pub gain_error: f64,
    /// Relative standard error of all depths together.
    pub depth_error: f64,
    /// Veil.
    pub veil: VeilTerm<'a>,
}

impl Datum<'_> {
    /// How many of gain and veil are free.
    pub(super) fn free_exposure(&self) -> usize {
        usize::from(self.gain == Gain::Free) + usize::from(matches!(self.veil, VeilTerm::Free))
    }
}
