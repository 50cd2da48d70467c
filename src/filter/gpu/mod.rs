//! The filter on a graphics adapter: the same planes, slices and tables as on the CPU, the rest in the shaders of
//! `shaders/`.
//!
//! Two real images are transformed as one complex one: two slices when a target is prepared, image and derivatives when
//! it is rendered. Spectra of the slices stay on the device; a render uploads the tables of its transfer functions and
//! reads back an image, or, in a fit, sums of products.

mod fft;
mod layout;
mod moving;
mod products;
mod render;
mod resident;
mod slab;
mod tables;

#[doc(hidden)]
pub mod shaders;

#[doc(hidden)]
pub use fft::FftPlan;
#[doc(hidden)]
pub use layout::{
    Canvas as CanvasLayout, Collect, Crop, Gather, NOTHING, Pass, ShiftBy, Source, Store, Sums, Total, Weigh,
    products,
};
pub use products::GpuObservation;
#[doc(hidden)]
pub use tables::Record;

use super::canvas::Canvas;
use super::cpu::Rendering;
use super::demand::reserve_planes;
use super::plan::{Coverage, Plan};
use super::shift::Shift;
use super::sources::Layer;
use super::{Optics, Target};
use crate::error::Result;
use crate::gpu::Gpu;
use crate::image::Image;
use crate::memory::Reservation;
use moving::Moving;
use render::Request;
use resident::Resident;
use slab::Slab;
use std::cell::OnceCell;
use wgpu::Buffer;

/// A target prepared on a graphics adapter for many renders.
pub struct GpuFilter<'a> {
    gpu: &'a Gpu,
    plan: Plan<'a>,
    canvas: Canvas,
    fft: FftPlan,
    /// From near to far; all but the first lie behind an occluder.
    slabs: Vec<Slab>,
    resident: Resident,
    /// What shifts take, from the first one on.
    moving: OnceCell<Moving>,
    _memory: Option<Reservation>,
}

impl<'a> GpuFilter<'a> {
    /// Prepares `target` for kernels up to as wide as those of `optics`, times `headroom`.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::Gpu`](crate::Error::Gpu) if the device cannot hold it.
    pub fn new(gpu: &'a Gpu, target: Target<'a>, optics: &Optics, headroom: f64) -> Result<Self> {
        Self::of(gpu, Plan::new(target, optics, headroom)?)
    }

    /// Prepares `target` with at most `count` slices along z between any two occluders and padding for kernels that reach
    /// `reach_px` pixels.
    ///
    /// # Errors
    /// [`Error::Gpu`](crate::Error::Gpu) if the device cannot hold it.
    pub fn with_slices(gpu: &'a Gpu, target: Target<'a>, count: usize, reach_px: f64) -> Result<Self> {
        Self::of(gpu, Plan::with_slices(target, count, reach_px)?)
    }

