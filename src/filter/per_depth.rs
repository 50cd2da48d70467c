//! The second rung: f64, one FFT for each distinct depth, aliases summed one by one.
//!
//! No interpolation in depth, obliquity or frequency; proven against [`super::direct_sum`] on small images and used where that
//! would take too long.

use super::canvas::padded;
use super::fft2::Fft2;
use super::footprint::{aliases, baseband};
use super::obliquity::Obliquity;
use super::slices::Node;
use super::sources::sheets;
use super::{Optics, Target};
use crate::error::Result;
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
    let groups = pixels_by_node(target);
    let obliquities = pixels_by_obliquity(target);
    let mut reach: f64 = 0.0;
    for (node, _) in &groups {
        for (obliquity, _) in &obliquities {
            let node = obliquity.tilt(*node);
            reach = reach.max(optics.kernel(node.z)?.support(OUTSIDE) / node.pitch);
        }
    }
    let [px, py] = [target.radiance.width, target.radiance.height].map(|n| padded(n, target.border, reach));
    let fft = Fft2::<f64>::new(px.size, py.size);
    let source = |i: usize, margin: usize, n: usize| target.border.index(i as i64 - margin as i64, n);
    let spectrum = |(_, pixels): &Group| {
        let mut plane = vec![0.0; px.size * py.size];
        for j in 0..py.size {
            for i in 0..px.size {
                let x = source(i, px.margin, target.radiance.width);
                let y = source(j, py.margin, target.radiance.height);
                if let (Some(x), Some(y)) = (x, y)
                    && pixels.binary_search(&(y, x)).is_ok()
                {
                    plane[j * px.size + i] = f64::from(target.radiance.at(x, y));
                }
            }
        }
        fft.forward(plane)
    };
    let spectra: Vec<_> = groups.iter().map(spectrum).collect();
    let view = target.view;
    let mut image = vec![0.0; view.pixels()];
    for (obliquity, seen) in &obliquities {
        let mut sum = vec![Complex::new(0.0, 0.0); fft.half_width() * fft.height];
        for ((node, _), spectrum) in groups.iter().zip(&spectra) {
            let node = obliquity.tilt(*node);
            let kernel = optics.kernel(node.z)?;
            sum.par_chunks_mut(fft.height).zip(spectrum.par_chunks(fft.height)).enumerate().for_each(
                |(kx, (out, spectrum))| {
                    let wx = 2.0 * PI * kx as f64 / fft.width as f64;
                    for ky in 0..=fft.height / 2 {
                        let wy = 2.0 * PI * ky as f64 / fft.height as f64;
                        let transfer = baseband(&*kernel, node.pitch, wx, wy).value
                            + aliases(&*kernel, node.pitch, wx, wy, REACH).value;
                        out[ky] += spectrum[ky] * transfer;
                        if ky > 0 && 2 * ky < fft.height {
                            out[fft.height - ky] += spectrum[fft.height - ky] * transfer;
                        }
                    }
                },
            );
        }
        let scattered = fft.inverse(sum);
        for &i in seen {
            let (x, y) = (view.x + i % view.width, view.y + i / view.width);
            let direct = target.geometry.path_length(x, y).map_or(0.0, |z| optics.medium.transmittance(z));
            image[i] = direct * f64::from(target.radiance.at(x, y))
                + scattered[(y + py.margin) * px.size + x + px.margin];
        }
    }
    Ok(image)
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
    let object = &sheets(&Target { relief: None, ..*target })[0];
    for (i, source) in object.iter().enumerate() {
        if let Some(node) = source.map(|s| s.node) {
            let key = [node.z.to_bits(), node.pitch.to_bits()];
            let pixel = (i / target.radiance.width, i % target.radiance.width);
            groups.entry(key).or_insert_with(|| (node, Vec::new())).1.push(pixel);
        }
    }
    groups.into_values().collect()
}
