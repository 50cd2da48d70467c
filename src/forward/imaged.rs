//! A scene as a camera records it: another model's light, blurred, registered and with a gain that varies.
//!
//! The light is rendered as the clear image's camera would see it, over a part of the object that is large enough for all that
//! the observation shows of it, and then resampled at the places that the observation's pixels see.

use super::products::{Pixels, Products};
use super::quantity::{Quantity, State};
use super::{ForwardModel, Rendering};
use crate::error::{Error, Result};
use crate::filter::spline::{Sampled, Spline, Waves, sampled};
use crate::filter::{Coverage, Target};
use crate::image::{Image, View};
use crate::imaging::{Bend, Imaging, Places};
use std::cell::RefCell;
use std::rc::Rc;

/// How much farther than where it was made for the places may move, px.
const ROOM_PX: f64 = 6.0;
/// Pixels about a place that its value depends on, px.
const SUPPORT_PX: f64 = 3.0;

/// What a camera records of the light over a part of the object.
#[derive(Debug, Clone, Copy)]
pub(super) struct Recorder {
    /// The observed part of the object image.
    view: View,
    /// The part that is rendered.
    rendered: View,
    /// Size of the object image, px.
    object: [usize; 2],
}

impl Recorder {
    /// Of what `imaging` shows of `target`.
    pub(super) fn new(target: &Target, imaging: &Imaging) -> Result<Self> {
        let object = [target.radiance.width, target.radiance.height];
        let view = target.view;
        let bend = bend(imaging, view)?;
        let places = places(view);
        let moved = corners(view).map(|corner| {
            let [seen, clear] = [places.px(corner), bend.clear_place(places.px(corner))];
            (seen[0] - clear[0]).abs().max((seen[1] - clear[1]).abs())
        });
        let warped = moved.into_iter().fold(0.0, f64::max);
        let may_warp = Quantity::of_imaging(imaging).iter().any(|q| matches!(q, Quantity::Warp(_)));
        let reach = if warped > 0.0 || may_warp {
            (warped + ROOM_PX + SUPPORT_PX).ceil()
        } else {
            // The blur alone takes light from beside the view.
            SUPPORT_PX * 2.0
        };
        let margin = reach as usize;
        let [x, y] = [view.x.saturating_sub(margin), view.y.saturating_sub(margin)];
        let [right, down] =
            [(view.x + view.width + margin).min(object[0]), (view.y + view.height + margin).min(object[1])];
        Ok(Self { view, rendered: View { x, y, width: right - x, height: down - y }, object })
    }

