//! The padded image on which the transforms work.

use super::Target;
use super::fft2::{Fft2, fast_size};
use super::footprint::pixel_factor;
use super::tables::{AliasTable, Basis};
use crate::image::{Border, Image, Sampling, View};
use rayon::prelude::*;
use rustfft::num_complex::Complex;
use std::f64::consts::PI;

/// Padding stops at this size of the padded image, or at two image sides if that is more, which bounds memory; what
/// a kernel throws farther comes back on the other side, see [`Coverage::cut`](super::Coverage).
const MOST_PADDED_PX: usize = 4096;

/// Transposed half spectrum of a real image.
pub(super) type Spectrum = Vec<Complex<f32>>;

/// The object image with what its border rule puts around it.
pub(super) struct Canvas {
    pub fft: Fft2<f32>,
    /// What the transfer functions need along each axis.
    pub axes: [Axis; 2],
    pub padded: [Padded; 2],
    pub object: [usize; 2],
    pub sampling: Sampling,
    /// For each column and row of the canvas what it shows of the object image, and the factor of slopes there.
    shown: [Vec<Option<(usize, f32)>>; 2],
}

/// A pixel of a row of the canvas and the object pixel that it shows.
pub(super) struct Place {
    /// Column of the canvas.
    pub x: usize,
    /// Index in the object image.
    pub of: usize,
    /// Factor of the slope along x and y: -1 where the image is mirrored.
    pub turn: [f32; 2],
}

impl Canvas {
    /// The canvas of `target` for kernels that reach `reach_px` pixels.
    pub(super) fn new(target: &Target, reach_px: f64) -> Self {
        let object = [target.radiance.width, target.radiance.height];
        let padded = object.map(|n| padded(n, target.border, reach_px.min(most_reach(target))));
        let fft = Fft2::new(padded[0].size, padded[1].size);
        let axes = padded.map(|p| Axis::new(p.size, target.sampling));
        let border = target.border;
        let shown = [0, 1].map(|axis| {
            let (n, Padded { size, margin }) = (object[axis], padded[axis]);
            let shows = |i: usize| {
                let position = i as i64 - margin as i64;
                Some((border.index(position, n)?, border.turn(position, n) as f32))
            };
            (0..size).map(shows).collect()
        });
        Self { fft, axes, padded, object, sampling: target.sampling, shown }
    }

    pub(super) fn pixels(&self) -> usize {
        self.fft.width * self.fft.height
    }

    /// The pixels of row `j` of the canvas that show a pixel of the object image.
    pub(super) fn row(&self, j: usize) -> impl Iterator<Item = Place> + '_ {
        let row = self.shown[1][j];
        let columns = self.shown[0].iter().enumerate();
        columns.filter_map(move |(i, column)| {
            let ((x, turn_x), (y, turn_y)) = ((*column)?, row?);
            Some(Place { x: i, of: y * self.object[0] + x, turn: [turn_x, turn_y] })
        })
    }

    /// Rows of several images on the canvas, side by side.
    pub(super) fn rows<'p>(
        &self,
        planes: &'p mut [Vec<f32>],
    ) -> impl IndexedParallelIterator<Item = Vec<&'p mut [f32]>> {
        let mut rows: Vec<Vec<&mut [f32]>> = (0..self.fft.height).map(|_| Vec::new()).collect();
        for plane in planes {
            rows.iter_mut().zip(plane.chunks_mut(self.fft.width)).for_each(|(row, part)| row.push(part));
        }
        rows.into_par_iter()
    }

    /// Multiplies `canvas` by `weights` over `view`; what lies outside is seen as by the nearest pixel of the view.
    pub(super) fn weigh(&self, canvas: &mut [f32], view: View, weights: &[f32]) {
        let [columns, rows] = self.nearest(view);
        canvas.par_chunks_mut(self.fft.width).zip(rows).for_each(|(row, y)| {
            let weights = &weights[y * view.width..];
            row.iter_mut().zip(&columns).for_each(|(v, &x)| *v *= weights[x]);
        });
    }

    /// For each column and row of the canvas the nearest of `view`, around the canvas' ends if that is shorter.
    fn nearest(&self, view: View) -> [Vec<usize>; 2] {
        let [x, y] = [(view.x, view.width), (view.y, view.height)];
        [(x, self.padded[0]), (y, self.padded[1])].map(|(seen, padded)| nearest(seen, padded))
    }

    /// The part of `canvas` under `view` of the object image.
    pub(super) fn crop(&self, canvas: &[f32], view: View) -> Image {
        let [left, top] = [view.x + self.padded[0].margin, view.y + self.padded[1].margin];
        Image::from_fn(view.width, view.height, |x, y| canvas[(top + y) * self.fft.width + left + x])
    }
}

/// The farthest reach that the padding serves, px.
pub(super) fn most_reach(target: &Target) -> f64 {
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

/// For each pixel of a padded row the nearest of the `length` pixels from `start` on of the object image, around the ends
/// of the row if that is shorter.
pub(super) fn nearest((start, length): (usize, usize), Padded { size, margin }: Padded) -> Vec<usize> {
    let of = |i: usize| match (i + size - start - margin) % size {
        inside if inside < length => inside,
        beyond if 2 * beyond < size + length => length - 1,
        _ => 0,
    };
    (0..size).map(of).collect()
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
        Border::Mirror | Border::Unknown => Padded { size: 2 * n, margin: 0 },
    }
}

/// The frequencies 0 to pi rad/px of one axis, and what the transfer function needs at each.
pub(super) struct Axis {
    pub w: Vec<f64>,
    /// What both pixels leave of it.
    pub pixel: Vec<f32>,
    pub basis: Vec<Basis>,
}

impl Axis {
    fn new(n: usize, sampling: Sampling) -> Self {
        let w: Vec<f64> = (0..=n / 2).map(|i| 2.0 * PI * i as f64 / n as f64).collect();
        let pixel = w.iter().map(|&w| pixel_factor(w, 0.0, sampling) as f32).collect();
        Self { w, pixel, basis: AliasTable::basis(n) }
    }
}
