//! The transfer function from a slice to what its light must pass next: the camera, or an occluder.
//!
//! For z1 < z2 the quotient M_z2/M_z1 is itself a transfer function, that of the scattering with lever arms between
//! z1 and z2. On pixels it is the quotient of both depths' pixel transfer functions T + s̃ ([`footprint`]), so that a
//! occluder which covers nothing changes nothing. In f32, quotients are formed in units of the occluder's own M(|w|):
//!
//! `(T_i + s̃_i) / (T_k + s̃_k) = [b_i + T_i/M + a_i/M] / [b_k + T_k/M + a_k/M]`,
//!
//! b being the baseband s sinc²sinc²/M and a the aliases: every number is at most of the order of 1, however little
//! light is left at a frequency.
//!
//! [`footprint`]: super::footprint

use super::Optics;
use super::obliquity::Obliquity;
use super::slices::Node;
use super::tables::{AliasLine, AliasTable, Basis, Lanes, RadialTable, lanes};
use crate::error::Result;
use crate::image::Sampling;
use crate::spread::{Dual, SpreadKernel};
use rayon::prelude::*;
use rustfft::num_complex::Complex;

/// A complex amplitude and its derivatives in sigma_s, sigma_a, B.
pub(super) type Wave = [Complex<f32>; 4];

/// `wave` times `factor`, by the product rule.
pub(super) fn times(wave: &Wave, factor: &Lanes) -> Wave {
    let value = wave[0];
    std::array::from_fn(|c| if c == 0 { value * factor[0] } else { wave[c] * factor[0] + value * factor[c] })
}

/// `wave` over `divisor`, by the quotient rule.
pub(super) fn over(wave: &Wave, divisor: &Lanes) -> Wave {
    let inverse = 1.0 / divisor[0];
    let value = wave[0] * inverse;
    std::array::from_fn(|c| if c == 0 { value } else { (wave[c] - value * divisor[c]) * inverse })
}

/// The product of `a` and `b`.
pub(super) fn product(a: &Lanes, b: &Lanes) -> Lanes {
    std::array::from_fn(|c| if c == 0 { a[0] * b[0] } else { a[c] * b[0] + a[0] * b[c] })
}

/// Share of an occluder's light below which its transfer function counts as 0.
const NOTHING: f64 = 1e-30;

/// What transfer functions are divided by: M of an occluder, or 1 for the camera.
pub(super) struct Unit {
    occluder: Option<(Box<dyn SpreadKernel>, f64)>,
    scale: f64,
    sampling: Sampling,
}

impl Unit {
    pub(super) fn new(occluder: Option<Node>, optics: &Optics, sampling: Sampling) -> Result<Self> {
        let Some(node) = occluder else { return Ok(Self { occluder: None, scale: 1.0, sampling }) };
        let kernel = optics.kernel(node.z)?;
        let least = (NOTHING * kernel.mtf(0.0).value).max(f64::MIN_POSITIVE);
        let scale = kernel.direct().value.max(least);
        Ok(Self { occluder: Some((kernel, node.pitch)), scale, sampling })
    }

    /// M at `w` rad/px, never less than the scale.
    fn at(&self, w: f64) -> Dual {
        let Some((kernel, pitch)) = &self.occluder else { return Dual::constant(1.0) };
        let m = kernel.mtf(w / pitch);
        if m.value >= self.scale { m } else { Dual::constant(self.scale) }
    }
}

/// How rays of a perspective view meet slopes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slope {
    /// See [`SpreadKernel::mean_slope`].
    pub nearness: f64,
    /// Slope against the ray over slope against the camera's axis.
    pub steepness: f64,
}

/// Tables of one slice's transfer function, in units of M.
pub(super) struct Transfer {
    pub baseband: RadialTable,
    pub slope_correction: Option<RadialTable>,
    pub aliases: AliasTable,
    /// T_i/T_k: the share of the occluder's direct light that is this slice's.
    pub direct: Lanes,
    /// T_i in units of the scale.
    pub unscattered: Lanes,
}

impl Transfer {
    /// Tables of the slice at `node`; with its slope term if `slope` is given.
    pub(super) fn new(node: Node, slope: Option<Slope>, optics: &Optics, unit: &Unit) -> Result<Self> {
        let kernel = optics.kernel(node.z)?;
        let k = |w: f64| w / node.pitch;
        let table =
            |f: &dyn Fn(f64) -> Dual| RadialTable::new(&*kernel, node.pitch, |w| f(k(w)) / unit.at(w));
        let way = node.z - unit.occluder.as_ref().map_or(0.0, |(kernel, _)| kernel.path_length());
        let direct = (-optics.medium.sigma_t() * way).exp();
        Ok(Self {
            baseband: table(&|k| kernel.scattered_transfer(k)),
            slope_correction: slope
                .map(|slope| table(&|k| slope.steepness * kernel.mean_slope(k, slope.nearness))),
            aliases: match unit.sampling {
                Sampling::Pixel => AliasTable::new(&*kernel, node.pitch, unit.scale),
                Sampling::Bandlimited => AliasTable::none(),
            },
            direct: lanes(&Dual { value: direct, gradient: [-way * direct, -way * direct, 0.0] }),
            unscattered: lanes(&(1.0 / unit.scale * kernel.direct())),
        })
    }

