//! Phase functions that are narrower than any in the table: small-angle theory takes over.
//!
//! The table holds kernels in units of their own width, as far as they are measured. Of a phase function beyond its narrow end a
//! pixel may see only the tail, at radii where the table was never compared. Small-angle theory is exact there: tau times the
//! mean-square angle is under 0.05 for Henyey-Greenstein's phase function and under 0.001 for the Gaussian. Over a factor of
//! two in the angle the kernel goes from one to the other, so that a fit meets no step.

use super::WideAngle;
use crate::medium::Medium;
use crate::spread::small_angle::SmallAngle;
use crate::spread::{Dual, SpreadKernel};

/// The table's kernel and that of small angles, mixed.
pub(in crate::spread) struct HandOver {
    /// The share of the latter.
    share: Dual,
    table: WideAngle,
    small: SmallAngle,
}

impl HandOver {
    /// The kernel of `table`, of whose narrow end the phase function of `medium` is `octaves` of the angle beyond.
    pub(in crate::spread) fn new(table: WideAngle, medium: Medium, z: f64, octaves: Dual) -> Self {
        let t = octaves.value.clamp(0.0, 1.0);
        // Smooth at both ends.
        let share = Dual {
            value: t * t * (3.0 - 2.0 * t),
            gradient: octaves.gradient.map(|slope| 6.0 * t * (1.0 - t) * slope),
        };
        Self { share, table, small: SmallAngle::new(medium, z) }
    }

    fn mixed(&self, of: impl Fn(&dyn SpreadKernel) -> Dual) -> Dual {
        if self.share.value >= 1.0 {
            return of(&self.small);
        }
        let (table, small) = (of(&self.table), of(&self.small));
        table + self.share * (small - table)
    }

    fn mixed_value(&self, of: impl Fn(&dyn SpreadKernel) -> f64) -> f64 {
        self.mixed(|kernel| Dual::constant(of(kernel))).value
    }
}

impl SpreadKernel for HandOver {
    fn path_length(&self) -> f64 {
        self.table.path_length()
    }

    fn medium(&self) -> &Medium {
        self.table.medium()
    }

    fn scattered_transfer(&self, k: f64) -> Dual {
        self.mixed(|kernel| kernel.scattered_transfer(k))
    }

    fn mean_slope(&self, k: f64, nearness: f64) -> Dual {
        self.mixed(|kernel| kernel.mean_slope(k, nearness))
    }

    fn psf(&self, r: f64) -> f64 {
        self.mixed_value(|kernel| kernel.psf(r))
    }

    fn encircled_energy(&self, r: f64) -> f64 {
        self.mixed_value(|kernel| kernel.encircled_energy(r))
    }

    fn width(&self) -> f64 {
        self.table.width()
    }
}
