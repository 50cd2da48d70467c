//! The coordinates that a solver moves in.

use crate::phase::Family;

/// How a value is mapped to the coordinate that a solver moves.
///
/// Positive quantities of unknown magnitude move in logarithms. Absorption and shifts move as they are, because 0 is a value
/// that they take. The parameter of a phase function moves as its [`Family`] says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Coordinate {
    /// The value itself.
    Linear,
    /// Its natural logarithm.
    Logarithm,
    /// ln B or ln(1 - g).
    Phase(Family),
}

impl Coordinate {
    /// The coordinate of `value`.
    pub fn of(self, value: f64) -> f64 {
        match self {
            Self::Linear => value,
            Self::Logarithm => value.ln(),
            Self::Phase(family) => family.coordinate(value),
        }
    }

    /// The value at the coordinate `u`.
    pub fn value(self, u: f64) -> f64 {
        match self {
            Self::Linear => u,
            Self::Logarithm => u.exp(),
            Self::Phase(family) => family.parameter_at(u),
        }
    }

    /// d value / d coordinate at `value`; below 0 for g, whose coordinate falls.
    pub fn slope(self, value: f64) -> f64 {
        match self {
            Self::Linear => 1.0,
            Self::Logarithm => value,
            Self::Phase(family) => family.slope(value),
        }
    }

    /// Whether an error of the coordinate is a relative one of the value, or of 1 - g.
    pub fn is_logarithmic(self) -> bool {
        self != Self::Linear
    }
}
