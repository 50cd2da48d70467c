//! Kernels as numbers: density, encircled energy and transfer function on one grid.

use super::Setting;
use crate::error::{Error, Result};
use crate::phase::PhaseFunction;
use crate::spread::{Model, SpreadKernel, typical_radius};
use crate::trace::{Estimate, RadialProfile, log_spaced};
use rayon::prelude::*;

/// Radii, and frequencies other than 0.
const COUNT: usize = 80;

/// Radii begin at this many kernel widths z sqrt(B), or z (1-g)/sqrt(g).
const INNERMOST: f64 = 1e-2;

/// Radii end at this many kernel widths, or at [`FARTHEST_RMS`] typical radii where many scatterings make
/// the kernel wider than that.
const FARTHEST: f64 = 20.0;

/// See [`FARTHEST`].
const FARTHEST_RMS: f64 = 6.0;

/// Frequencies k begin and end at this many inverse radii: from where the kernel is a point to where it is flat.
const PHASE: f64 = 0.2;

/// Number of edges of the tally beyond the radii shown, a factor of some hundred: the transfer function
/// of the lowest frequencies needs the light there too.
const MARGIN: usize = 240;

/// Where the kernels are evaluated.
#[derive(Debug)]
pub(super) struct Grid {
    /// Radii, evenly spaced in their logarithm, length.
    pub radii: Vec<f64>,
    /// 0 and frequencies evenly spaced in their logarithm, rad/length.
    pub frequencies: Vec<f64>,
}

impl Grid {
    /// The grid that shows the kernels of `setting`.
    pub(super) fn new(setting: &Setting) -> Self {
        let Setting { medium, z } = *setting;
        let width = z * medium.phase().planar_width();
        let radius = typical_radius(&medium, z);
        let (first, last) = (INNERMOST * width, (FARTHEST * width).max(FARTHEST_RMS * radius));
        let mut frequencies = vec![0.0];
        frequencies.extend(log_spaced(PHASE / last, PHASE / first, COUNT));
        Self { radii: log_spaced(first, last, COUNT), frequencies }
    }

    /// Edges of a tally: each radius, the geometric means between them, and a margin. Radius `i` is edge `2 i + 1`.
    pub(super) fn edges(&self) -> Vec<f64> {
        let half_step = (self.radii[1] / self.radii[0]).sqrt();
        let edge = |i: usize| match i % 2 {
            1 if i / 2 < COUNT => self.radii[i / 2],
            _ => self.radii[0] * half_step.powi(i as i32 - 1),
        };
        (0..2 * COUNT + 1 + MARGIN).map(edge).collect()
    }
}

/// One kernel on the grid. Everything is a share of the light that set out.
#[derive(Debug)]
pub(super) struct Curve {
    /// The model's name, or `traced`.
    pub name: &'static str,
    /// Density of scattered light at each radius, 1/area.
    pub psf: Vec<f64>,
    /// Scattered light within each radius.
    pub encircled: Vec<f64>,
    /// Transfer function at each frequency, direct light included.
    pub mtf: Vec<f64>,
    /// Standard errors, where the numbers are measured.
    pub errors: Option<Errors>,
}

/// Standard errors of a traced [`Curve`].
#[derive(Debug)]
pub(super) struct Errors {
    pub psf: Vec<f64>,
    pub encircled: Vec<f64>,
    pub mtf: Vec<f64>,
}

impl Curve {
    /// The curve of a model.
    ///
    /// # Errors
    /// [`Error::NotFinite`] with model and place.
    pub(super) fn of_kernel(model: Model, kernel: &dyn SpreadKernel, grid: &Grid) -> Result<Self> {
        let at = |places: &[f64], name: &str, f: &(dyn Fn(f64) -> f64 + Sync)| -> Result<Vec<f64>> {
            let one = |&x: &f64| match f(x) {
                value if value.is_finite() => Ok(value),
                value => Err(Error::NotFinite(format!("{model}: {name} = {x:e} gives {value}"))),
            };
            places.par_iter().map(one).collect()
        };
        Ok(Self {
            name: model.name(),
            psf: at(&grid.radii, "r", &|r| kernel.psf(r))?,
            encircled: at(&grid.radii, "r", &|r| kernel.encircled_energy(r))?,
            mtf: at(&grid.frequencies, "k", &|k| kernel.mtf(k).value)?,
            errors: None,
        })
    }

    /// The curve of light traced with the grid's [edges](Grid::edges). The density at a radius is the mean over the
    /// annulus between the edges beside it, which are 5 % apart: too high or low by some 0.1 %.
    pub(super) fn of_profile(profile: &RadialProfile, grid: &Grid) -> Self {
        let split = |estimates: Vec<Estimate>| -> (Vec<f64>, Vec<f64>) {
            estimates.iter().map(|e| (e.value, e.std_error)).unzip()
        };
        let (psf, psf_errors) = split((0..COUNT).map(|i| profile.density(2 * i, 2 * i + 2)).collect());
        let (encircled, encircled_errors) =
            split((0..COUNT).map(|i| profile.encircled_energy(2 * i + 1)).collect());
        let (mtf, mtf_errors) = split(grid.frequencies.iter().map(|&k| profile.mtf(k)).collect());
        let errors = Errors { psf: psf_errors, encircled: encircled_errors, mtf: mtf_errors };
        Self { name: "traced", psf, encircled, mtf, errors: Some(errors) }
    }
}
