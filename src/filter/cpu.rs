//! The fast path: f32 FFTs of a few depth slices, on all cores.
//!
//! A plan holds the transforms of the object weighted for each slice; they do not depend on the medium. A render
//! then costs one inverse FFT, its three derivatives three more (two if there is a single depth, where the
//! derivative in sigma_a is -z times the image), and one evaluation of each slice's transfer function a frequency.

use super::fft2::{Fft2, fast_size};
use super::footprint::sinc2;
use super::slices::{Slices, pixel_node};
use super::tables::{AliasTable, Basis, Lanes, RadialTable};
use super::{Optics, Target};
use crate::error::Result;
use crate::geometry::Field;
use crate::image::{Border, Image};
use crate::spread::Model;
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// An image over the target's view and, if asked for, its derivatives in sigma_s, sigma_a and B.
#[derive(Debug, Clone)]
pub struct Rendering {
    /// Direct and scattered light of the object.
    pub image: Image,
    /// Derivatives of `image` in sigma_s (length), sigma_a (length) and B (1/rad²).
    pub gradient: Option<[Image; 3]>,
}

/// How far a plan serves some kernels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coverage {
    /// Whether its slices suffice, and its padding as far as any would.
    pub served: bool,
    /// Whether the kernels reach beyond the most padding there is, so that light that should leave the image comes
    /// back on its other side.
    pub cut: bool,
}

/// Share of a kernel's light that may fall beyond the padding.
const OUTSIDE: f64 = 1e-5;
/// Largest error of the slices' transfer functions, as a share of the scattered light.
const SLICE_TOLERANCE: f64 = 1e-4;
/// What to tell a user of [`Coverage::cut`].
pub const CUT: &str = "the kernel reaches beyond the most padding there is: light that should leave the image comes \
                       back on its other side; use fewer pixels for the same scene, or a mirrored border";
/// Padding stops at this size of the padded image, or at two image sides if that is more, which bounds memory; what
/// a kernel throws farther comes back on the other side, see [`Coverage::cut`].
const MOST_PADDED_PX: usize = 4096;

/// A target prepared for many renders.
pub struct CpuFilter<'a> {
    target: Target<'a>,
    reach_px: f64,
    slices: Slices,
    fft: Fft2<f32>,
    margin: [usize; 2],
    spectra: Vec<Vec<Complex<f32>>>,
    axes: [Axis; 2],
    depths: Field,
}

