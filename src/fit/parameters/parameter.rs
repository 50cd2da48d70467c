//! One parameter: what it is, and its value.

use super::coordinate::Coordinate;
use crate::forward::Quantity;

/// Lower and upper bound.
pub type Bounds = [f64; 2];

/// Whether a fit moves a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Role {
    /// The fit moves it.
    Free,
    /// It is given.
    Fixed,
    /// The model does not have it, and it was not given: its value means nothing.
    Absent,
}

/// What a parameter is.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Descriptor {
    /// Its name, unique in a fit: `sigma_s`, `sigma_a`, `b` or `g` of the medium, `shift_x_px` and so on of a scene.
    pub name: String,
    /// The unit of its value.
    pub unit: &'static str,
    /// What it moves in the forward model.
    pub quantity: Quantity,
    /// The scene that it belongs to; `None` for the medium, which all scenes share.
    pub scene: Option<usize>,
    /// What a solver moves.
    pub coordinate: Coordinate,
    /// Bounds of the value.
    pub bounds: Bounds,
    /// Whether the fit moves it.
    pub role: Role,
    /// A natural change of the coordinate: 1 of a logarithm, 1/z of sigma_a, 1 px of a shift.
    pub scale: f64,
    /// Longest step of the coordinate that a solver takes.
    pub longest_step: f64,
}

/// A parameter and its value.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    descriptor: Descriptor,
    value: f64,
}

impl Parameter {
    pub(super) fn new(descriptor: Descriptor, value: f64) -> Self {
        Self { descriptor, value }
    }

    /// What it is.
    pub fn descriptor(&self) -> &Descriptor {
        &self.descriptor
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.descriptor.name
    }

    /// Its value.
    pub fn value(&self) -> f64 {
        self.value
    }

    /// Bounds of the value.
    pub fn bounds(&self) -> Bounds {
        self.descriptor.bounds
    }

    /// Whether the fit moves it.
    pub fn is_free(&self) -> bool {
        self.descriptor.role == Role::Free
    }

    /// Whether it is none of the model's and was not given either.
    pub fn is_absent(&self) -> bool {
        self.descriptor.role == Role::Absent
    }

    /// Its coordinate.
    pub fn coordinate(&self) -> f64 {
        self.coordinate_of(self.value)
    }

    /// The coordinate at another value.
    pub fn coordinate_of(&self, value: f64) -> f64 {
        self.descriptor.coordinate.of(value)
    }

    /// The value at the coordinate `u`.
    pub fn value_at(&self, u: f64) -> f64 {
        self.descriptor.coordinate.value(u)
    }

    /// d value / d coordinate where it is.
    pub fn slope(&self) -> f64 {
        self.descriptor.coordinate.slope(self.value)
    }

    /// Whether an error of its coordinate is a relative one.
    pub fn is_logarithmic(&self) -> bool {
        self.descriptor.coordinate.is_logarithmic()
    }

    /// A natural change of its coordinate.
    pub fn scale(&self) -> f64 {
        self.descriptor.scale
    }

    /// Bounds of its coordinate, the lower first.
    pub(crate) fn coordinate_bounds(&self) -> Bounds {
        let [low, high] = self.bounds().map(|v| self.coordinate_of(v));
        if low <= high { [low, high] } else { [high, low] }
    }

    /// Sets a free value, moved into its bounds.
    pub(super) fn set(&mut self, value: f64) {
        if self.is_free() {
            let [low, high] = self.bounds();
            self.value = value.clamp(low, high);
        }
    }

    /// Sets the value, even if it is not free.
    pub(super) fn replace(&mut self, value: f64) {
        self.value = value;
    }

    /// Whether it is free and lies on one of its bounds.
    pub fn is_at_bound(&self) -> bool {
        let [low, high] = self.bounds();
        let margin = |bound: f64| 1e-9 * bound.abs();
        self.is_free() && (self.value <= low + margin(low) || self.value >= high - margin(high))
    }
}
