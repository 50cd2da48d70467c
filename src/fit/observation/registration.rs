//! Observations that do not lie on the clear image: registered at first sight, so that a fit can begin.

use super::Observation;
use crate::error::Result;
use crate::filter::{coarse_shift, moved};
use crate::image::Image;
use crate::scene::Registration;

/// Pixels beside those that a shift brings in from outside the view which do not count either: the interpolation rings.
const MARGIN_PX: f64 = 2.0;

/// Observations moved back onto the clear image, by a fraction of a pixel's error.
pub(crate) struct Aligned {
    /// The shift of each, px; `None` where it is registered already.
    pub shifts_px: Vec<Option<[f64; 2]>>,
    /// What is seen of each that was moved.
    views: Vec<Option<View>>,
}

/// An observed image moved back, and which of its pixels count.
struct View {
    observed: Image,
    mask: Image,
}

impl Aligned {
    /// The `observations` registered at first sight.
    pub(crate) fn new(observations: &[Observation]) -> Result<Self> {
        let shift = |o: &Observation| match o.registration {
            Registration::None => None,
            Registration::Shift => {
                Some(coarse_shift(&o.target.radiance.crop(o.target.view), o.observed, o.mask))
            }
        };
        let shifts_px: Vec<_> = observations.iter().map(shift).collect();
        let view = |(o, shift): (&Observation, &Option<[f64; 2]>)| {
            shift.map(|shift_px| View::new(o, shift_px)).transpose()
        };
        let views = observations.iter().zip(&shifts_px).map(view).collect::<Result<_>>()?;
        Ok(Self { shifts_px, views })
    }

    /// The same of each `observations` that it was made of.
    pub(crate) fn observations<'b>(&'b self, observations: &[Observation<'b>]) -> Vec<Observation<'b>> {
        let moved = |(observation, view): (&Observation<'b>, &'b Option<View>)| match view {
            None => *observation,
            Some(View { observed, mask }) => {
                Observation { observed, mask: Some(mask), registration: Registration::None, ..*observation }
            }
        };
        observations.iter().zip(&self.views).map(moved).collect()
    }
}

impl View {
    fn new(observation: &Observation, [x, y]: [f64; 2]) -> Result<Self> {
        let Image { width, height, .. } = *observation.observed;
        let observed = moved(observation.observed, [-x, -y])?;
        // The pixel (i, j) now shows what was seen at (i + x, j + y), which must lie well within the view.
        let inside = |i: usize, by: f64, n: usize| {
            let seen = i as f64 + by;
            seen >= MARGIN_PX.min(by.abs()) && seen <= n as f64 - 1.0 - MARGIN_PX.min(by.abs())
        };
        let counts = |i: usize, j: usize| {
            let masked = || {
                let [u, v] = [i as f64 + x, j as f64 + y].map(|c| c.round() as usize);
                !observation.is_unmasked(v * width + u)
            };
            inside(i, x, width) && inside(j, y, height) && !masked()
        };
        let mask = Image::from_fn(width, height, |i, j| f32::from(u8::from(counts(i, j))));
        Ok(Self { observed, mask })
    }
}
