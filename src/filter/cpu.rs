//! The fast path: f32 FFTs of a few depth slices, on all cores.
//!
//! A plan holds the transforms of the object weighted for each slice; they do not depend on the medium. A render
//! goes from far to near: the light behind each occluder is gathered there in the frequency domain, loses in the image
//! what the occluder covers, and is carried on to the next. Slices between two occluders share one inverse FFT; an occluder
//! costs one more, and a forward one. Derivatives cost three times as many (two if there is a single depth, where the
//! derivative in sigma_a is -z times the image). A perspective view takes a few renders, one for each of its
//! obliquities (`obliquity`).

use super::canvas::Canvas;
use super::demand::reserve_planes;
use super::obliquity::Obliquity;
use super::plan::{Coverage, Plan};
use super::shift::Shift;
use super::slab::Slab;
use super::slices::Slices;
use super::sources::Layer;
use super::{Optics, Target};
use crate::error::Result;
use crate::image::Image;
use crate::memory::Reservation;
use crate::spread::Model;

/// An image over the target's view and, if asked for, its derivatives in sigma_s, sigma_a and B.
#[derive(Debug, Clone)]
pub struct Rendering {
    /// Direct and scattered light of the object.
    pub image: Image,
    /// Derivatives of `image` in sigma_s (length), sigma_a (length) and B (1/rad²).
    pub gradient: Option<[Image; 3]>,
    /// Derivatives of `image` in the shift along x and y (1/px), if a shift was asked for.
    pub motion: Option<[Image; 2]>,
}

/// A target prepared for many renders.
pub struct CpuFilter<'a> {
    plan: Plan<'a>,
    canvas: Canvas,
    /// From near to far; all but the first lie behind an occluder.
    slabs: Vec<Slab>,
    _memory: Reservation,
}

impl<'a> CpuFilter<'a> {
    /// Prepares `target` for kernels up to as wide as those of `optics`, times `headroom`.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::Memory`](crate::Error::Memory).
    pub fn new(target: Target<'a>, optics: &Optics, headroom: f64) -> Result<Self> {
        Self::of(Plan::new(target, optics, headroom)?)
    }

    /// Prepares `target` with at most `count` slices along z between any two occluders and padding for kernels that reach
    /// `reach_px` pixels.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory).
    pub fn with_slices(target: Target<'a>, count: usize, reach_px: f64) -> Result<Self> {
        Self::of(Plan::with_slices(target, count, reach_px)?)
    }

    pub(super) fn of((plan, layers): (Plan<'a>, Vec<Layer>)) -> Result<Self> {
        let canvas = Canvas::new(&plan.target, plan.reach_px);
        let _memory = reserve_planes(&plan, &canvas, &layers)?;
        let slab = |(passed, slices): (usize, &Option<Slices>)| {
            Slab::new((&plan, &canvas), &layers, passed, slices.clone())
        };
        let slabs = plan.slices.iter().enumerate().map(slab).collect();
        Ok(Self { canvas, slabs, plan, _memory })
    }

    /// How far padding and slices serve the kernels of `optics` too.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn coverage(&self, optics: &Optics) -> Result<Coverage> {
        self.plan.coverage(optics)
    }

    /// Number of slices.
    pub fn slice_count(&self) -> usize {
        self.plan.slice_count()
    }

    /// Number of real 2-D FFTs that one render by a model of small angles takes, without and with the derivatives, and
    /// their size.
    pub fn transforms(&self) -> (usize, usize, [usize; 2]) {
        let images = (2 * self.slabs.len() - 1) * self.plan.obliquities.count();
        let with_derivatives = if self.plan.single_depth().is_some() { 3 * images } else { 4 * images };
        (images, with_derivatives, [self.canvas.fft.width, self.canvas.fft.height])
    }