    pub(super) fn of(gpu: &'a Gpu, (plan, layers): (Plan<'a>, Vec<Layer>)) -> Result<Self> {
        let canvas = Canvas::new(&plan.target, plan.reach_px);
        // A software adapter lives in the machine's own memory.
        let software = gpu.adapter().software;
        let _memory = software.then(|| reserve_planes(&plan, &canvas, &layers)).transpose()?;
        let fft = FftPlan::new(gpu, canvas.fft.width, canvas.fft.height)?;
        let resident = Resident::new(gpu, &plan, &canvas, &layers)?;
        let slabs = (0..plan.slices.len())
            .map(|passed| Slab::new(gpu, (&plan, &layers), &canvas, &fft, &resident, passed))
            .collect::<Result<_>>()?;
        Ok(Self { gpu, plan, canvas, fft, slabs, resident, moving: OnceCell::new(), _memory })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        self.gpu
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

    /// Number of complex 2-D FFTs that one render takes, without and with the derivatives, and their size.
    pub fn transforms(&self) -> (usize, usize, [usize; 2]) {
        let images = (2 * self.slabs.len() - 1) * self.plan.obliquities.count();
        (images, 2 * images, [self.canvas.fft.width, self.canvas.fft.height])
    }

    /// Bytes that the stages of one render read and write on the device, without and with the derivatives: what no
    /// rearrangement of the same stages can save. Tables, which stay in caches, do not count.
    pub fn traffic(&self) -> (usize, usize) {
        let complex = size_of::<[f32; 2]>();
        let (canvas, view) = (self.canvas.pixels(), self.plan.target.view.pixels());
        let source = size_of::<Source>() * self.resident.layout.layers as usize;
        let of = |images: usize| {
            let pairs = images.div_ceil(2) * canvas * complex;
            let slab = |slab: &Slab| {
                let spectra: usize = slab.parts.iter().map(|part| part.spectra.size() as usize).sum();
                let fft = 2 * self.fft.passes() * pairs;
                // An occluder: light from it is read where it is gathered, passed, and transformed once more.
                let occluder = if slab.occluder.is_some() { 3 * pairs + canvas * source + fft } else { 0 };
                spectra + pairs + fft + occluder
            };
            let once: usize = self.slabs.iter().map(slab).sum();
            let collected = view * (images.div_ceil(2) * complex + source + images * size_of::<f32>());
            self.plan.obliquities.count() * (once + collected)
        };
        (of(1), of(4))
    }

    /// The image through the medium, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::Gpu`](crate::Error::Gpu) if the device fails.
    pub fn render(&self, optics: &Optics) -> Result<Image> {
        Ok(self.images(&Request { optics, derivatives: false, shift: None })?.swap_remove(0))
    }

    /// The image and its derivatives in sigma_s, sigma_a and B, over the target's view.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_with_gradient(&self, optics: &Optics) -> Result<Rendering> {
        let mut images = self.images(&Request { optics, derivatives: true, shift: None })?.into_iter();
        let mut next = || images.next().expect("four images were asked for");
        Ok(Rendering { image: next(), gradient: Some([next(), next(), next()]), motion: None })
    }

    /// The image moved by `shift_px` to the right and down, over the target's view: what [`render`](Self::render) has at
    /// x is at x + `shift_px`.
    ///
    /// # Errors
    /// As [`render`](Self::render), and [`Error::OutOfRange`](crate::Error::OutOfRange) for a shift that is not finite or
    /// is larger than the padded image.
    pub fn render_shifted(&self, optics: &Optics, shift_px: [f64; 2]) -> Result<Image> {
        let shift = Some(self.shift_by(shift_px)?);
        Ok(self.images(&Request { optics, derivatives: false, shift })?.swap_remove(0))
    }

    /// The moved image and its derivatives, also those in the shift, over the target's view.
    ///
    /// # Errors
    /// As [`render_shifted`](Self::render_shifted).
    pub fn render_shifted_with_gradient(&self, optics: &Optics, shift_px: [f64; 2]) -> Result<Rendering> {
        let shift = Some(self.shift_by(shift_px)?);
        let mut images = self.images(&Request { optics, derivatives: true, shift })?.into_iter();
        let mut next = || images.next().expect("six images were asked for");
        let (image, gradient) = (next(), [next(), next(), next()]);
        Ok(Rendering { image, gradient: Some(gradient), motion: Some([next(), next()]) })
    }

    /// Computes what is asked for and reads it back.
    fn images(&self, request: &Request) -> Result<Vec<Image>> {
        self.gpu.submit(self.evaluate(request)?)?;
        let (width, height) = (self.plan.target.view.width, self.plan.target.view.height);
        let all: Vec<f32> = self.gpu.read(self.planes(request)?, request.images() * width * height)?;
        let units = self.units(request.optics).0.into_iter().chain([1.0; 2]);
        let image = |(values, unit): (&[f32], f64)| {
            let data = values.iter().map(|v| (f64::from(*v) * unit) as f32).collect();
            Image { width, height, data }
        };
        Ok(all.chunks(width * height).zip(units).map(image).collect())
    }

    /// Where a render leaves its images over the view, one after the other.
    fn planes(&self, request: &Request) -> Result<&Buffer> {
        Ok(if request.shift.is_some() { &self.moving()?.planes } else { &self.resident.planes })
    }

    fn shift_by(&self, shift_px: [f64; 2]) -> Result<Shift> {
        Shift::new(&self.canvas.fft, shift_px)
    }
}
