//! The spread models: their names, their ranges and their kernels.

use super::SpreadKernel;
use super::beer_lambert::BeerLambert;
use super::moment_matched::{MomentMatched, Moments, Profile, gaussian_width};
use super::range::Range;
use super::single_scatter::SingleScatter;
use super::small_angle::SmallAngle;
use super::wide_angle::layout::Layout;
use super::wide_angle::table::Table;
use super::wide_angle::{HandOver, WideAngle, table_of};
use crate::error::{Error, Result, in_range};
use crate::medium::Medium;
use crate::phase::{Family, PhaseFunction};
use std::fmt;
use std::str::FromStr;

/// A spread model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Model {
    /// Direct light only.
    BeerLambert,
    /// Direct light and light scattered once.
    SingleScatter,
    /// A Gaussian with the exact total and second moment.
    Gaussian,
    /// The kernel of Shinya et al. with the second moment as printed (eq. 21).
    NarrowBeamPrinted,
    /// The kernel of Shinya et al. with the exact second moment.
    NarrowBeam,
    /// The exact small-angle transfer function.
    SmallAngle,
    /// Valid at every angle, from a table made by tracing.
    WideAngle,
    /// Paths traced for the given scene: no kernel, and none of [`ALL`](Model::ALL).
    Traced,
}

/// Largest tau·4B at which small-angle theory holds to 1 % of the transfer function: max|dM| ≈ 0.19 tau·4B,
/// measured against photon tracing.
pub const SMALL_ANGLE_LIMIT: f64 = 0.05;

/// The error of small-angle theory at tau·4B = `validity` in words, according to that measurement.
pub fn small_angle_error(validity: f64) -> String {
    // Beyond 1 the error is no longer linear: it approaches all of the scattered light.
    if validity < 1.0 { format!("about {:.1} %", 19.0 * validity) } else { "more than 20 %".into() }
}

impl Model {
    /// All models that have kernels, cheapest first.
    pub const ALL: [Model; 7] = [
        Model::BeerLambert,
        Model::SingleScatter,
        Model::Gaussian,
        Model::NarrowBeamPrinted,
        Model::NarrowBeam,
        Model::SmallAngle,
        Model::WideAngle,
    ];

    /// Name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Model::BeerLambert => "beer-lambert",
            Model::SingleScatter => "single-scatter",
            Model::Gaussian => "gaussian",
            Model::NarrowBeamPrinted => "narrow-beam-printed",
            Model::NarrowBeam => "narrow-beam",
            Model::SmallAngle => "small-angle",
            Model::WideAngle => "wide-angle",
            Model::Traced => "traced",
        }
    }

    /// Whether the kernel depends on the width of the phase function.
    pub fn spreads(self) -> bool {
        self != Model::BeerLambert
    }

    /// Whether the kernel rests on small angles, and so ends where tau·4B is large.
    pub fn rests_on_small_angles(self) -> bool {
        self.spreads() && !matches!(self, Model::WideAngle | Model::Traced)
    }

    /// The media for which there is a kernel, with phase functions of `family`.
    ///
    /// # Errors
    /// [`Error::NoSecondMoment`] if there are none.
    pub fn range(self, family: Family) -> Result<Range> {
        let everything = Range { tau: f64::INFINITY, absorption: f64::INFINITY, phase: [0.0, f64::INFINITY] };
        match (self, family) {
            (Model::WideAngle, family) => Ok(Layout::of(family).range()),
            (Model::Gaussian | Model::NarrowBeamPrinted | Model::NarrowBeam, Family::HenyeyGreenstein) => {
                Err(self.no_second_moment(family))
            }
            _ => Ok(everything),
        }
    }

    fn no_second_moment(self, family: Family) -> Error {
        Error::NoSecondMoment { model: self.name(), phase: family.to_string() }
    }

    /// The kernel of this model for `medium` after the path length `z` (length).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless `z` is finite and above 0, and outside the [range](Model::range) of the model;
    /// [`Error::NoKernel`] for `traced`; [`Error::NoSecondMoment`] if the model matches moments and the phase function has
    /// none.
    pub fn kernel(self, medium: &Medium, z: f64) -> Result<Box<dyn SpreadKernel>> {
        in_range("z", z, z.is_finite() && z > 0.0, "finite and above 0 (length)")?;
        let family = medium.phase().family();
        let matched = |profile, moments| -> Result<Box<dyn SpreadKernel>> {
            let b = gaussian_width(medium).ok_or_else(|| self.no_second_moment(family))?;
            Ok(Box::new(MomentMatched::new(*medium, b, z, profile, moments)))
        };
        match self {
            Model::BeerLambert => Ok(Box::new(BeerLambert::new(*medium, z))),
            Model::SingleScatter => Ok(Box::new(SingleScatter::new(*medium, z))),
            Model::Gaussian => matched(Profile::Gaussian, Moments::Exact),
            Model::NarrowBeamPrinted => matched(Profile::Erfc, Moments::Printed),
            Model::NarrowBeam => matched(Profile::Erfc, Moments::Exact),
            Model::SmallAngle => Ok(Box::new(SmallAngle::new(*medium, z))),
            Model::WideAngle => wide_angle(table_of(family), medium, z),
            Model::Traced => Err(Error::NoKernel),
        }
    }
}

/// The kernel of the `table`, or of small angles where a phase function is narrower than any in it.
fn wide_angle(table: &Table, medium: &Medium, z: f64) -> Result<Box<dyn SpreadKernel>> {
    let kernel = WideAngle::new(table, medium, z)?;
    let octaves = table.layout().narrower(medium.phase().parameter());
    Ok(if octaves.value > 0.0 {
        Box::new(HandOver::new(kernel, *medium, z, octaves))
    } else {
        Box::new(kernel)
    })
}

impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Model {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let unknown = || Error::UnknownName {
            what: "model",
            name: name.to_string(),
            known: Model::ALL.map(Model::name).join(", "),
        };
        Model::ALL.into_iter().find(|m| m.name() == name).ok_or_else(unknown)
    }
}
