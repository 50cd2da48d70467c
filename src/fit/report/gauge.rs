//! What kind of scattering a scene has: is it within the reach of a model, and of the picture?

use crate::fit::ChannelFit;
use crate::medium::Medium;
use crate::phase::Family;
use crate::spread::{SMALL_ANGLE_LIMIT, small_angle_error, typical_radius};

/// Share of scattered light under which there is next to none.
const NEXT_TO_NONE: f64 = 0.01;
/// Share of scattered light above which little direct light is left.
const NEXT_TO_ALL: f64 = 0.95;
/// Width of the kernel, px, under which the picture hardly shows it.
const UNSEEN_PX: f64 = 0.5;
/// Width of the kernel, views, above which its light is nearly a veil.
const LIKE_A_VEIL: f64 = 0.3;

/// Numbers that say which models and which measurements a scene allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gauge {
    /// Family of the phase function.
    pub family: Family,
    /// tau times the [mean-square scattering angle](Family::mean_square_angle): tau·4B, tau·2(1-g).
    pub validity: f64,
    /// Scattered light over all light that arrives.
    pub scattered_share: f64,
    /// [Typical radius](typical_radius) of the kernel of small angles, px.
    pub kernel_width_px: f64,
    /// The same over the shorter side of the view.
    pub kernel_width_views: f64,
}

impl Gauge {
    /// Of the medium of a fit; `None` for an optimum that is no medium.
    pub(super) fn of(fit: &ChannelFit) -> Option<Self> {
        let [sigma_s, sigma_a, shape] = fit.parameters.values();
        let (family, z) = (fit.parameters.family(), fit.median_z);
        let medium = Medium::new(sigma_s, sigma_a, family.phase(shape).ok()?).ok()?;
        let scattered = medium.scattered_total(z);
        let kernel_width_px = typical_radius(&medium, z) / fit.pixel_pitch;
        Some(Self {
            family,
            validity: medium.tau(z) * family.mean_square_angle(shape),
            scattered_share: scattered / (scattered + medium.transmittance(z)).max(f64::MIN_POSITIVE),
            kernel_width_px,
            kernel_width_views: kernel_width_px / fit.view_px as f64,
        })
    }

    /// The same in plain language.
    pub fn verdict(&self) -> String {
        let square = self.family.mean_square_angle_formula();
        let angles = if self.validity <= SMALL_ANGLE_LIMIT {
            format!("angles are small (tau·{square} = {:.3})", self.validity)
        } else {
            let error = small_angle_error(self.validity);
            format!(
                "angles are wide (tau·{square} = {:.3}: small-angle theory is off by {error})",
                self.validity
            )
        };
        let percent = 100.0 * self.scattered_share;
        let light = match self.scattered_share {
            s if s < NEXT_TO_NONE => format!("next to no light is scattered ({percent:.1} %)"),
            s if s > NEXT_TO_ALL => format!("hardly any direct light is left ({percent:.1} % is scattered)"),
            _ => format!("{percent:.0} % of the light is scattered"),
        };
        let width = match (self.kernel_width_px, self.kernel_width_views) {
            (px, _) if px < UNSEEN_PX => format!("the kernel, {px:.2} px wide, is hardly resolved"),
            (px, views) if views > LIKE_A_VEIL => {
                format!("the kernel, {px:.0} px wide, {views:.2} of the view, acts nearly like a veil")
            }
            (px, views) => format!("the kernel is {px:.1} px wide, {views:.2} of the view"),
        };
        format!("{angles}; {light}; {width}")
    }
}