    /// The image through the medium, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn render(&self, optics: &Optics) -> Result<Image> {
        Ok(self.seen(&self.planes(optics, 1)?[0]))
    }

    /// The image and its derivatives, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn render_with_gradient(&self, optics: &Optics) -> Result<Rendering> {
        let planes = self.planes(optics, 4)?;
        let [image, gradient @ ..] = [0, 1, 2, 3].map(|i| self.seen(&planes[i]));
        Ok(Rendering { image, gradient: Some(gradient), motion: None })
    }

    /// The image moved by `shift_px` to the right and down, over the target's view: what [`render`](Self::render) has at
    /// x is at x + `shift_px`.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::OutOfRange`](crate::Error::OutOfRange) for a shift that is not finite or is
    /// larger than the padded image.
    pub fn render_shifted(&self, optics: &Optics, shift_px: [f64; 2]) -> Result<Image> {
        let shift = Shift::new(&self.canvas.fft, shift_px)?;
        let image = self.planes(optics, 1)?.swap_remove(0);
        Ok(self.seen(&shift.moved(&self.canvas.fft, image)))
    }

    /// The moved image and its derivatives, also those in the shift, over the target's view.
    ///
    /// # Errors
    /// As [`render_shifted`](Self::render_shifted).
    pub fn render_shifted_with_gradient(&self, optics: &Optics, shift_px: [f64; 2]) -> Result<Rendering> {
        let shift = Shift::new(&self.canvas.fft, shift_px)?;
        let mut planes = self.planes(optics, 4)?.into_iter();
        let mut next = || planes.next().expect("four planes were asked for");
        let [image, x, y] = shift.moved_with_motion(&self.canvas.fft, next()).map(|plane| self.seen(&plane));
        let gradient = [next(), next(), next()].map(|plane| self.seen(&shift.moved(&self.canvas.fft, plane)));
        Ok(Rendering { image, gradient: Some(gradient), motion: Some([x, y]) })
    }

    /// The first `count` of image, d/d sigma_s, d/d sigma_a, d/d B, on the canvas.
    fn planes(&self, optics: &Optics, count: usize) -> Result<Vec<Vec<f32>>> {
        if optics.model == Model::BeerLambert {
            let mut planes = vec![vec![0.0; self.canvas.pixels()]; count];
            for slab in self.slabs.iter().rev() {
                slab.add_direct(&self.canvas, &optics.medium, 0.0, &mut planes);
                if let Some(mask) = &slab.occluder {
                    planes.iter_mut().for_each(|plane| mask.apply(plane));
                }
            }
            return Ok(planes);
        }
        let mut sum: Option<Vec<Vec<f32>>> = None;
        for (obliquity, weights) in self.plan.obliquities.iter() {
            let mut planes = self.scattered(optics, obliquity, count)?;
            if let Some(weights) = weights {
                planes.iter_mut().for_each(|plane| self.canvas.weigh(plane, self.plan.target.view, weights));
            }
            match &mut sum {
                None => sum = Some(planes),
                Some(sum) => {
                    let pairs = sum.iter_mut().flatten().zip(planes.iter().flatten());
                    pairs.for_each(|(s, v)| *s += v);
                }
            }
        }
        let mut planes = sum.expect("there is an obliquity");
        self.slabs[0].add_direct(&self.canvas, &optics.medium, 0.0, &mut planes);
        Ok(planes)
    }

    /// The same without the direct light of the first slab, for rays of one obliquity.
    fn scattered(&self, optics: &Optics, obliquity: Obliquity, count: usize) -> Result<Vec<Vec<f32>>> {
        // Light of small angles travels z, whatever is absorbed: d/d sigma_a is -z times the image.
        let single_depth = self.plan.single_depth().filter(|_| optics.model.rests_on_small_angles());
        let components: Vec<usize> = (0..count).filter(|&c| c != 2 || single_depth.is_none()).collect();
        let mut carried = None;
        for slab in self.slabs.iter().rev() {
            let spectra = slab.gather(&self.canvas, (optics, obliquity), carried.as_ref(), &components)?;
            let mut fields: Vec<Vec<f32>> = spectra.into_iter().map(|s| self.canvas.fft.inverse(s)).collect();
            if let Some(node) = single_depth.filter(|_| count == 4) {
                let z = obliquity.scaled(node).z as f32;
                fields.insert(2, fields[0].iter().map(|v| -z * v).collect());
            }
            match &slab.occluder {
                Some(mask) => carried = Some(slab.pass(mask, &self.canvas, &optics.medium, fields)),
                None => return Ok(fields),
            }
        }
        unreachable!("the first slab has no occluder")
    }

    /// The part of the canvas under the target's view.
    fn seen(&self, plane: &[f32]) -> Image {
        self.canvas.crop(plane, self.plan.target.view)
    }
}
