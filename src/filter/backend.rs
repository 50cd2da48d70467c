//! Where the filter runs.

use super::cpu::{CpuFilter, Rendering};
#[cfg(feature = "gpu")]
use super::gpu::GpuFilter;
use super::plan::{Coverage, Plan};
use super::sources::Layer;
use super::{Optics, Target};
use crate::error::Result;
#[cfg(feature = "gpu")]
use crate::gpu::Gpu;
use crate::image::Image;
use crate::relief::Relief;

/// What computes renders.
#[derive(Clone, Copy, Default)]
pub enum Backend<'a> {
    /// All cores of this machine.
    #[default]
    Cpu,
    /// A graphics adapter.
    #[cfg(feature = "gpu")]
    Gpu(&'a Gpu),
    /// Cannot be made: holds the lifetime where there is no device to hold it.
    #[cfg(not(feature = "gpu"))]
    #[doc(hidden)]
    Never(std::convert::Infallible, std::marker::PhantomData<&'a ()>),
}

/// A target prepared for many renders.
pub enum Prepared<'a> {
    /// On the CPU.
    Cpu(Box<CpuFilter<'a>>),
    /// On a graphics adapter.
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuFilter<'a>>),
}

impl<'a> Backend<'a> {
    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Backend::Cpu => "cpu",
            #[cfg(feature = "gpu")]
            Backend::Gpu(_) => "gpu",
        }
    }

    /// The graphics adapter, if it is one.
    pub fn adapter(self) -> Option<String> {
        match self {
            Backend::Cpu => None,
            #[cfg(feature = "gpu")]
            Backend::Gpu(gpu) => Some(gpu.adapter().to_string()),
        }
    }

    /// Prepares `target` for kernels up to as wide as those of `optics`, times `headroom`.
    ///
    /// # Errors
    /// As [`Optics::kernel`], [`Error::Memory`](crate::Error::Memory), and [`Error::Gpu`](crate::Error::Gpu) if the device cannot
    /// hold it.
    pub fn prepare(self, target: Target<'a>, optics: &Optics, headroom: f64) -> Result<Prepared<'a>> {
        self.prepare_for_shifts(target, optics, headroom, 0.0)
    }

    /// The same with padding for shifts of up to `shift_px` beside that for the kernels, so that nothing that a shift
    /// moves past one end of the padded image enters the view from the other.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare).
    pub fn prepare_for_shifts(
        self,
        target: Target<'a>,
        optics: &Optics,
        headroom: f64,
        shift_px: f64,
    ) -> Result<Prepared<'a>> {
        let (plan, layers) = Plan::new(target, optics, headroom)?;
        self.of((plan.padded_by(shift_px), layers))
    }

    /// Prepares `target` with at most `count` slices along z between any two occluders and padding for kernels that reach
    /// `reach_px` pixels.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory), and [`Error::Gpu`](crate::Error::Gpu) if the device cannot hold it.
    pub fn prepare_slices(self, target: Target<'a>, count: usize, reach_px: f64) -> Result<Prepared<'a>> {
        self.of(Plan::with_slices(target, count, reach_px)?)
    }

    /// Prepares radiance 1 on the surfaces inpainted behind the occluders of `relief`.
    pub(super) fn prepare_hidden(
        self,
        target: Target<'a>,
        relief: &Relief,
        optics: &Optics,
    ) -> Result<Prepared<'a>> {
        self.of(Plan::of_hidden(target, relief, optics)?)
    }

    fn of(self, plan: (Plan<'a>, Vec<Layer>)) -> Result<Prepared<'a>> {
        Ok(match self {
            Backend::Cpu => Prepared::Cpu(Box::new(CpuFilter::of(plan)?)),
            #[cfg(feature = "gpu")]
            Backend::Gpu(gpu) => Prepared::Gpu(Box::new(GpuFilter::of(gpu, plan)?)),
        })
    }
}

impl Prepared<'_> {
    /// How far padding and slices serve the kernels of `optics` too.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn coverage(&self, optics: &Optics) -> Result<Coverage> {
        match self {
            Prepared::Cpu(filter) => filter.coverage(optics),
            #[cfg(feature = "gpu")]
            Prepared::Gpu(filter) => filter.coverage(optics),
        }
    }

    /// Number of 2-D FFTs that one render takes, without and with the derivatives, and their size; real ones on the
    /// CPU, complex ones on a graphics adapter.
    pub fn transforms(&self) -> (usize, usize, [usize; 2]) {
        match self {
            Prepared::Cpu(filter) => filter.transforms(),
            #[cfg(feature = "gpu")]
            Prepared::Gpu(filter) => filter.transforms(),
        }
    }

    /// The image through the medium, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::Gpu`](crate::Error::Gpu) if the device fails.
    pub fn render(&self, optics: &Optics) -> Result<Image> {
        match self {
            Prepared::Cpu(filter) => filter.render(optics),
            #[cfg(feature = "gpu")]
            Prepared::Gpu(filter) => filter.render(optics),
        }
    }

    /// The image and its derivatives, over the target's view.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_with_gradient(&self, optics: &Optics) -> Result<Rendering> {
        match self {
            Prepared::Cpu(filter) => filter.render_with_gradient(optics),
            #[cfg(feature = "gpu")]
            Prepared::Gpu(filter) => filter.render_with_gradient(optics),
        }
    }

    /// The image moved by `shift_px` to the right and down, over the target's view: what [`render`](Self::render) has at
    /// x is at x + `shift_px`.
    ///
    /// # Errors
    /// As [`render`](Self::render), and [`Error::OutOfRange`](crate::Error::OutOfRange) for a shift that is not finite or
    /// is larger than the padded image.
    pub fn render_shifted(&self, optics: &Optics, shift_px: [f64; 2]) -> Result<Image> {
        match self {
            Prepared::Cpu(filter) => filter.render_shifted(optics, shift_px),
            #[cfg(feature = "gpu")]
            Prepared::Gpu(filter) => filter.render_shifted(optics, shift_px),
        }
    }

    /// The moved image and its derivatives, also those in the shift, over the target's view.
    ///
    /// # Errors
    /// As [`render_shifted`](Self::render_shifted).
    pub fn render_shifted_with_gradient(&self, optics: &Optics, shift_px: [f64; 2]) -> Result<Rendering> {
        match self {
            Prepared::Cpu(filter) => filter.render_shifted_with_gradient(optics, shift_px),
            #[cfg(feature = "gpu")]
            Prepared::Gpu(filter) => filter.render_shifted_with_gradient(optics, shift_px),
        }
    }
}
