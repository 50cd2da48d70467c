//! The second implementation: f64, one FFT for each distinct depth, aliases summed one by one.
//!
//! No interpolation in depth, obliquity or frequency; proven against [`super::direct_sum`] on small images and used where that
//! would take too long.

use super::canvas::{Padded, nearest, padded};
use super::fft2::Fft2;
use super::footprint::transfer;
use super::obliquity::Obliquity;
use super::shift::Shift;
use super::slices::Node;
use super::sources::layers;
use super::{Optics, Target};
use crate::error::Result;
use crate::image::{Sampling, View};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Aliases summed one by one on each side.
const REACH: i32 = 6;
/// Share of a kernel's light that may fall beyond the padding.
const OUTSIDE: f64 = 1e-8;

/// The image through the medium over the target's view, row-major. Kernels whose light falls like 1/r without end, as
/// Henyey-Greenstein's in small-angle theory, would need an endless image: [`direct_sum`](super::direct_sum) serves for them.
///
/// # Errors
/// As [`Optics::kernel`].
pub fn render(target: &Target, optics: &Optics) -> Result<Vec<f64>> {
    let canvas = Canvas::new(target, optics)?;
    Ok(canvas.seen(&canvas.image(target, optics)?, target.view))
}

/// The same moved by `shift_px` to the right and down.
///
/// # Errors
/// As [`Optics::kernel`], and [`Error::OutOfRange`](crate::Error::OutOfRange) for a shift that is not finite or is larger
/// than the padded image.
pub fn render_shifted(target: &Target, optics: &Optics, shift_px: [f64; 2]) -> Result<Vec<f64>> {
    let canvas = Canvas::new(target, optics)?;
    let moved = Shift::new(&canvas.fft, shift_px)?.moved(&canvas.fft, canvas.image(target, optics)?);
    Ok(canvas.seen(&moved, target.view))
}

/// The padded image.
struct Canvas {
    fft: Fft2<f64>,
    /// Across and down.
    padded: [Padded; 2],
    sampling: Sampling,
    /// For each column and row the object's that it shows.
    shown: [Vec<Option<usize>>; 2],
}

impl Canvas {
    /// The canvas of `target` for kernels as wide as those of `optics`.
    fn new(target: &Target, optics: &Optics) -> Result<Self> {
        let mut reach: f64 = 0.0;
        for (node, _) in &pixels_by_node(target) {
            for (obliquity, _) in &pixels_by_obliquity(target) {
                let node = obliquity.scaled(*node);
                reach = reach.max(optics.kernel(node.z)?.support(OUTSIDE) / node.pitch);
            }
        }
        let object = [target.radiance.width, target.radiance.height];
        let padded = object.map(|n| padded(n, target.border, reach));
        let shown = [0, 1].map(|axis| {
            let Padded { size, margin } = padded[axis];
            (0..size).map(|i| target.border.index(i as i64 - margin as i64, object[axis])).collect()
        });
        Ok(Self { fft: Fft2::new(padded[0].size, padded[1].size), padded, sampling: target.sampling, shown })
    }

    /// What `value` has for the object pixel (x, y) that each pixel shows, 0 where it shows none.
    fn filled(&self, value: impl Fn(usize, usize) -> f64) -> Vec<f64> {
        let [columns, rows] = &self.shown;
        let at = |y: &Option<usize>, x: &Option<usize>| y.zip(*x).map_or(0.0, |(y, x)| value(x, y));
        rows.iter().flat_map(|y| columns.iter().map(move |x| (y, x))).map(|(y, x)| at(y, x)).collect()
    }

