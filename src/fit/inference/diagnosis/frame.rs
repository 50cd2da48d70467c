//! All columns of one scene, pixel by pixel, in units of the noise.

use super::columns::{Column, Columns};
use crate::fit::inference::displacement::Displacement;
use crate::fit::observation::{LinearTerm, Observed};
use crate::forward::{Exposure, Pixel, Quantity, Rendering};
use crate::image::Image;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;

/// Root mean square error of renders relative to the observation.
const RENDERED: f64 = 1e-4;
/// Pixels summed together.
const CHUNK: usize = 4096;

/// The columns of one scene: linear terms, derivatives in the parameters, errors and causes, residual.
pub(super) struct Frame<'x> {
    observed: &'x Observed<'x>,
    columns: &'x Columns,
    exposure: Exposure,
    light: Image,
    linear: Vec<LinearTerm>,
    derivatives: Vec<Derivative>,
    extra: Vec<Column>,
}

/// The image's derivative in one coordinate.
struct Derivative {
    quantity: Quantity,
    row: usize,
    slope: f64,
    image: Image,
}

impl<'x> Frame<'x> {
    /// That of scene number `scene` of `fit`.
    pub(super) fn new(
        fit: &'x Displacement,
        scene: usize,
        columns: &'x Columns,
        rendering: Rendering,
    ) -> Self {
        let observed = &fit.observed[scene];
        let exposure = fit.exposures[scene];
        let chain = fit.parameters.chain();
        let derivative = |(quantity, image): (Quantity, Image)| {
            let row = fit.parameters.moving(quantity, scene)?.row();
            Some(Derivative { quantity, row, slope: chain[row] * exposure.gain, image })
        };
        Self {
            observed,
            columns,
            exposure,
            linear: LinearTerm::free(&observed.observation),
            derivatives: rendering.derivatives.into_iter().filter_map(derivative).collect(),
            extra: columns.all().collect(),
            light: rendering.image,
        }
    }

    /// Numbers of the columns of linear terms, of derivatives, and of errors and causes; the residual comes last.
    pub(super) fn ranges(&self) -> [Range<usize>; 3] {
        let (l, p, e) = (self.linear.len(), self.derivatives.len(), self.extra.len());
        [0..l, l..l + p, l + p..l + p + e]
    }

    /// The row of the coordinate that each derivative is taken in.
    pub(super) fn rows(&self) -> impl Iterator<Item = usize> + '_ {
        self.derivatives.iter().map(|d| d.row)
    }

    /// Number of all columns.
    pub(super) fn size(&self) -> usize {
        self.linear.len() + self.derivatives.len() + self.extra.len() + 1
    }

    /// The scene.
    pub(super) fn observed(&self) -> &Observed<'x> {
        self.observed
    }

    /// The object's light that was fitted.
    pub(super) fn light(&self) -> &Image {
        &self.light
    }

    /// Variance of a pixel by what renders are off, in units of the noise: what is less than that is no noise.
    pub(super) fn rounding(&self) -> f64 {
        let pixels = self.observed.counted();
        let square: f64 = pixels.iter().map(|p| f64::from(p.value).powi(2) * f64::from(p.weight)).sum();
        RENDERED * RENDERED * square / pixels.len() as f64 / (self.observed.noise * self.observed.noise)
    }

    /// All columns at `pixel`.
    fn fill(&self, pixel: &Pixel, out: &mut [f64]) {
        let i = pixel.index as usize;
        let scale = f64::from(pixel.weight).sqrt() / self.observed.noise;
        let light = f64::from(self.light.data[i]);
        let places = self.observed.observation.places();
        let linear = self.linear.iter().map(|term| match term {
            LinearTerm::Veil(term) => places.monomials(i)[*term],
            LinearTerm::Gain => light,
        });
        let slopes = self.derivatives.iter().map(|d| f64::from(d.image.data[i]) * d.slope);
        let extra = self.extra.iter().map(|column| self.columns.value(*column, i));
        let Exposure { gain, veil } = self.exposure;
        let residual = f64::from(pixel.value) - veil.at(places, i) - gain * light;
        let all = linear.chain(slopes).chain(extra).chain([residual]);
        out.iter_mut().zip(all).for_each(|(out, value)| *out = scale * value);
    }

    /// Takes from the products of all columns what the noise of the clear image is expected to add: `power` to those of the render and
    /// its derivatives in the medium, of which `left` stays in the residual's. Of the other columns, those that [`Columns`] has of a
    /// noisy object are orthogonal to it.
    pub(super) fn without_object_noise(
        &self,
        mut gram: DMatrix<f64>,
        power: &DMatrix<f64>,
        left: f64,
    ) -> DMatrix<f64> {
        let linear = self.linear.iter().map(|term| match term {
            LinearTerm::Veil(_) => None,
            LinearTerm::Gain => Some((0, 1.0)),
        });
        let derivatives = self.derivatives.iter().map(|d| {
            let place = Quantity::MEDIUM.iter().position(|quantity| *quantity == d.quantity)?;
            Some((1 + place, d.slope))
        });
        let extra = self.extra.iter().map(|_| None);
        let noisy: Vec<Option<(usize, f64)>> =
            linear.chain(derivatives).chain(extra).chain([Some((0, -self.exposure.gain))]).collect();
        let precision = self.observed.precision();
        for (i, a) in noisy.iter().enumerate() {
            for (j, b) in noisy.iter().enumerate() {
                if let (Some((row, scale)), Some((column, other))) = (a, b) {
                    gram[(i, j)] -= scale * other * power[(*row, *column)] * precision;
                }
            }
        }
        let residual = self.size() - 1;
        gram[(residual, residual)] += left * precision;
        gram
    }

    /// Products of all columns with each other.
    pub(super) fn gram(&self) -> DMatrix<f64> {
        let size = self.size();
        let chunk = |pixels: &[Pixel]| {
            let (mut row, mut sums) = (vec![0.0; size], vec![0.0; size * size]);
            for pixel in pixels {
                self.fill(pixel, &mut row);
                for (i, (sums, left)) in sums.chunks_exact_mut(size).zip(&row).enumerate() {
                    sums[i..].iter_mut().zip(&row[i..]).for_each(|(sum, right)| *sum += left * right);
                }
            }
            DMatrix::from_row_slice(size, size, &sums)
        };
        let chunks: Vec<_> = self.observed.counted().par_chunks(CHUNK).map(chunk).collect();
        let upper = chunks.into_iter().fold(DMatrix::zeros(size, size), |sum, chunk| sum + chunk);
        DMatrix::from_fn(size, size, |i, j| upper[(i.min(j), i.max(j))])
    }

    /// Combinations of the columns, each a column of `parts`, at each pixel that counts.
    pub(super) fn combinations(&self, parts: &DMatrix<f64>) -> Vec<Vec<f64>> {
        let count = parts.ncols();
        let chunk = |pixels: &[Pixel]| {
            let mut row = vec![0.0; self.size()];
            let mut values = vec![Vec::with_capacity(pixels.len()); count];
            for pixel in pixels {
                self.fill(pixel, &mut row);
                for (values, parts) in values.iter_mut().zip(parts.column_iter()) {
                    values.push(row.iter().zip(parts.iter()).map(|(value, part)| value * part).sum());
                }
            }
            values
        };
        let chunks: Vec<Vec<Vec<f64>>> = self.observed.counted().par_chunks(CHUNK).map(chunk).collect();
        (0..count).map(|i| chunks.iter().flat_map(|chunk| &chunk[i]).copied().collect()).collect()
    }
}
