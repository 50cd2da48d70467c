//! What was observed: one channel of one scene, its pixels that count, and what enters it linearly.

mod exposure;
mod huber;
mod object_noise;
mod observed;
mod pixel_noise;
mod registration;
mod smooth;
mod weigh;
pub mod white_noise;

pub(super) use exposure::{Linear, LinearTerm};
pub(super) use observed::{Levels, Observed, Unseen};
pub(super) use registration::{Aligned, Alignment};
pub(super) use weigh::Fitted;

use crate::filter::Target;
use crate::forward::Exposure;
use crate::image::Image;
use crate::imaging::{Blur, GainField, Imaging, Places, Registration, VeilField};
use crate::scene::{Gain, HIDDEN_SHARE_MAX, Loss};

/// The veil of one channel, in units of the observation.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum VeilTerm<'a> {
    /// A known number.
    Fixed(f64),
    /// A known image, of the view's size.
    Image(&'a Image),
    /// Fitted.
    Free(VeilField),
}

impl VeilTerm<'_> {
    /// How many numbers of it are fitted.
    pub(super) fn free_terms(&self) -> usize {
        if let Self::Free(field) = self { field.terms() } else { 0 }
    }
}

/// The noise of one channel.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum NoiseTerm<'a> {
    /// One standard deviation for all pixels.
    Level(f64),
    /// That of a sensor: variance `read`² + `shot`² times the signal.
    Sensor {
        /// Standard deviation without light, above 0.
        read: f64,
        /// Standard deviation at the signal 1 without the former.
        shot: f64,
    },
    /// The variance of each pixel, an image of the view's size, above 0 where a pixel counts.
    Variance(&'a Image),
}

/// One channel of one scene, with what was seen of it.
#[derive(Debug, Clone, Copy)]
pub struct Observation<'a> {
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
    /// The noise of the object image, if it has some; a variance is an image of its size.
    pub object_noise: Option<NoiseTerm<'a>>,
    /// Exposure.
    pub gain: Gain,
    /// Relative standard error of a gain that is given.
    pub gain_error: f64,
    /// Relative standard error of all depths together.
    pub depth_error: f64,
    /// Veil.
    pub veil: VeilTerm<'a>,
    /// How the observed image is registered on the clear one.
    pub registration: Registration,
    /// Its blur beyond that of the clear image.
    pub blur: Blur,
    /// How its gain varies.
    pub gain_field: GainField,
    /// Whether the object's sampling is known; if not, that is part of the model's error.
    pub sampling_is_known: bool,
    /// What large residuals count.
    pub loss: Loss,
    /// Pixels that the mask excludes because they are saturated.
    pub saturated_pixels: usize,
}

impl<'a> Observation<'a> {
    /// `target` seen as `observed`: gain 1, no veil, noise not known, all pixels count, registered already.
    pub fn plain(target: Target<'a>, observed: &'a Image) -> Self {
        Self {
            target,
            observed,
            mask: None,
            hidden_share_max: HIDDEN_SHARE_MAX,
            noise: None,
            object_noise: None,
            gain: Gain::Fixed(1.0),
            gain_error: 0.0,
            depth_error: 0.0,
            veil: VeilTerm::Fixed(0.0),
            registration: Registration::None,
            blur: Blur::default(),
            gain_field: GainField::None,
            sampling_is_known: true,
            loss: Loss::Gaussian,
            saturated_pixels: 0,
        }
    }

    /// What its camera does to the light beside a shift, as far as it is not fitted; `None` if nothing.
    pub(super) fn imaging(&self) -> Option<Imaging> {
        Imaging::new(self.registration, self.blur, self.gain_field)
    }

    /// Places in the view.
    pub(super) fn places(&self) -> Places {
        Places { width: self.observed.width, height: self.observed.height }
    }

    /// Whether the pixel `index` of the view is not masked.
    pub(super) fn is_unmasked(&self, index: usize) -> bool {
        self.mask.is_none_or(|mask| mask.data[index] > 0.0)
    }

    /// The image as observed: gain · `image` + veil.
    pub(super) fn exposed(&self, mut image: Image, exposure: Exposure) -> Image {
        let gain = exposure.gain as f32;
        let places = self.places();
        for (i, v) in image.data.iter_mut().enumerate() {
            let veil = match self.veil {
                VeilTerm::Fixed(veil) => veil as f32,
                VeilTerm::Image(veil) => veil.data[i],
                VeilTerm::Free(_) => exposure.veil.at(places, i) as f32,
            };
            *v = gain * *v + veil;
        }
        image
    }

    /// How many of gain and veil are free.
    pub(super) fn free_exposure(&self) -> usize {
        usize::from(self.gain == Gain::Free) + self.veil.free_terms()
    }
}
