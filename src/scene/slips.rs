//! Numbers of a scene that are legal and unlikely: what is probably meant.

use super::Scene;
use crate::geometry::{Camera, median};
use crate::image::View;
use crate::medium::Medium;
use crate::phase::{Family, PhaseFunction};

/// Object widths in a path through the medium, seen by parallel rays, above which depth and pitch are hardly in one unit: a
/// thousandth is missed where the path is a width or so.
const WIDTHS: f64 = 100.0;
/// B of a Gaussian phase function, rad², above which it is hardly one: its spread angle exceeds 96 degrees.
const WIDEST_B: f64 = 0.7;

impl Scene {
    /// What is odd about its lengths, with the likely slip.
    pub fn unit_slip(&self) -> Option<String> {
        let Camera::Orthographic { pixel_pitch } = self.geometry.camera else { return None };
        let View { width, height, .. } = View::whole(self.geometry.width, self.geometry.height);
        let side = pixel_pitch * width.max(height) as f64;
        let z = median(self.geometry.path_lengths());
        let what = if z > WIDTHS * side {
            format!("{:.0} times as long as the object image is wide", z / side)
        } else if z < pixel_pitch {
            "shorter than a pixel of the object".into()
        } else {
            return None;
        };
        Some(format!(
            "the light's path through the medium, {z:.4} long, is {what}, {side:.4}: are depth and pixel_pitch in one unit, \
             such as metres, or is one of them in millimetres?"
        ))
    }
}

/// What is odd about this medium, with the likely slip.
pub fn medium_slip(medium: &Medium) -> Option<String> {
    let b = medium.phase().parameter();
    (medium.phase().family() == Family::Gaussian && b > WIDEST_B).then(|| {
        format!(
            "b = {b} rad² is a spread angle of {:.0} degrees, wider than any Gaussian lobe: an angle in degrees is \
             spread_angle_deg",
            (4.0 * b).sqrt().to_degrees()
        )
    })
}
