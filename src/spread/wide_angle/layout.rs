//! Where the tables behind `wide-angle` have their nodes, and the widths of the Gaussians in their mixtures.
//!
//! Both families share the axes of tau and sigma_a z. The third is the spread angle D = sqrt(4B) of the Gaussian, in which the
//! kernel is even, and ln(1 - g) of Henyey-Greenstein's phase function, whose kernel has wide angles at any g.

use crate::chebyshev::Chebyshev;
use crate::error::{Result, in_range};
use crate::phase::{Family, b_of_spread_angle};
use crate::spread::{Dual, Range};

/// Width of the narrowest Gaussian in units of the planar width of the phase function times z. A thousandth of the light
/// scattered once falls within it.
const NARROWEST: f64 = 1e-3;
/// Ratio of neighbouring widths: Gaussians so spaced reproduce a smooth mixture to a ripple of 3e-5.
const RATIO: f64 = 1.6;

/// The layout of the table of one family of phase functions.
#[derive(Debug, PartialEq)]
pub struct Layout {
    /// The family.
    pub family: Family,
    /// Number of Gaussians in the mixture.
    pub gaussians: usize,
    /// Nodes of tau, sigma_a z and the width of the phase function.
    pub counts: [usize; 3],
    /// Ends of the third axis, in its coordinate: the narrowest phase function, below which the kernel in units of its
    /// width no longer changes, and the widest.
    ends: (f64, f64),
}

/// A medium at which a table has numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// sigma_s z.
    pub tau: f64,
    /// sigma_a z.
    pub absorption: f64,
    /// Parameter of the phase function, B (rad²) or g.
    pub phase: f64,
    /// Root of the [mean-square scattering angle](Family::mean_square_angle): sqrt(4B) or sqrt(2(1-g)), rad.
    pub angle: f64,
}

/// Spread angles of 0.5 to 60 degrees.
static GAUSSIAN: Layout = Layout {
    family: Family::Gaussian,
    gaussians: 28,
    counts: [10, 8, 14],
    ends: (0.5_f64.to_radians(), 60.0_f64.to_radians()),
};

/// g of 0.998 to 0.5, from ln 0.002 to ln 0.5. A narrower phase function turns less than 0.6 % of the light by more than 20
/// degrees, where its kernel has another form. Four more Gaussians reach as far in units of z.
static HENYEY_GREENSTEIN: Layout = Layout {
    family: Family::HenyeyGreenstein,
    gaussians: 32,
    counts: [10, 8, 16],
    ends: (-6.214_608_098_422_191, -std::f64::consts::LN_2),
};

/// What ln(W/phi) is divided by before it is tabulated at the `angle` of a [`Place`]. Near 0 ln(W/phi) grows like the
/// mean-square scattering angle, so the division keeps noise of thick, wide-angle, absorbing media from spreading to narrow
/// ones. The constant keeps noise of narrow ones small. It also keeps the quotient's poles, at angles of ± i sqrt(0.3), away
/// from the tabulated angles: nearer poles would require more nodes.
pub fn total_scale(angle: f64) -> f64 {
    angle * angle + 0.3
}

/// Width of Gaussian `j` in units of the planar width of the phase function times z.
pub fn relative_width(j: usize) -> f64 {
    NARROWEST * RATIO.powi(j as i32)
}

impl Layout {
    /// tau at the ends of a table; below, where all light is scattered once, the relative distribution no longer changes.
    pub const TAU: (f64, f64) = (1e-6, 12.0);
    /// sigma_a z at the ends of a table.
    pub const ABSORPTION: (f64, f64) = (0.0, 10.0);