    pub(super) fn line(&self, basis: &Basis) -> AliasLine {
        self.aliases.line(basis)
    }

    /// Scattered light at frequency `at`.
    pub(super) fn scattered(&self, line: &AliasLine, at: &Frequency) -> Lanes {
        let baseband = self.baseband.at(at.w);
        let beyond = product(&line.at(at.basis), &at.scale);
        std::array::from_fn(|c| at.weight * baseband[c] + beyond[c])
    }

    /// Scattered and unscattered light at frequency `at`.
    pub(super) fn whole(&self, line: &AliasLine, at: &Frequency) -> Lanes {
        let (scattered, direct) = (self.scattered(line, at), product(&self.unscattered, &at.scale));
        std::array::from_fn(|c| scattered[c] + direct[c])
    }

    /// Factor of the slope term's source at frequency `at`; 0 without slopes.
    pub(super) fn slope_correction(&self, at: &Frequency) -> Lanes {
        self.slope_correction.as_ref().map_or([0.0; 4], |table| table.at(at.w).map(|v| at.weight * v))
    }
}

/// Tables of all that a slab's light is multiplied with on its way to its occluder, or to the camera.
pub(super) struct Way {
    /// Of its slices.
    pub transfers: Vec<Transfer>,
    /// Of what is carried to it from a farther occluder.
    pub farther: Option<Transfer>,
    pub divisor: Option<Divisor>,
}

impl Way {
    /// The way from `slices` and the `farther` occluder to the nearer `occluder`. If the slices slope, `divergence` is the
    /// length of a pixel per unit of depth.
    pub(super) fn new(
        slices: &[Node],
        divergence: Option<f64>,
        farther: Option<Node>,
        occluder: Option<Node>,
        (optics, obliquity, sampling): (&Optics, Obliquity, Sampling),
    ) -> Result<Self> {
        let occluder = occluder.map(|node| obliquity.scaled(node));
        let unit = Unit::new(occluder, optics, sampling)?;
        let slope = |node: &Node| {
            divergence.map(|divergence| Slope {
                nearness: (divergence * node.z / node.pitch).min(1.0),
                steepness: 1.0 / obliquity.cosine,
            })
        };
        let transfer = |node: &Node| Transfer::new(obliquity.scaled(*node), slope(node), optics, &unit);
        Ok(Self {
            transfers: slices.par_iter().map(transfer).collect::<Result<_>>()?,
            farther: farther
                .map(|node| Transfer::new(obliquity.scaled(node), None, optics, &unit))
                .transpose()?,
            divisor: occluder.map(|node| Divisor::new(node, optics, &unit)).transpose()?,
        })
    }
}

/// A frequency, and what all slices need there.
pub(super) struct Frequency<'a> {
    /// |w|, rad/px.
    pub w: f64,
    /// What both pixels leave: sinc² sinc², or 1.
    pub weight: f32,
    /// Basis of the aliases along y.
    pub basis: &'a Basis,
    /// The scale over M.
    pub scale: Lanes,
}

/// Tables of the divisor: the occluder's own transfer function, and the scale, in units of M.
pub(super) struct Divisor {
    pub own: Transfer,
    pub scale: RadialTable,
}

impl Divisor {
    pub(super) fn new(node: Node, optics: &Optics, unit: &Unit) -> Result<Self> {
        let kernel = optics.kernel(node.z)?;
        let scale = RadialTable::new(&*kernel, node.pitch, |w| Dual::constant(unit.scale) / unit.at(w));
        Ok(Self { own: Transfer::new(node, None, optics, unit)?, scale })
    }

    pub(super) fn line(&self, basis: &Basis) -> AliasLine {
        self.own.line(basis)
    }

    /// The scale over M at `w` rad/px.
    pub(super) fn scale(&self, w: f64) -> Lanes {
        self.scale.at(w)
    }

    /// The occluder's scattered light, and all of its light, at frequency `at`.
    pub(super) fn at(&self, line: &AliasLine, at: &Frequency) -> [Lanes; 2] {
        let mut whole = self.own.whole(line, at);
        // At least sinc² sinc² ≥ .16 but where the light is below [`NOTHING`].
        whole[0] = whole[0].max(0.1);
        [self.own.scattered(line, at), whole]
    }
}
