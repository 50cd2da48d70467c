//! `wide-angle`: valid at every angle, from a table made by tracing.
//!
//! In units of the path length z a medium is three numbers: tau = sigma_s z, a = sigma_a z and the parameter of the phase
//! function, B or g; D is the root of its [mean-square scattering angle](crate::phase::Family::mean_square_angle). The table of a
//! family holds the kernel at nodes of them, as a mixture of positive Gaussians of widths s_j = x_j z w, where w is the planar
//! width of the phase function. The small-angle kernel is exactly such a mixture; the true kernel is one within the errors
//! that `tests/it/wide_angle.rs` prints:
//!
//! ```text
//! M(k) - T = W sum_j p_j exp(-s_j² k²/2),      sum p_j = 1,
//! N(k)     = -k² V sum_j q_j s_j exp(-s_j² k²/2)      (mean slope, see SpreadKernel::mean_slope)
//! ```
//!
//! - *Total.* W / phi, phi = exp(-a)(1 - exp(-tau)), is the share of the light of small-angle theory that arrives: the
//!   rest is absorbed on the excess path, or lost through the front surface. Its logarithm is tabulated, divided by
//!   D² plus a constant, so the relative error of the total is as small at a = 10 as at 0.
//! - *Profile.* The roots of p_j are tabulated: their interpolants, squared and normalised, are positive and add up to 1.
//!   Absorption is a third axis rather than a moment of the path lengths at each radius: where it is strong, few of
//!   the paths at a = 0 arrive, and they are not the typical ones.
//! - *Slope.* A path's radial slope times its light is expanded in gradients of the same Gaussians, r/s_j² G_j.
//! - *Light scattered once* comes from quadrature; only the rest is traced, by paths that all scatter twice. So there is no
//!   noise in the 1/r singularity, and none in the total where small-angle theory holds.
//! - *Between nodes*: a polynomial on Chebyshev points in sqrt(tau), ln(1 + 2a), and D or ln(1 - g) ([`layout`]). It is
//!   entire in tau except for the zeros of phi; in a it has its next singularity at the slowest decay of light kept in
//!   the layer, some -0.4. So the error falls geometrically with the number of nodes, and all derivatives are
//!   continuous.
//!
//! The range is tau 0 to 12, sigma_a z 0 to 10, and spread angles up to 60 degrees or g from 0.5 on; below 0.5 degrees and beyond g 0.998
//! small-angle theory takes over (`hand_over`). The tables in `tables/` were
//! made by `narrowbeam table --paths 800000 --seed 1 --out tables/wide-angle.table` and `narrowbeam table --phase hg --paths
//! 200000 --seed 1 --out tables/wide-angle-hg.table`, as their first lines say too.

mod hand_over;
#[doc(hidden)]
pub mod layout;
pub mod table;

pub(super) use hand_over::HandOver;

use super::{Dual, SpreadKernel};
use crate::error::Result;
use crate::medium::Medium;
use crate::phase::{Family, PhaseFunction};
use layout::{Layout, relative_width};
use std::f64::consts::PI;
use std::sync::LazyLock;
use table::Table;

/// The tables that come with the program.
static GAUSSIAN: LazyLock<Table> =
    LazyLock::new(|| embedded(Family::Gaussian, include_bytes!("../../../tables/wide-angle.table")));
static HENYEY_GREENSTEIN: LazyLock<Table> = LazyLock::new(|| {
    embedded(Family::HenyeyGreenstein, include_bytes!("../../../tables/wide-angle-hg.table"))
});

fn embedded(family: Family, bytes: &[u8]) -> Table {
    Table::parse(Layout::of(family), bytes).expect("the embedded table is whole: a test reads it")
}

/// The table for `family` that comes with the program.
pub fn table_of(family: Family) -> &'static Table {
    match family {
        Family::Gaussian => &GAUSSIAN,
        Family::HenyeyGreenstein => &HENYEY_GREENSTEIN,
    }
}

/// The tabulated kernel of one medium and path length.
pub struct WideAngle {
    medium: Medium,
    z: f64,
    /// Derivative in the phase-function parameter of the logarithm of every variance.
    widening: f64,
    components: Vec<Component>,
}