impl<'a> CpuFilter<'a> {
    /// Prepares `target` for kernels up to as wide as those of `optics`, times `headroom`.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn new(target: Target<'a>, optics: &Optics, headroom: f64) -> Result<Self> {
        let slices = Slices::for_tolerance(&target, optics, SLICE_TOLERANCE)?;
        let reach_px = headroom * reach_px(&slices, optics)?;
        Ok(Self::with_slices(target, slices, reach_px))
    }

    /// Prepares `target` with these slices and padding for kernels that reach `reach_px` pixels.
    pub fn with_slices(target: Target<'a>, slices: Slices, reach_px: f64) -> Self {
        let [x, y] = [target.radiance.width, target.radiance.height]
            .map(|n| padded(n, target.border, reach_px.min(most_reach(&target))));
        let fft = Fft2::new(x.size, y.size);
        let margin = [x.margin, y.margin];
        let planes = weighted_objects(&target, &slices, [x, y]);
        let spectra = planes.into_iter().map(|plane| fft.forward(plane)).collect();
        let axes = [Axis::new(x.size), Axis::new(y.size)];
        let depths = view_depths(&target);
        Self { target, reach_px, slices, fft, margin, spectra, axes, depths }
    }

    /// How far padding and slices serve the kernels of `optics` too.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn coverage(&self, optics: &Optics) -> Result<Coverage> {
        let (reach, most) = (reach_px(&self.slices, optics)?, most_reach(&self.target));
        Ok(Coverage {
            served: reach.min(most) <= self.reach_px
                && self.slices.error(&self.target, optics)? <= SLICE_TOLERANCE,
            cut: self.target.border != Border::Mirror && reach > most,
        })
    }

    /// Number of slices.
    pub fn slice_count(&self) -> usize {
        self.slices.nodes.len()
    }

    /// Number of real 2-D FFTs that one render takes, without and with the derivatives, and their size.
    pub fn transforms(&self) -> (usize, usize, [usize; 2]) {
        (1, if self.slice_count() == 1 { 3 } else { 4 }, [self.fft.width, self.fft.height])
    }

    /// The image through the medium, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn render(&self, optics: &Optics) -> Result<Image> {
        Ok(self.evaluate(optics, 1)?.swap_remove(0))
    }

    /// The image and its derivatives, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn render_with_gradient(&self, optics: &Optics) -> Result<Rendering> {
        let mut planes = self.evaluate(optics, 4)?.into_iter();
        let mut next = || planes.next().expect("four planes were asked for");
        Ok(Rendering { image: next(), gradient: Some([next(), next(), next()]) })
    }

    /// The first `count` of image, d/d sigma_s, d/d sigma_a, d/d B.
    fn evaluate(&self, optics: &Optics, count: usize) -> Result<Vec<Image>> {
        let mut planes = self.direct(optics, count);
        if optics.model != Model::BeerLambert {
            let single = self.slice_count() == 1;
            let transformed: Vec<usize> = (0..count).filter(|&c| c != 2 || !single).collect();
            let spectra = self.scattered_spectra(optics, &transformed)?;
            for (&c, spectrum) in transformed.iter().zip(spectra) {
                self.add_view(&mut planes[c], &self.fft.inverse(spectrum));
            }
            if single && count == 4 {
                let z = self.slices.nodes[0].z as f32;
                planes[2] =
                    Image { data: planes[0].data.iter().map(|v| -z * v).collect(), ..planes[0].clone() };
            }
        }
        Ok(planes)
    }

    /// T(z) L at every pixel of the view, and its derivatives.
    fn direct(&self, optics: &Optics, count: usize) -> Vec<Image> {
        let Target { radiance, view, .. } = self.target;
        let mut planes = vec![Image::filled(view.width, view.height, 0.0); count];
        let once = match self.depths {
            Field::Uniform(z) => Some((z, optics.medium.transmittance(z))),
            Field::Map(_) => None,
        };
        for i in 0..view.pixels() {
            let (x, y) = (i % view.width, i / view.width);
            let (z, transmittance) = once.unwrap_or_else(|| {
                let z = self.depths.at(x, y);
                (z, optics.medium.transmittance(z))
            });
            if transmittance > 0.0 {
                let light = transmittance as f32 * radiance.at(view.x + x, view.y + y);
                for (plane, factor) in planes.iter_mut().zip([1.0, -z, -z, 0.0]) {
                    plane.data[i] = factor as f32 * light;
                }
            }
        }
        planes
    }

    /// Spectra of the scattered light: the sum over slices of transfer function times weighted object, for each of
    /// the `components` (0 the image, 1-3 its derivatives).
    fn scattered_spectra(&self, optics: &Optics, components: &[usize]) -> Result<Vec<Vec<Complex<f32>>>> {
        let (half, height) = (self.fft.half_width(), self.fft.height);
        let tables = self
            .slices
            .nodes
            .par_iter()
            .map(|node| {
                let kernel = optics.kernel(node.z)?;
                Ok((RadialTable::new(&*kernel, node.pitch), AliasTable::new(&*kernel, node.pitch)))
            })
            .collect::<Result<Vec<_>>>()?;
        let mut sums = vec![vec![Complex::new(0.0, 0.0); half * height]; components.len()];
        let mut columns: Vec<Vec<&mut [Complex<f32>]>> = (0..half).map(|_| Vec::new()).collect();
        for sum in &mut sums {
            for (column, part) in columns.iter_mut().zip(sum.chunks_mut(height)) {
                column.push(part);
            }
        }
        let [across, down] = &self.axes;
        columns.into_par_iter().enumerate().for_each(|(kx, mut column)| {
            for ((radial, alias), spectrum) in tables.iter().zip(&self.spectra) {
                let spectrum = &spectrum[kx * height..(kx + 1) * height];
                let line = alias.line(&across.basis[kx]);
                for ky in 0..=height / 2 {
                    let weight = across.sinc2[kx] * down.sinc2[ky];
                    let base = radial.at((across.w[kx].powi(2) + down.w[ky].powi(2)).sqrt());
                    let beyond = line.at(&down.basis[ky]);
                    let transfer: Lanes = std::array::from_fn(|c| weight * base[c] + beyond[c]);
                    for (out, &c) in column.iter_mut().zip(components) {
                        out[ky] += spectrum[ky] * transfer[c];
                        if ky > 0 && 2 * ky < height {
                            out[height - ky] += spectrum[height - ky] * transfer[c];
                        }
                    }
                }
            }
        });
        Ok(sums)
    }

    fn add_view(&self, plane: &mut Image, padded: &[f32]) {
        let view = self.target.view;
        for y in 0..view.height {
            let start = (view.y + y + self.margin[1]) * self.fft.width + view.x + self.margin[0];
            let row = &mut plane.data[y * view.width..(y + 1) * view.width];
            row.iter_mut().zip(&padded[start..]).for_each(|(p, v)| *p += v);
        }
    }
}