    /// All light that arrives; what lies outside the view is seen as by the nearest pixel of the view.
    fn image(&self, target: &Target, optics: &Optics) -> Result<Vec<f64>> {
        let radiance = |x: usize, y: usize| f64::from(target.radiance.at(x, y));
        let groups = pixels_by_node(target);
        let spectrum = |(_, pixels): &Group| {
            let own = |x, y| if pixels.binary_search(&(y, x)).is_ok() { radiance(x, y) } else { 0.0 };
            self.fft.forward(self.filled(own))
        };
        let spectra: Vec<_> = groups.iter().map(spectrum).collect();
        let mut image = self.filled(|x, y| {
            let direct = target.geometry.path_length(x, y).map_or(0.0, |z| optics.medium.transmittance(z));
            direct * radiance(x, y)
        });
        let view = target.view;
        let [columns, rows] = [(0, view.x, view.width), (1, view.y, view.height)]
            .map(|(axis, start, length)| nearest((start, length), self.padded[axis]));
        for (obliquity, seen) in pixels_by_obliquity(target) {
            let scattered = self.scattered(optics, obliquity, groups.iter().map(|g| g.0).zip(&spectra))?;
            let mut mine = vec![false; view.pixels()];
            seen.iter().for_each(|&i| mine[i] = true);
            for (at, (v, scattered)) in image.iter_mut().zip(scattered).enumerate() {
                if mine[rows[at / self.fft.width] * view.width + columns[at % self.fft.width]] {
                    *v += scattered;
                }
            }
        }
        Ok(image)
    }

    /// The scattered light of all nodes, by their spectra, for rays of one obliquity.
    fn scattered<'s>(
        &self,
        optics: &Optics,
        obliquity: Obliquity,
        spectra: impl Iterator<Item = (Node, &'s Vec<Complex<f64>>)>,
    ) -> Result<Vec<f64>> {
        let fft = &self.fft;
        let mut sum = vec![Complex::new(0.0, 0.0); fft.half_width() * fft.height];
        for (node, spectrum) in spectra {
            let node = obliquity.scaled(node);
            let kernel = optics.kernel(node.z)?;
            sum.par_chunks_mut(fft.height).zip(spectrum.par_chunks(fft.height)).enumerate().for_each(
                |(kx, (out, spectrum))| {
                    let wx = 2.0 * PI * kx as f64 / fft.width as f64;
                    for ky in 0..=fft.height / 2 {
                        let wy = 2.0 * PI * ky as f64 / fft.height as f64;
                        let transfer = transfer(&*kernel, node.pitch, [wx, wy], self.sampling, REACH).value;
                        out[ky] += spectrum[ky] * transfer;
                        if ky > 0 && 2 * ky < fft.height {
                            out[fft.height - ky] += spectrum[fft.height - ky] * transfer;
                        }
                    }
                },
            );
        }
        Ok(fft.inverse(sum))
    }

    /// The part of `image` under `view`, row-major.
    fn seen(&self, image: &[f64], view: View) -> Vec<f64> {
        let [across, down] = self.padded;
        let row = |y: usize| &image[(view.y + y + down.margin) * across.size + view.x + across.margin..];
        (0..view.height).flat_map(|y| row(y)[..view.width].to_vec()).collect()
    }
}

/// The view's pixels (row-major index) under each obliquity of their rays, in order.
pub(super) fn pixels_by_obliquity(target: &Target) -> Vec<(Obliquity, Vec<usize>)> {
    let view = target.view;
    let mut groups: BTreeMap<u64, (Obliquity, Vec<usize>)> = BTreeMap::new();
    for i in 0..view.pixels() {
        let cosine = target.geometry.cos_off_axis(view.x + i % view.width, view.y + i / view.width);
        // Pixels at mirrored places have the same cosine up to rounding.
        let key = (cosine * 1e12).round() as u64;
        groups.entry(key).or_insert_with(|| (Obliquity { cosine }, Vec::new())).1.push(i);
    }
    groups.into_values().collect()
}

/// A path length and pitch, and the pixels (row, column) that have it, in order.
pub(super) type Group = (Node, Vec<(usize, usize)>);

/// The object's pixels under each distinct path length and pitch.
pub(super) fn pixels_by_node(target: &Target) -> Vec<Group> {
    let mut groups: BTreeMap<[u64; 2], Group> = BTreeMap::new();
    let object = &layers(&Target { relief: None, ..*target })[0];
    for (i, source) in object.iter().enumerate() {
        if let Some(node) = source.map(|s| s.node) {
            let key = [node.z.to_bits(), node.pitch.to_bits()];
            let pixel = (i / target.radiance.width, i % target.radiance.width);
            groups.entry(key).or_insert_with(|| (node, Vec::new())).1.push(pixel);
        }
    }
    groups.into_values().collect()
}