/// One Gaussian of the mixture.
struct Component {
    /// Its share of the light that set out.
    light: Dual,
    /// Its part of V q_j s_j, length.
    slope: Dual,
    /// Variance per axis, length².
    variance: f64,
}

impl WideAngle {
    /// The kernel for `medium` after the path length `z`, from the `table` of the family of its phase function.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange), with the range, where the table ends.
    ///
    /// # Panics
    /// If the table is that of another family.
    pub fn new(table: &Table, medium: &Medium, z: f64) -> Result<Self> {
        let phase = medium.phase();
        assert_eq!(table.layout().family, phase.family(), "the table of the family");
        let node = table.at(medium.tau(z), medium.sigma_a() * z, phase.parameter())?;
        // From (tau, a) to (sigma_s, sigma_a).
        let in_medium = |d: Dual| Dual {
            value: d.value,
            gradient: [z * d.gradient[0], z * d.gradient[1], d.gradient[2]],
        };
        let exp = |d: Dual| d.value.exp() * Dual { value: 1.0, gradient: d.gradient };
        let phi = Dual {
            value: medium.scattered_total(z),
            gradient: [z * medium.transmittance(z), -z * medium.scattered_total(z), 0.0],
        };
        let total = phi * exp(in_medium(node.total));
        let widening = z * phase.planar_width_derivative();
        let width = Dual { value: z * phase.planar_width(), gradient: [0.0, 0.0, widening] };
        let planar_width =
            Dual { value: phase.planar_width(), gradient: [0.0, 0.0, phase.planar_width_derivative()] };
        let rise = total * exp(in_medium(node.slope)) * planar_width * width;
        let shares = |roots: &[Dual]| -> Vec<Dual> {
            let squares: Vec<Dual> = roots.iter().map(|&r| in_medium(r * r)).collect();
            let sum = squares.iter().fold(Dual::default(), |sum, &s| sum + s);
            squares.into_iter().map(|s| s / sum).collect()
        };
        let (light, slope) = (shares(&node.light_roots), shares(&node.slope_roots));
        let component = |j: usize| {
            let x = relative_width(j);
            Component {
                light: total * light[j],
                slope: x * (rise * slope[j]),
                variance: (x * width.value) * (x * width.value),
            }
        };
        let widening = 2.0 * phase.planar_width_derivative() / phase.planar_width();
        Ok(Self { medium: *medium, z, widening, components: (0..light.len()).map(component).collect() })
    }

    /// sum_j w_j exp(-s_j² k²/2) with its derivatives.
    fn mixture(&self, k: f64, weight: impl Fn(&Component) -> Dual) -> Dual {
        self.components.iter().fold(Dual::default(), |sum, component| {
            let exponent = 0.5 * component.variance * k * k;
            let gaussian = (-exponent).exp();
            sum + weight(component)
                * Dual { value: gaussian, gradient: [0.0, 0.0, -exponent * self.widening * gaussian] }
        })
    }
}

impl SpreadKernel for WideAngle {
    fn path_length(&self) -> f64 {
        self.z
    }

    fn medium(&self) -> &Medium {
        &self.medium
    }

    fn scattered_transfer(&self, k: f64) -> Dual {
        self.mixture(k, |component| component.light)
    }

    /// The part of the offset is exact: E[r exp(ik·r)] = -i grad M.
    fn mean_slope(&self, k: f64, nearness: f64) -> Dual {
        let steep = self.mixture(k, |component| component.slope);
        let offset = self.mixture(k, |component| {
            let value = component.variance / self.z;
            component.light * Dual { value, gradient: [0.0, 0.0, value * self.widening] }
        });
        k * k * (nearness * offset - steep)
    }

    fn psf(&self, r: f64) -> f64 {
        let density = |component: &Component| {
            component.light.value / (2.0 * PI * component.variance)
                * (-0.5 * r * r / component.variance).exp()
        };
        self.components.iter().map(density).sum()
    }

    fn encircled_energy(&self, r: f64) -> f64 {
        self.components
            .iter()
            .map(|component| -component.light.value * (-0.5 * r * r / component.variance).exp_m1())
            .sum()
    }

    fn width(&self) -> f64 {
        self.z * self.medium.phase().planar_width()
    }
}
