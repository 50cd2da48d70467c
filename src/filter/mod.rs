//! The depth-dependent filter: from the clear object to the image through the medium.
//!
//! Shinya et al., eq. 29: every object pixel j spreads its own light with the kernel of its own path length,
//! I(x) = T(z_x) L(x) + sum_j w_j(x - j) L(j).
//!
//! Pixel convention: object radiance is constant over a pixel, and an observed pixel is the mean over its own
//! area. So direct light stays where it is, and w_j is the kernel's density integrated over object pixel j and
//! averaged over pixel x. Its transform is the scattered transfer function times sinc² in each axis, summed over
//! all its aliases ([`footprint`]).
//!
//! Three rungs, each tested against the one before: [`direct_sum`], the definition in real space, f64;
//! [`per_depth`], one f64 FFT for each distinct depth; [`cpu`], f32 FFTs of a few depth slices.
//!
//! Border: outside the object image there is nothing (`zero`), the outermost pixel (`clamp`, as far as the kernel
//! reaches) or the mirrored image, periodically (`mirror`).

mod chebyshev;
pub mod cpu;
pub mod direct_sum;
mod fft2;
pub mod footprint;
pub mod per_depth;
pub mod slices;
mod tables;
mod unit_cells;

use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::image::{Border, Image, View};
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use crate::spread::{Model, SpreadKernel};
use std::str::FromStr;

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
    /// The observed part of the object image.
    pub view: View,
}

/// A spread model with its medium and phase function: gives the kernel of any path length.
#[derive(Clone, Copy)]
pub struct Optics<'a> {
    /// The rung of the ladder.
    pub model: Model,
    /// sigma_s and sigma_a.
    pub medium: Medium,
    /// The phase function.
    pub phase: &'a dyn PhaseFunction,
}

impl<'a> Optics<'a> {
    /// The kernel after path length `z`.
    ///
    /// # Errors
    /// As [`Model::kernel`].
    pub fn kernel(&self, z: f64) -> Result<Box<dyn SpreadKernel + 'a>> {
        self.model.kernel(&self.medium, self.phase, z)
    }
}

/// How depth maps are filtered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Every object pixel spreads freely (Shinya et al., eq. 29).
    Eq29,
}

impl Filter {
    /// Name on the command line and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Filter::Eq29 => "eq29",
        }
    }
}

impl FromStr for Filter {
    type Err = Error;

    /// Parses a filter's name; `auto` is `eq29`, and `composite` is known but [not built yet](Error::NotBuilt).
    fn from_str(name: &str) -> Result<Self> {
        match name {
            "eq29" | "auto" => Ok(Filter::Eq29),
            "composite" => Err(Error::NotBuilt(format!("filter {name}"))),
            _ => Err(Error::UnknownName {
                what: "filter",
                name: name.into(),
                known: "auto, eq29, composite".into(),
            }),
        }
    }
}
