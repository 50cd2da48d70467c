//! Observations that do not lie on the clear image: registered at first sight, so that a fit can begin.

use super::Observation;
use crate::error::Result;
use crate::filter::spline::{Waves, sampled};
use crate::filter::{coarse_shift, coarse_similarity, moved};
use crate::image::Image;
use crate::imaging::{Bend, Imaging, Registration, Warp, WarpParameter};

/// Pixels beside those that a shift brings in from outside the view which do not count either: the interpolation rings.
const MARGIN_PX: f64 = 2.0;

/// Where an observation lies on the clear image: what the latter shows at p, from the middle of the view, is seen at the
/// [warped](Warp) place of p + shift.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Alignment {
    /// To the right and downwards, px.
    pub shift_px: [f64; 2],
    /// Angle from +x towards +y, rad.
    pub rotation: f64,
    /// Logarithm of its size over that of the clear image.
    pub log_scale: f64,
}

impl Alignment {
    /// That of `observation` at first sight; `None` if it is not to be registered.
    fn of(observation: &Observation) -> Option<Self> {
        let clear = || observation.target.radiance.crop(observation.target.view);
        match observation.registration {
            Registration::None => None,
            Registration::Shift => {
                let shift_px = coarse_shift(&clear(), observation.observed, observation.mask);
                Some(Self { shift_px, ..Self::default() })
            }
            _ => {
                let (warp, shift_px) = coarse_similarity(&clear(), observation.observed, observation.mask);
                let [rotation, log_scale] =
                    [WarpParameter::Rotation, WarpParameter::LogScale].map(|parameter| warp.get(parameter));
                Some(Self { shift_px, rotation, log_scale })
            }
        }
    }

    fn warp(&self) -> Warp {
        let turned = Warp::default().with(WarpParameter::Rotation, self.rotation);
        turned.with(WarpParameter::LogScale, self.log_scale)
    }

    /// What a camera that does `imaging` begins with where this is what is seen first.
    pub(crate) fn begun(place: Option<Self>, imaging: Option<Imaging>) -> Option<Imaging> {
        let warp = place.map_or_else(Warp::default, |place| place.warp());
        imaging.map(|imaging| Imaging { warp, ..imaging })
    }
}

/// Observations moved back onto the clear image, by a fraction of a pixel's error.
pub(crate) struct Aligned {
    /// Where each lies; `None` where it is registered already.
    pub places: Vec<Option<Alignment>>,
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
        let places: Vec<_> = observations.iter().map(Alignment::of).collect();
        let view = |(o, place): (&Observation, &Option<Alignment>)| {
            place.map(|place| View::new(o, place)).transpose()
        };
        let views = observations.iter().zip(&places).map(view).collect::<Result<_>>()?;
        Ok(Self { places, views })
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
    fn new(observation: &Observation, place: Alignment) -> Result<Self> {
        let Image { width, height, .. } = *observation.observed;
        let places = observation.places();
        let bend = place.warp().bend(places.half_diagonal_px());
        let bend = bend.expect("a similarity folds nothing");
        let observed = if place.warp() == Warp::default() {
            moved(observation.observed, place.shift_px.map(|d| -d))?
        } else {
            let splines = [Waves::of(observation.observed).spline(0.0)];
            let from = |i: usize| seen_at(places.px(i), place, &bend, [width, height]);
            sampled(&splines, (width, height), from).remove(0).image
        };
        // A pixel now shows what was seen elsewhere, which must lie well within the view.
        let counts = |i: usize| {
            let seen = seen_at(places.px(i), place, &bend, [width, height]);
            let here = [(i % width) as f64, (i / width) as f64];
            let inside = |axis: usize, n: usize| {
                let margin = MARGIN_PX.min((seen[axis] - here[axis]).abs());
                seen[axis] >= margin && seen[axis] <= n as f64 - 1.0 - margin
            };
            let masked = || {
                let [u, v] = seen.map(|c| c.round() as usize);
                !observation.is_unmasked(v * width + u)
            };
            inside(0, width) && inside(1, height) && !masked()
        };
        let mask = Image::from_fn(width, height, |x, y| f32::from(u8::from(counts(y * width + x))));
        Ok(Self { observed, mask })
    }
}

/// Where the clear `place_px`, from the middle, is seen, px; (0, 0) is the middle of the first pixel.
fn seen_at(place_px: [f64; 2], place: Alignment, bend: &Bend, size: [usize; 2]) -> [f64; 2] {
    let [dx, dy] = place.shift_px;
    let seen = bend.seen_at([place_px[0] + dx, place_px[1] + dy]);
    [0, 1].map(|axis| seen[axis] + 0.5 * size[axis] as f64 - 0.5)
}
