//! The depth-dependent filter: from the clear object to the image through the medium.
//!
//! Shinya et al., eq. 29: every object pixel j spreads its own light with the kernel of its own path length,
//! I(x) = T(z_x) L(x) + sum_j w_j(x - j) L(j). With a [`Relief`], near surfaces cover far ones and slopes count.
//!
//! Pixel convention: object radiance is constant over a pixel, and an observed pixel is the mean over its own
//! area. So direct light stays where it is, and w_j is the kernel's density integrated over object pixel j and
//! averaged over pixel x. Its transform is the scattered transfer function times sinc² in each axis, summed over
//! all its aliases ([`footprint`]).
//!
//! A photograph is otherwise ([`Sampling::Bandlimited`]): lens and pixel have averaged both images alike, and cancel. The
//! transform of w_j is then the scattered transfer function itself below half a cycle a pixel, without aliases.
//!
//! Four implementations, each tested against the one before: [`direct_sum`], the definition in real space, f64;
//! [`per_depth`], one f64 FFT for each distinct depth; [`cpu`], f32 FFTs of a few depth slices; [`gpu`], the same on a
//! graphics adapter.
//!
//! Border: outside the object image there is nothing (`zero`), the outermost pixel (`clamp`, as far as the kernel
//! reaches) or the mirrored image, periodically (`mirror`).

mod backend;
#[doc(hidden)]
pub mod basis;
#[doc(hidden)]
pub mod blur;
mod canvas;
#[doc(hidden)]
pub mod composite_sum;
pub mod cpu;
mod demand;
#[doc(hidden)]
pub mod direct_sum;
mod fft2;
#[doc(hidden)]
pub mod footprint;
#[cfg(feature = "gpu")]
pub mod gpu;
mod hidden;
#[doc(hidden)]
pub mod mixture;
mod moved;
mod obliquity;
#[doc(hidden)]
pub mod per_depth;
mod pixel_weights;
mod plan;
mod registration;
mod shift;
mod similarity;
mod slab;
#[doc(hidden)]
pub mod slices;
mod slope_correction;
mod sources;
pub mod spline;
mod tables;
mod transfer;
mod unit_cells;

pub use backend::{Backend, Prepared};
pub use cpu::Rendering;
pub use hidden::hidden_share;
pub use moved::{motion, moved};
pub use plan::{CUT, Coverage};
pub use registration::coarse_shift;
pub use similarity::coarse_similarity;

use crate::error::Result;
use crate::geometry::Geometry;
use crate::image::{Border, Image, Sampling, View};
use crate::medium::Medium;
use crate::relief::Relief;
use crate::spread::{Model, SpreadKernel};

/// What is filtered: one channel of the clear object, where it is, and the part of it that is observed.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// Clear radiance, one channel.
    pub radiance: &'a Image,
    /// Clear radiance of each of the geometry's further layers.
    pub behind: &'a [Image],
    /// Camera, distance of the object, medium surface.
    pub geometry: &'a Geometry,
    /// What lies outside the object image.
    pub border: Border,
    /// What lies between the pixels of the object image.
    pub sampling: Sampling,
    /// The observed part of the object image.
    pub view: View,
    /// Edges and slopes of the object to be reckoned with; without them every pixel's light spreads freely.
    pub relief: Option<&'a Relief>,
}

impl<'a> Target<'a> {
    /// One surface of constant pixels, whose light spreads freely.
    pub fn plain(radiance: &'a Image, geometry: &'a Geometry, border: Border, view: View) -> Self {
        Self { radiance, behind: &[], geometry, border, sampling: Sampling::Pixel, view, relief: None }
    }
}

/// A spread model with its medium: gives the kernel of any path length.
#[derive(Clone, Copy)]
pub struct Optics {
    /// The spread model.
    pub model: Model,
    /// The medium.
    pub medium: Medium,
}

impl Optics {
    /// The kernel after path length `z`.
    ///
    /// # Errors
    /// As [`Model::kernel`].
    pub fn kernel(&self, z: f64) -> Result<Box<dyn SpreadKernel>> {
        self.model.kernel(&self.medium, z)
    }
}

/// How depth maps are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Filter {
    /// `composite` where the depth map has edges or slopes, else `eq29`, which is the same there.
    Auto,
    /// Every object pixel spreads freely (Shinya et al., eq. 29).
    Eq29,
    /// Near surfaces cover far ones, and slopes count ([`Relief`]).
    Composite,
}

impl Filter {
    /// All filters.
    pub const ALL: [Filter; 3] = [Filter::Auto, Filter::Eq29, Filter::Composite];

    /// Name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Filter::Auto => "auto",
            Filter::Eq29 => "eq29",
            Filter::Composite => "composite",
        }
    }

    /// The relief with which this filter sees `geometry`.
    pub fn relief(self, geometry: &Geometry) -> Option<Relief> {
        match self {
            Filter::Eq29 => None,
            Filter::Composite => Some(Relief::new(geometry)),
            Filter::Auto => Some(Relief::new(geometry)).filter(|relief| !relief.is_flat()),
        }
    }

    /// The filter that renders a target with or without a relief.
    pub fn of(relief: Option<&Relief>) -> Self {
        if relief.is_some() { Filter::Composite } else { Filter::Eq29 }
    }
}
