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

use super::{Gaussian, HenyeyGreenstein, PhaseFunction};
use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// A family of phase functions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum Family {
    /// [`Gaussian`], of width B.
    #[default]
    Gaussian,
    /// [`HenyeyGreenstein`], of mean cosine g.
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

    /// Whether there is a phase function of this parameter, even if it is wider than [`phase`](Self::phase) takes.
    pub fn allows(self, parameter: f64) -> bool {
        match self {
            Family::Gaussian => parameter.is_finite() && parameter > 0.0,
            Family::HenyeyGreenstein => parameter > 0.0 && parameter < 1.0,
        }
    }

    /// What [`allows`](Self::allows) asks, in words.
    pub fn allowed(self) -> &'static str {
        match self {
            Family::Gaussian => "finite and above 0",
            Family::HenyeyGreenstein => "between 0 and 1, exclusive",
        }
    }

    /// The phase function of this parameter.
    ///
    /// # Errors
    /// As [`Gaussian::new`] and [`HenyeyGreenstein::new`].
    pub fn phase(self, parameter: f64) -> Result<Phase> {
        Ok(match self {
            Family::Gaussian => Phase::Gaussian(Gaussian::new(parameter)?),
            Family::HenyeyGreenstein => Phase::HenyeyGreenstein(HenyeyGreenstein::new(parameter)?),
        })
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

    /// Parameter of the phase function of this [planar width](PhaseFunction::planar_width), rad.
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

/// The phase function of a medium, of either family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// A Gaussian.
    Gaussian(Gaussian),
    /// One of Henyey and Greenstein's.
    HenyeyGreenstein(HenyeyGreenstein),
}

/// Asks the phase function of whichever family.
macro_rules! ask {
    ($either:expr, $phase:ident => $answer:expr) => {
        match $either {
            Phase::Gaussian($phase) => $answer,
            Phase::HenyeyGreenstein($phase) => $answer,
        }
    };
}

impl From<Gaussian> for Phase {
    fn from(phase: Gaussian) -> Self {
        Phase::Gaussian(phase)
    }
}

impl From<HenyeyGreenstein> for Phase {
    fn from(phase: HenyeyGreenstein) -> Self {
        Phase::HenyeyGreenstein(phase)
    }
}

impl PhaseFunction for Phase {
    fn family(&self) -> Family {
        ask!(self, phase => phase.family())
    }

    fn parameter(&self) -> f64 {
        ask!(self, phase => phase.parameter())
    }

    fn eval(&self, cos_theta: f64) -> f64 {
        ask!(self, phase => phase.eval(cos_theta))
    }

    #[inline]
    fn sample(&self, uniform: &mut impl FnMut() -> f32) -> [f32; 4] {
        ask!(self, phase => phase.sample(uniform))
    }

    fn mean_cosine(&self) -> f64 {
        ask!(self, phase => phase.mean_cosine())
    }

    fn planar_transform(&self, q: f64) -> f64 {
        ask!(self, phase => phase.planar_transform(q))
    }

    fn planar_transform_derivative(&self, q: f64) -> f64 {
        ask!(self, phase => phase.planar_transform_derivative(q))
    }

    fn mean_planar_transform(&self, q: f64) -> f64 {
        ask!(self, phase => phase.mean_planar_transform(q))
    }

    fn mean_planar_transform_derivative(&self, q: f64) -> f64 {
        ask!(self, phase => phase.mean_planar_transform_derivative(q))
    }

    fn planar_width(&self) -> f64 {
        ask!(self, phase => phase.planar_width())
    }

    fn planar_width_derivative(&self) -> f64 {
        ask!(self, phase => phase.planar_width_derivative())
    }

    fn planar_second_moment(&self) -> Option<f64> {
        ask!(self, phase => phase.planar_second_moment())
    }

    fn single_scatter_psf(&self, r: f64, z: f64) -> f64 {
        ask!(self, phase => phase.single_scatter_psf(r, z))
    }

    fn single_scatter_encircled(&self, r: f64, z: f64) -> f64 {
        ask!(self, phase => phase.single_scatter_encircled(r, z))
    }
}

impl fmt::Display for Phase {
    /// As pictures are headed: by the spread angle, to a thousandth of a degree, or g.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Phase::Gaussian(phase) => {
                let degrees = (1e3 * phase.spread_angle().to_degrees()).round() / 1e3;
                write!(f, "spread angle {degrees}°")
            }
            Phase::HenyeyGreenstein(phase) => write!(f, "Henyey-Greenstein, g {}", phase.mean_cosine()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_phase_of_either_family_is_the_phase_function_that_it_holds() {
        let bare = HenyeyGreenstein::new(0.9).unwrap();
        let either = Family::HenyeyGreenstein.phase(0.9).unwrap();
        assert_eq!((either.eval(0.3), either.planar_width()), (bare.eval(0.3), bare.planar_width()));
        assert_eq!((either.family(), either.parameter()), (Family::HenyeyGreenstein, 0.9));
        let draw = |phase: &dyn Fn(&mut dyn FnMut() -> f32) -> [f32; 4]| {
            let mut numbers = [0.3_f32, 0.6].into_iter();
            phase(&mut || numbers.next().unwrap())
        };
        assert_eq!(draw(&|u| either.sample(&mut || u())), draw(&|u| bare.sample(&mut || u())));
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
