//! What a camera does to the light that reaches it: where it looked, how sharply, with what gain and veil over its field.
//!
//! observed(q) = gain · (1 + gain field(q)) · (G * I)(p(q)) + veil field(q), where I is the light of the object as the clear
//! image's camera would see it, G a Gaussian blur beyond that of the clear image, and p the [`Warp`]. Fields are polynomials
//! of the [place](Places) in the view.

mod fields;
mod warp;

pub use fields::{GAIN_MONOMIALS, MONOMIALS, Places, monomials};
pub use warp::{Bend, Warp, WarpParameter};

/// How the place of an observation on the clear image is sought, each kind with all that those before it have.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Registration {
    /// It is already aligned.
    #[default]
    None,
    /// It is shifted.
    Shift,
    /// It is turned and scaled, too.
    Similarity,
    /// It is stretched and sheared, too.
    Affine,
    /// It is seen from another side, too.
    Homography,
}

impl Registration {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::None, Self::Shift, Self::Similarity, Self::Affine, Self::Homography];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Shift => "shift",
            Self::Similarity => "similarity",
            Self::Affine => "affine",
            Self::Homography => "homography",
        }
    }
}

/// Gaussian blur of an observation beyond that of the clear image.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Blur {
    /// Of this standard deviation, px, at least 0.
    Fixed(f64),
    /// Fitted.
    Free,
}

impl Default for Blur {
    fn default() -> Self {
        Self::Fixed(0.0)
    }
}

/// How the gain varies over the view: 1 + a polynomial that is 0 in the middle.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum GainField {
    /// It does not.
    #[default]
    None,
    /// With the square of the distance from the middle, as by vignetting.
    Radial,
    /// With all terms up to the second order.
    Quadratic,
}

impl GainField {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Radial, Self::Quadratic];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Radial => "radial",
            Self::Quadratic => "quadratic",
        }
    }
}

/// How a free veil varies over the view.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum VeilField {
    /// It does not.
    #[default]
    Constant,
    /// With a slope.
    Linear,
    /// With all terms up to the second order.
    Quadratic,
}

impl VeilField {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Constant, Self::Linear, Self::Quadratic];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear => "linear",
            Self::Quadratic => "quadratic",
        }
    }

    /// Number of its [`monomials`], the first ones.
    pub fn terms(self) -> usize {
        match self {
            Self::Constant => 1,
            Self::Linear => 3,
            Self::Quadratic => MONOMIALS,
        }
    }
}

/// Stated, or left to the fit, which takes the least that the image asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Choice<T> {
    /// Stated.
    Is(T),
    /// Left to the fit.
    Auto,
}

impl<T: Copy + Default> Choice<T> {
    /// What is stated, else the least.
    pub fn least(self) -> T {
        match self {
            Self::Is(stated) => stated,
            Self::Auto => T::default(),
        }
    }

    /// Whether it is left to the fit.
    pub fn is_auto(self) -> bool {
        matches!(self, Self::Auto)
    }
}

/// All that a camera has of these, with values.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Imaging {
    /// How far it registers.
    pub registration: Registration,
    /// Turn, scale and so on about the middle of the view; the shift is not among them.
    pub warp: Warp,
    /// Variance of the blur, px².
    pub blur_px2: f64,
    /// Whether the blur is looked for.
    pub blurs: bool,
    /// Which gain field it has.
    pub gain_field: GainField,
    /// Coefficients of the [`monomials`] of the gain field; the first is 0.
    pub gain_terms: [f64; MONOMIALS],
}

impl Imaging {
    /// Of a camera that registers, blurs and has a gain field like this; `None` if it does nothing beside a shift.
    pub fn new(registration: Registration, blur: Blur, gain_field: GainField) -> Option<Self> {
        let (blurs, blur_px) = match blur {
            Blur::Fixed(px) => (false, px),
            Blur::Free => (true, 0.0),
        };
        let plain =
            registration <= Registration::Shift && !blurs && blur_px == 0.0 && gain_field == GainField::None;
        (!plain).then_some(Self {
            registration,
            blur_px2: blur_px * blur_px,
            blurs,
            gain_field,
            ..Self::default()
        })
    }
}
