//! An image of a scene and its derivatives.

use super::quantity::Quantity;
use crate::filter;
use crate::image::Image;

/// An image over the view with any number of derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendering {
    /// The object's light as it is seen.
    pub image: Image,
    /// Its derivatives, each with what it is taken in.
    pub derivatives: Vec<(Quantity, Image)>,
}

impl Rendering {
    /// An image whose derivatives were not asked for.
    pub fn level(image: Image) -> Self {
        Self { image, derivatives: Vec::new() }
    }

    /// An image with its derivatives in [`Quantity::MEDIUM`].
    pub fn of_medium(image: Image, gradient: [Image; 3]) -> Self {
        Self { image, derivatives: Quantity::MEDIUM.into_iter().zip(gradient).collect() }
    }

    /// The derivative in `quantity`, if it was asked for.
    pub fn derivative(&self, quantity: Quantity) -> Option<&Image> {
        self.derivatives.iter().find(|(of, _)| *of == quantity).map(|(_, image)| image)
    }

    /// `f` of the pixels of two renders, and of those of each derivative that both have.
    pub(super) fn combined(&self, other: &Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let image = |a: &Image, b: &Image| Image {
            data: a.data.iter().zip(&b.data).map(|(&a, &b)| f(a, b)).collect(),
            ..*a
        };
        let derivative =
            |(quantity, a): &(Quantity, Image)| Some((*quantity, image(a, other.derivative(*quantity)?)));
        Self {
            image: image(&self.image, &other.image),
            derivatives: self.derivatives.iter().filter_map(derivative).collect(),
        }
    }
}

impl From<filter::Rendering> for Rendering {
    fn from(filtered: filter::Rendering) -> Self {
        let of_medium =
            filtered.gradient.into_iter().flat_map(|images| Quantity::MEDIUM.into_iter().zip(images));
        let of_shift = filtered.motion.into_iter().flat_map(|images| Quantity::SHIFT.into_iter().zip(images));
        Self { image: filtered.image, derivatives: of_medium.chain(of_shift).collect() }
    }
}