    /// What is to be rendered of `target`.
    pub(super) fn target<'a>(&self, target: Target<'a>) -> Target<'a> {
        Target { view: self.rendered, ..target }
    }

    /// Where in the rendered part the pixel `index` of the view looks, px, (0, 0) being the first pixel's middle.
    fn place(&self, bend: &Bend, index: usize) -> [f64; 2] {
        let [x, y] = bend.clear_place(places(self.view).px(index));
        let from_corner = |middle: f64, n: usize, begin: usize, rendered: usize| {
            middle + 0.5 * n as f64 - 0.5 + begin as f64 - rendered as f64
        };
        [
            from_corner(x, self.view.width, self.view.x, self.rendered.x),
            from_corner(y, self.view.height, self.view.y, self.rendered.y),
        ]
    }

    /// The gain at the pixel `index`, over that in the middle.
    fn gain(&self, imaging: &Imaging, index: usize) -> f64 {
        let terms = places(self.view).monomials(index);
        1.0 + terms.iter().zip(imaging.gain_terms).map(|(m, c)| m * c).sum::<f64>()
    }

    /// How far the rendered part serves `imaging` too.
    fn serves(&self, imaging: &Imaging) -> bool {
        let Ok(bend) = bend(imaging, self.view) else { return false };
        corners(self.view).into_iter().all(|corner| {
            let [x, y] = self.place(&bend, corner);
            let inside = |place: f64, begin: usize, size: usize, whole: usize| {
                (begin == 0 || place >= SUPPORT_PX)
                    && (begin + size == whole || place <= size as f64 - 1.0 - SUPPORT_PX)
            };
            let View { x: left, y: top, width, height } = self.rendered;
            inside(x, left, width, self.object[0]) && inside(y, top, height, self.object[1])
        })
    }

    /// The images `light` as they are recorded; and of the first of them, if wanted, how it changes.
    fn recorded(&self, light: &[&Image], imaging: &Imaging, with_changes: bool) -> Result<Recorded> {
        let bend = bend(imaging, self.view)?;
        let waves: Vec<Waves> = light.iter().map(|image| Waves::of(image)).collect();
        let mut splines: Vec<Spline> = waves.iter().map(|waves| waves.spline(imaging.blur_px2)).collect();
        let of_blur = with_changes && imaging.blurs;
        if of_blur {
            splines.push(Waves::of(&waves[0].blur_slope(imaging.blur_px2)).spline(0.0));
        }
        let size = (self.view.width, self.view.height);
        let mut all = sampled(&splines, size, |i| self.place(&bend, i));
        let of_blur = of_blur.then(|| all.pop().expect("it was pushed").image);
        let wanted = if with_changes { Quantity::of_imaging(imaging) } else { Vec::new() };
        let change = |quantity: Quantity| match (quantity, &of_blur) {
            (Quantity::Blur, Some(image)) => (quantity, self.with_gain(image.clone(), imaging)),
            _ => (quantity, self.change(quantity, &all[0], &bend, imaging)),
        };
        let changes = wanted.into_iter().map(change).collect();
        let images = all.into_iter().map(|Sampled { image, .. }| self.with_gain(image, imaging)).collect();
        Ok(Recorded { images, changes })
    }

    /// How what is `seen` at the places that the pixels see changes with `quantity`, of the warp or the gain field.
    fn change(&self, quantity: Quantity, seen: &Sampled, bend: &Bend, imaging: &Imaging) -> Image {
        let (places, size) = (places(self.view), (self.view.width, self.view.height));
        if let Quantity::Warp(parameter) = quantity {
            let moved = made(size, |i| {
                let [u, v] = bend.change(places.px(i), parameter);
                u * f64::from(seen.slopes[0].data[i]) + v * f64::from(seen.slopes[1].data[i])
            });
            return self.with_gain(moved, imaging);
        }
        made(size, |i| {
            let terms = places.monomials(i);
            let term =
                if let Quantity::GainTerm(term) = quantity { terms[term] } else { terms[3] + terms[5] };
            term * f64::from(seen.image.data[i])
        })
    }

    fn with_gain(&self, mut image: Image, imaging: &Imaging) -> Image {
        if imaging.gain_terms.iter().any(|&c| c != 0.0) {
            image.data.iter_mut().enumerate().for_each(|(i, v)| *v *= self.gain(imaging, i) as f32);
        }
        image
    }

    /// The light `image` as it is recorded.
    pub(super) fn image(&self, image: &Image, imaging: &Imaging) -> Result<Image> {
        Ok(self.recorded(&[image], imaging, false)?.images.remove(0))
    }

    /// Light and derivatives as they are recorded, and the derivatives in what the camera does.
    fn rendering(&self, light: &Rendering, imaging: &Imaging) -> Result<Rendering> {
        let images: Vec<&Image> =
            std::iter::once(&light.image).chain(light.derivatives.iter().map(|(_, image)| image)).collect();
        let Recorded { mut images, changes } = self.recorded(&images, imaging, true)?;
        let image = images.remove(0);
        let derivatives = light.derivatives.iter().map(|(quantity, _)| *quantity).zip(images);
        Ok(Rendering { image, derivatives: derivatives.chain(changes).collect() })
    }

    /// The `share` of each pixel of the object image's light that comes from outside it, where the observation's pixels look at
    /// `state`; all of it where that is outside.
    pub(super) fn outside(&self, share: &Image, state: &State) -> Result<Image> {
        let bend = bend(&imaging(state), self.view)?;
        let shift_px = state.shift_px.unwrap_or([0.0; 2]);
        let corner = [self.rendered.x as f64, self.rendered.y as f64];
        Ok(Image::from_fn(self.view.width, self.view.height, |x, y| {
            let place = self.place(&bend, y * self.view.width + x);
            let [u, v] = [0, 1].map(|axis| (place[axis] + corner[axis] - shift_px[axis]).round());
            let inside = u >= 0.0 && v >= 0.0 && u < share.width as f64 && v < share.height as f64;
            if inside { share.at(u as usize, v as usize) } else { 1.0 }
        }))
    }

    /// A share of each pixel, given over the rendered part, where the observation's pixels look; 1 where the object image does not
    /// reach.
    pub(super) fn share(&self, share: Option<&Image>, imaging: &Imaging) -> Result<Option<Image>> {
        let bend = bend(imaging, self.view)?;
        let mut missing = false;
        let image = Image::from_fn(self.view.width, self.view.height, |x, y| {
            let place = self.place(&bend, y * self.view.width + x);
            let [u, v] = place.map(f64::round);
            let inside =
                u >= 0.0 && v >= 0.0 && u < self.rendered.width as f64 && v < self.rendered.height as f64;
            missing |= !inside;
            match share {
                _ if !inside => 1.0,
                Some(share) => share.at(u as usize, v as usize),
                None => 0.0,
            }
        });
        Ok((share.is_some() || missing).then_some(image))
    }
}

