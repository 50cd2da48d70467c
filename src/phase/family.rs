//! Families of phase functions with one parameter: what a scene names, and whose parameter a fit estimates.
//!
//! | family | parameter | coordinate of a fit | planar width | mean-square scattering angle |
//! | --- | --- | --- | --- | --- |
//! | `gaussian` | B, rad² | ln B | sqrt(B) | 4B |
//! | `hg` | g | ln(1 - g) | a = (1-g)/sqrt(g) | 2(1 - g) |
//!
//! The coordinates have no bounds of their own, and in both a standard error is a relative one: of B, or of the
//! angular width, which is nearly 1 - g. The *mean-square scattering angle* is that of one deflection to lowest order in the
//! angle, twice the mean of 1 - cos theta: 4B for a narrow Gaussian. Unlike the planar second moment it is finite for both.

use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// A family of phase functions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Family {
    /// [`Gaussian`](super::Gaussian), of width B.
    #[default]
    Gaussian,
    /// [`HenyeyGreenstein`](super::HenyeyGreenstein), of mean cosine g.
    HenyeyGreenstein,
}

impl Family {
    /// All families.
    pub const ALL: [Family; 2] = [Family::Gaussian, Family::HenyeyGreenstein];

    /// Name in scene files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Family::Gaussian => "gaussian",
            Family::HenyeyGreenstein => "hg",
        }
    }

    /// Name of the parameter in scene files, on the command line and in reports.
    pub const fn parameter_name(self) -> &'static str {
        match self {
            Family::Gaussian => "b",
            Family::HenyeyGreenstein => "g",
        }
    }

    /// Unit of the parameter.
    pub fn unit(self) -> &'static str {
        match self {
            Family::Gaussian => "rad²",
            Family::HenyeyGreenstein => "",
        }
    }

    /// Whether there is a phase function of this parameter, even if it is wider than [`phase`](Self::phase) accepts.
    pub fn allows(self, parameter: f64) -> bool {
        match self {
            Family::Gaussian => parameter.is_finite() && parameter > 0.0,
            Family::HenyeyGreenstein => parameter > 0.0 && parameter < 1.0,
        }
    }

    /// What [`allows`](Self::allows) requires, in words.
    pub fn allowed(self) -> &'static str {
        match self {
            Family::Gaussian => "finite and above 0",
            Family::HenyeyGreenstein => "between 0 and 1, exclusive",
        }
    }

    /// Coordinate of a parameter: ln B, ln(1 - g).
    pub fn coordinate(self, parameter: f64) -> f64 {
        match self {
            Family::Gaussian => parameter.ln(),
            Family::HenyeyGreenstein => (-parameter).ln_1p(),
        }
    }

    /// Parameter at a coordinate.
    pub fn parameter_at(self, coordinate: f64) -> f64 {
        match self {
            Family::Gaussian => coordinate.exp(),
            Family::HenyeyGreenstein => -coordinate.exp_m1(),
        }
    }

    /// Derivative of the parameter in its coordinate.
    pub fn slope(self, parameter: f64) -> f64 {
        match self {
            Family::Gaussian => parameter,
            Family::HenyeyGreenstein => parameter - 1.0,
        }
    }

    /// Parameter of the phase function of this [planar width](super::PhaseFunction::planar_width), rad.
    pub fn of_width(self, width: f64) -> f64 {
        match self {
            Family::Gaussian => width * width,
            // The root of g + width sqrt(g) - 1.
            Family::HenyeyGreenstein => (0.5 * (width.hypot(2.0) - width)).powi(2),
        }
    }

    /// Mean-square scattering angle of a parameter, rad².
    pub fn mean_square_angle(self, parameter: f64) -> f64 {
        match self {
            Family::Gaussian => 4.0 * parameter,
            Family::HenyeyGreenstein => 2.0 * (1.0 - parameter),
        }
    }

    /// Formula of the mean-square scattering angle.
    pub fn mean_square_angle_formula(self) -> &'static str {
        match self {
            Family::Gaussian => "4B",
            Family::HenyeyGreenstein => "2(1-g)",
        }
    }
}

impl fmt::Display for Family {
    /// In words: Gaussian, Henyey-Greenstein.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Family::Gaussian => "Gaussian",
            Family::HenyeyGreenstein => "Henyey-Greenstein",
        })
    }
}

impl FromStr for Family {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Family::ALL.into_iter().find(|f| f.name() == name).ok_or_else(|| Error::UnknownName {
            what: "phase function",
            name: name.into(),
            known: Family::ALL.map(Family::name).join(", "),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::PhaseFunction;

    #[test]
    fn coordinates_lead_to_parameters_and_back() {
        for (family, parameters) in
            [(Family::Gaussian, [1e-6, 0.01, 0.3]), (Family::HenyeyGreenstein, [0.3, 0.9, 0.9999])]
        {
            for parameter in parameters {
                let u = family.coordinate(parameter);
                assert!((family.parameter_at(u) / parameter - 1.0).abs() < 1e-12, "{family} {parameter}");
                let difference = (family.parameter_at(u + 1e-5) - family.parameter_at(u - 1e-5)) / 2e-5;
                assert!((family.slope(parameter) / difference - 1.0).abs() < 1e-6, "{family} {parameter}");
                let width = family.phase(parameter).unwrap().planar_width();
                assert!((family.of_width(width) / parameter - 1.0).abs() < 1e-12, "{family} {parameter}");
            }
        }
    }

    #[test]
    fn mean_square_angles_are_twice_what_the_mean_cosine_lacks() {
        for (family, parameter) in [(Family::Gaussian, 1e-4), (Family::HenyeyGreenstein, 0.8)] {
            let lacking = 1.0 - family.phase(parameter).unwrap().mean_cosine();
            // Of the Gaussian to first order in B.
            assert!((family.mean_square_angle(parameter) / (2.0 * lacking) - 1.0).abs() < 1e-3, "{family}");
        }
    }

    #[test]
    fn names_are_read_back_and_others_refused_with_those_known() {
        for family in Family::ALL {
            assert_eq!(family.name().parse::<Family>().unwrap(), family);
        }
        let message = "mie".parse::<Family>().unwrap_err().to_string();
        assert_eq!(message, "unknown phase function mie; known are gaussian, hg");
    }
}
