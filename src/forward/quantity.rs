//! The numbers that an image of a scene depends on.

use crate::imaging::{GAIN_MONOMIALS, GainField, Imaging, Registration, WarpParameter};
use crate::medium::Medium;
use crate::phase::PhaseFunction;

/// Monomials whose sum is the square of the distance from the middle.
const RADIAL: [usize; 2] = [3, 5];

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
    /// Turn, scale and so on of the observation.
    Warp(WarpParameter),
    /// Variance of the observation's blur beyond that of the clear image, px².
    Blur,
    /// Gain lost or won with the square of the distance from the middle, in half diagonals.
    GainRadial,
    /// Coefficient of this [monomial](crate::imaging::monomials) of the gain field.
    GainTerm(usize),
}

impl Quantity {
    /// What the medium is made of.
    pub const MEDIUM: [Quantity; 3] = [Quantity::SigmaS, Quantity::SigmaA, Quantity::Phase];
    /// The shift of an observation.
    pub const SHIFT: [Quantity; 2] = [Quantity::ShiftX, Quantity::ShiftY];

    /// Its value in `imaging`; 0 for what is none of it.
    pub fn in_imaging(self, imaging: &Imaging) -> f64 {
        match self {
            Self::Warp(parameter) => imaging.warp.get(parameter),
            Self::Blur => imaging.blur_px2,
            Self::GainRadial => imaging.gain_terms[RADIAL[0]],
            Self::GainTerm(term) => imaging.gain_terms[term],
            _ => 0.0,
        }
    }

    /// Sets it in `imaging`, if it is a part of that.
    pub fn set_in_imaging(self, imaging: &mut Imaging, value: f64) {
        match self {
            Self::Warp(parameter) => imaging.warp = imaging.warp.with(parameter, value),
            Self::Blur => imaging.blur_px2 = value,
            Self::GainRadial => RADIAL.into_iter().for_each(|term| imaging.gain_terms[term] = value),
            Self::GainTerm(term) => imaging.gain_terms[term] = value,
            _ => (),
        }
    }

    /// What is looked for of `imaging`.
    pub fn of_imaging(imaging: &Imaging) -> Vec<Quantity> {
        let warp = match imaging.registration {
            Registration::Similarity => &WarpParameter::ALL[..2],
            Registration::Affine => &WarpParameter::ALL[..4],
            Registration::Homography => &WarpParameter::ALL[..],
            _ => &[],
        };
        let gain: Vec<Quantity> = match imaging.gain_field {
            GainField::Radial => vec![Quantity::GainRadial],
            GainField::Quadratic => GAIN_MONOMIALS.map(Quantity::GainTerm).collect(),
            _ => Vec::new(),
        };
        let blur = imaging.blurs.then_some(Quantity::Blur);
        warp.iter().map(|parameter| Quantity::Warp(*parameter)).chain(blur).chain(gain).collect()
    }
}

/// The values of all quantities for one scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State {
    /// The medium.
    pub medium: Medium,
    /// How far the observation is shifted to the right and downwards, px; `None` if it is not to be registered.
    pub shift_px: Option<[f64; 2]>,
    /// What else the camera does to the light; `None` if nothing.
    pub imaging: Option<Imaging>,
}

impl State {
    /// The value of `quantity`; 0 for what the camera does not have.
    pub fn value(&self, quantity: Quantity) -> f64 {
        let [x, y] = self.shift_px.unwrap_or([0.0; 2]);
        match quantity {
            Quantity::SigmaS => self.medium.sigma_s(),
            Quantity::SigmaA => self.medium.sigma_a(),
            Quantity::Phase => self.medium.phase().parameter(),
            Quantity::ShiftX => x,
            Quantity::ShiftY => y,
            _ => self.imaging.map_or(0.0, |imaging| quantity.in_imaging(&imaging)),
        }
    }

    /// The same without what the camera does beside a shift.
    pub(super) fn without_imaging(&self) -> Self {
        Self { imaging: None, ..*self }
    }
}

impl From<Medium> for State {
    /// The state of a scene that is not to be registered.
    fn from(medium: Medium) -> Self {
        Self { medium, shift_px: None, imaging: None }
    }
}