/// The frequencies 0 to pi rad/px of one axis, and what the transfer function needs at each.
struct Axis {
    w: Vec<f64>,
    sinc2: Vec<f32>,
    basis: Vec<Basis>,
}

impl Axis {
    fn new(n: usize) -> Self {
        let w: Vec<f64> = (0..=n / 2).map(|i| 2.0 * PI * i as f64 / n as f64).collect();
        let sinc2 = w.iter().map(|&w| sinc2(w, 0) as f32).collect();
        Self { w, sinc2, basis: AliasTable::basis(n) }
    }
}

/// Path lengths over the view; infinite where there is no object, which lets no light through.
fn view_depths(target: &Target) -> Field {
    let (geometry, view) = (target.geometry, target.view);
    match (&geometry.depth, &geometry.surface) {
        (Field::Uniform(depth), Field::Uniform(surface)) => Field::Uniform(depth - surface),
        _ => Field::Map(Image::from_fn(view.width, view.height, |x, y| {
            geometry.path_length(view.x + x, view.y + y).map_or(f32::INFINITY, |z| z as f32)
        })),
    }
}

/// Radius in pixels beyond which less than [`OUTSIDE`] of the light of any slice falls.
fn reach_px(slices: &Slices, optics: &Optics) -> Result<f64> {
    let mut reach: f64 = 0.0;
    for node in &slices.nodes {
        reach = reach.max(optics.kernel(node.z)?.support(OUTSIDE) / node.pitch);
    }
    Ok(reach)
}

/// The farthest reach that the padding serves, px.
fn most_reach(target: &Target) -> f64 {
    let side = target.radiance.width.max(target.radiance.height);
    let sides = if target.border == Border::Clamp { 2 } else { 1 };
    (MOST_PADDED_PX.saturating_sub(side) / sides).max(2 * side) as f64
}

/// One axis of the padded image: its size, and where the object image begins in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Padded {
    pub size: usize,
    pub margin: usize,
}

/// Padding of `n` pixels so that what wraps around comes from beyond `reach_px`.
pub(super) fn padded(n: usize, border: Border, reach_px: f64) -> Padded {
    let reach = reach_px.ceil() as usize;
    match border {
        Border::Zero => Padded { size: fast_size(n + reach), margin: 0 },
        Border::Clamp => {
            let size = fast_size(n + 2 * reach);
            Padded { size, margin: (size - n) / 2 }
        }
        Border::Mirror => Padded { size: 2 * n, margin: 0 },
    }
}

/// The padded object image weighted for each slice.
fn weighted_objects(target: &Target, slices: &Slices, [px, py]: [Padded; 2]) -> Vec<Vec<f32>> {
    let Target { radiance, border, .. } = *target;
    let mut planes = vec![vec![0.0; px.size * py.size]; slices.nodes.len()];
    let source = |i: usize, p: Padded, n: usize| border.index(i as i64 - p.margin as i64, n);
    let columns: Vec<Option<usize>> = (0..px.size).map(|i| source(i, px, radiance.width)).collect();
    for j in 0..py.size {
        let Some(y) = source(j, py, radiance.height) else { continue };
        for (i, column) in columns.iter().enumerate() {
            let Some(x) = *column else { continue };
            let Some(node) = pixel_node(target, x, y) else { continue };
            for (plane, weight) in planes.iter_mut().zip(slices.weights(node)) {
                plane[j * px.size + i] = weight as f32 * radiance.at(x, y);
            }
        }
    }
    planes
}
