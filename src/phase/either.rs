//! The phase function of a medium, whichever its family.

use super::{Family, Gaussian, HenyeyGreenstein, PhaseFunction};
use crate::error::Result;
use std::fmt;

/// The phase function of a medium, of either family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// A Gaussian.
    Gaussian(Gaussian),
    /// One of Henyey and Greenstein's.
    HenyeyGreenstein(HenyeyGreenstein),
}

impl Family {
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
}

/// Calls the phase function of either family.
macro_rules! delegate {
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
        delegate!(self, phase => phase.family())
    }

    fn parameter(&self) -> f64 {
        delegate!(self, phase => phase.parameter())
    }

    fn eval(&self, cos_theta: f64) -> f64 {
        delegate!(self, phase => phase.eval(cos_theta))
    }

    #[inline]
    fn sample(&self, uniform: &mut impl FnMut() -> f32) -> [f32; 4] {
        delegate!(self, phase => phase.sample(uniform))
    }

    fn mean_cosine(&self) -> f64 {
        delegate!(self, phase => phase.mean_cosine())
    }

    fn planar_transform(&self, q: f64) -> f64 {
        delegate!(self, phase => phase.planar_transform(q))
    }

    fn planar_transform_derivative(&self, q: f64) -> f64 {
        delegate!(self, phase => phase.planar_transform_derivative(q))
    }

    fn mean_planar_transform(&self, q: f64) -> f64 {
        delegate!(self, phase => phase.mean_planar_transform(q))
    }

    fn mean_planar_transform_derivative(&self, q: f64) -> f64 {
        delegate!(self, phase => phase.mean_planar_transform_derivative(q))
    }

    fn planar_width(&self) -> f64 {
        delegate!(self, phase => phase.planar_width())
    }

    fn planar_width_derivative(&self) -> f64 {
        delegate!(self, phase => phase.planar_width_derivative())
    }

    fn planar_second_moment(&self) -> Option<f64> {
        delegate!(self, phase => phase.planar_second_moment())
    }

    fn single_scatter_psf(&self, r: f64, z: f64) -> f64 {
        delegate!(self, phase => phase.single_scatter_psf(r, z))
    }

    fn single_scatter_encircled(&self, r: f64, z: f64) -> f64 {
        delegate!(self, phase => phase.single_scatter_encircled(r, z))
    }
}

impl fmt::Display for Phase {
    /// As in titles of pictures: the spread angle, to a thousandth of a degree, or g.
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
}
