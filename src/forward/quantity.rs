//! The numbers that an image of a scene depends on.

use crate::filter::Rendering;
use crate::image::Image;
use crate::medium::Medium;
use crate::phase::PhaseFunction;

/// One number that the image depends on, in its own unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// Scattering coefficient, 1/length.
    SigmaS,
    /// Absorption coefficient, 1/length.
    SigmaA,
    /// Parameter of the phase function: B (rad²) or g.
    Phase,
    /// Shift of the observation to the right, px.
    ShiftX,
    /// Shift of the observation downwards, px.
    ShiftY,
}

impl Quantity {
    /// What the medium is made of.
    pub const MEDIUM: [Quantity; 3] = [Quantity::SigmaS, Quantity::SigmaA, Quantity::Phase];
    /// The shift of an observation.
    pub const SHIFT: [Quantity; 2] = [Quantity::ShiftX, Quantity::ShiftY];
}

/// The values of all quantities for one scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// The medium.
    pub medium: Medium,
    /// How far the observation is shifted to the right and downwards, px; `None` if it is not to be registered.
    pub shift_px: Option<[f64; 2]>,
}

impl State {
    /// The value of `quantity`; a shift is 0 where the scene is not to be registered.
    pub fn value(&self, quantity: Quantity) -> f64 {
        let [x, y] = self.shift_px.unwrap_or([0.0; 2]);
        match quantity {
            Quantity::SigmaS => self.medium.sigma_s(),
            Quantity::SigmaA => self.medium.sigma_a(),
            Quantity::Phase => self.medium.phase().parameter(),
            Quantity::ShiftX => x,
            Quantity::ShiftY => y,
        }
    }
}

impl From<Medium> for State {
    /// The state of a scene that is not to be registered.
    fn from(medium: Medium) -> Self {
        Self { medium, shift_px: None }
    }
}

/// The derivatives of a render, each with what it is taken in.
pub(crate) fn derivatives(rendering: &Rendering) -> Vec<(Quantity, &Image)> {
    let of_medium = rendering.gradient.iter().flat_map(|images| Quantity::MEDIUM.into_iter().zip(images));
    let of_shift = rendering.motion.iter().flat_map(|images| Quantity::SHIFT.into_iter().zip(images));
    of_medium.chain(of_shift).collect()
}