/// Images as they are recorded, and how the first of them changes.
struct Recorded {
    images: Vec<Image>,
    changes: Vec<(Quantity, Image)>,
}

/// Indices of the pixels in the corners of `view`.
fn corners(view: View) -> [usize; 4] {
    [0, view.width - 1, view.pixels() - view.width, view.pixels() - 1]
}

fn places(view: View) -> Places {
    Places { width: view.width, height: view.height }
}

fn bend(imaging: &Imaging, view: View) -> Result<Bend> {
    let folded = || Error::OutOfRange {
        name: "perspective of the registration".into(),
        value: imaging.warp.get(crate::imaging::WarpParameter::KeystoneX),
        allowed: "one that does not fold the view",
    };
    imaging.warp.bend(places(view).half_diagonal_px()).ok_or_else(folded)
}

fn made((width, height): (usize, usize), value: impl Fn(usize) -> f64) -> Image {
    Image { width, height, data: (0..width * height).map(|i| value(i) as f32).collect() }
}

/// A scene as a camera records it.
pub(super) struct Imaged<'a> {
    light: Box<dyn ForwardModel + 'a>,
    recorder: Recorder,
    latest: RefCell<Option<(State, Rc<Rendering>)>>,
}

impl<'a> Imaged<'a> {
    /// What `recorder` records of `light`, the model of its own target.
    pub(super) fn new(light: Box<dyn ForwardModel + 'a>, recorder: Recorder) -> Self {
        Self { light, recorder, latest: RefCell::new(None) }
    }

    fn rendered(&self, state: &State) -> Result<Rc<Rendering>> {
        if let Some((of, rendering)) = &*self.latest.borrow()
            && of == state
        {
            return Ok(Rc::clone(rendering));
        }
        let light = self.light.rendering(&state.without_imaging())?;
        let rendering = Rc::new(self.recorder.rendering(&light, &imaging(state))?);
        *self.latest.borrow_mut() = Some((*state, Rc::clone(&rendering)));
        Ok(rendering)
    }
}

/// What the camera does at `state`.
fn imaging(state: &State) -> Imaging {
    state.imaging.unwrap_or_default()
}

impl ForwardModel for Imaged<'_> {
    fn image(&self, state: &State) -> Result<Image> {
        self.recorder.image(&self.light.image(&state.without_imaging())?, &imaging(state))
    }

    fn rendering(&self, state: &State) -> Result<Rendering> {
        Ok((*self.rendered(state)?).clone())
    }

    fn products(&self, state: &State, pixels: &Pixels) -> Result<Products> {
        Ok(Products::over(pixels, &*self.rendered(state)?))
    }

    fn levels(&self, state: &State, pixels: &Pixels) -> Result<Products> {
        Ok(Products::over(pixels, &Rendering::level(self.image(state)?)))
    }

    fn coverage(&self, state: &State) -> Result<Coverage> {
        let Coverage { served, cut } = self.light.coverage(&state.without_imaging())?;
        Ok(Coverage { served: served && self.recorder.serves(&imaging(state)), cut })
    }

    fn transforms(&self) -> usize {
        self.light.transforms()
    }
}