    /// The layout for `family`.
    pub fn of(family: Family) -> &'static Self {
        match family {
            Family::Gaussian => &GAUSSIAN,
            Family::HenyeyGreenstein => &HENYEY_GREENSTEIN,
        }
    }

    /// Count of numbers at a node: two logarithms, and the roots of the shares of light and slope.
    pub fn numbers(&self) -> usize {
        2 + 2 * self.gaussians
    }

    /// The axes in the coordinates of the interpolation.
    pub(super) fn axes(&self) -> [Chebyshev; 3] {
        let ends = [
            (Self::TAU.0.sqrt(), Self::TAU.1.sqrt()),
            ((2.0 * Self::ABSORPTION.0).ln_1p(), (2.0 * Self::ABSORPTION.1).ln_1p()),
            self.ends,
        ];
        std::array::from_fn(|i| Chebyshev::new(self.counts[i], ends[i].0, ends[i].1))
    }

    /// The media of all nodes, in the order of the file.
    pub fn places(&self) -> Vec<Place> {
        let [tau, absorption, width] = self.axes();
        let mut places = Vec::new();
        for t in &tau.x {
            for a in &absorption.x {
                places.extend(width.x.iter().map(|&width| {
                    let (phase, angle) = match self.family {
                        Family::Gaussian => (b_of_spread_angle(width), width),
                        Family::HenyeyGreenstein => {
                            let g = self.family.parameter_at(width);
                            (g, self.family.mean_square_angle(g).sqrt())
                        }
                    };
                    Place { tau: t * t, absorption: 0.5 * a.exp_m1(), phase, angle }
                }));
            }
        }
        places
    }

    /// Coordinate of a phase-function parameter on the third axis, and its derivative.
    pub(super) fn place(&self, parameter: f64) -> (f64, f64) {
        let (coordinate, slope) = match self.family {
            Family::Gaussian => ((4.0 * parameter).sqrt(), 1.0 / parameter.sqrt()),
            Family::HenyeyGreenstein => {
                (self.family.coordinate(parameter), 1.0 / self.family.slope(parameter))
            }
        };
        if coordinate > self.ends.0 { (coordinate, slope) } else { (self.ends.0, 0.0) }
    }

    /// By how many octaves of the angle a phase function is narrower than any in the table, and its derivative in the parameter; below 0
    /// for those in it.
    pub(in crate::spread) fn narrower(&self, parameter: f64) -> Dual {
        let (value, slope) = match self.family {
            Family::Gaussian => (self.ends.0.ln() - 0.5 * (4.0 * parameter).ln(), -0.5 / parameter),
            Family::HenyeyGreenstein => {
                let coordinate = self.family.coordinate(parameter);
                (0.5 * (self.ends.0 - coordinate), -0.5 / self.family.slope(parameter))
            }
        };
        let octaves = std::f64::consts::LN_2.recip();
        Dual { value: octaves * value, gradient: [0.0, 0.0, octaves * slope] }
    }

    /// [`total_scale`] at a phase-function parameter.
    pub(super) fn total_scale(&self, parameter: f64) -> Dual {
        let slope = match self.family {
            Family::Gaussian => 4.0,
            Family::HenyeyGreenstein => -2.0,
        };
        let angle = self.family.mean_square_angle(parameter).sqrt();
        Dual { value: total_scale(angle), gradient: [0.0, 0.0, slope] }
    }

    /// Refuses media outside the table.
    pub(super) fn check(&self, tau: f64, absorption: f64, parameter: f64) -> Result<()> {
        for (name, value, end, allowed) in [
            (
                "sigma_s z",
                tau,
                Self::TAU.1,
                "between 0 and 12, where the table of model wide-angle ends (model traced has no end)",
            ),
            (
                "sigma_a z",
                absorption,
                Self::ABSORPTION.1,
                "between 0 and 10, where the table of model wide-angle ends (model traced has no end)",
            ),
        ] {
            in_range(name, value, value >= 0.0 && value <= end * (1.0 + 1e-12), allowed)?;
        }
        match self.family {
            Family::Gaussian => {
                let (degrees, widest) = ((4.0 * parameter).sqrt().to_degrees(), self.ends.1.to_degrees());
                let allowed =
                    "at most 60 degrees, where the table of model wide-angle ends (model traced has no end)";
                in_range("spread angle", degrees, degrees <= widest * (1.0 + 1e-12), allowed)?;
            }
            Family::HenyeyGreenstein => {
                let allowed =
                    "at least 0.5, where the table of model wide-angle ends (model traced has no end)";
                in_range(
                    "g",
                    parameter,
                    parameter >= self.family.parameter_at(self.ends.1) * (1.0 - 1e-12),
                    allowed,
                )?;
            }
        }
        Ok(())
    }

    /// The media for which the table has kernels.
    pub fn range(&self) -> Range {
        let phase = match self.family {
            Family::Gaussian => [0.0, b_of_spread_angle(self.ends.1)],
            Family::HenyeyGreenstein => [self.family.parameter_at(self.ends.1), 1.0],
        };
        Range { tau: Self::TAU.1, absorption: Self::ABSORPTION.1, phase }
    }
}
