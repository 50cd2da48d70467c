//! Inner products of a render, its derivatives and an observation: all that least squares asks of a scene.
//!
//! The columns are the render m, its derivatives, the residual r = gain · m + veil - y at a reference exposure, and the monomials that
//! a veil is made of, 1 the first. Their
//! Gram matrix over the pixels that count, each with its weight, is a sufficient statistic of the observation. Near the best
//! exposure r is small, so nothing cancels.

use super::quantity::Quantity;
use super::rendering::Rendering;
use crate::image::Image;
use crate::imaging::{MONOMIALS, Places};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// A pixel that counts.
#[derive(Debug, Clone, Copy)]
pub struct Pixel {
    /// Index in the view.
    pub index: u32,
    /// Observed, known veil taken off.
    pub value: f32,
    /// Weight of its squared residual.
    pub weight: f32,
}

/// Light that the object has not sent, in units of the observation: coefficients of the [monomials](Places::monomials) of the place.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Veil(pub [f64; MONOMIALS]);

impl Veil {
    /// The same everywhere.
    pub fn constant(veil: f64) -> Self {
        let mut terms = [0.0; MONOMIALS];
        terms[0] = veil;
        Self(terms)
    }

    /// Its value at the pixel `index`.
    pub fn at(&self, places: Places, index: usize) -> f64 {
        if self.0[1..].iter().all(|&c| c == 0.0) {
            return self.0[0];
        }
        places.monomials(index).iter().zip(self.0).map(|(m, c)| m * c).sum()
    }
}

/// observed = `gain` · object light + `veil`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    /// Factor on the object's light.
    pub gain: f64,
    /// Light that the object has not sent.
    pub veil: Veil,
}

/// The pixels of an observation that count.
#[derive(Debug, Clone)]
pub struct Pixels {
    /// Those that count, in the order of their indices.
    pub counted: Vec<Pixel>,
    /// Places in the view.
    pub places: Places,
    /// Exposure at which residuals are formed: what is given, else gain 1 and veil 0.
    pub reference: Exposure,
    /// Number of monomials of the veil, the first ones, that are columns; at least 1.
    pub veil_terms: usize,
}

impl Pixels {
    /// Number of pixels of the view.
    pub fn total(&self) -> usize {
        self.places.width * self.places.height
    }

    /// The observed value of every pixel of the view and its weight; both 0 where it does not count.
    pub fn values(&self) -> Vec<(f32, f32)> {
        let mut values = vec![(0.0, 0.0); self.total()];
        self.counted.iter().for_each(|p| values[p.index as usize] = (p.value, p.weight));
        values
    }
}

/// The Gram matrix of render, derivatives, residual and the veil's monomials, in this order.
#[derive(Debug, Clone)]
pub struct Products {
    reference: Exposure,
    derivatives: Vec<Quantity>,
    matrix: DMatrix<f64>,
}

/// Pixels summed together; the chunks are added in order, so that the result does not depend on the threads.
const CHUNK: usize = 8192;

/// The columns at one pixel.
fn columns(pixels: &Pixels, pixel: &Pixel, images: &[&Image], out: &mut [f64]) {
    let (i, reference) = (pixel.index as usize, pixels.reference);
    for (value, image) in out.iter_mut().zip(images) {
        *value = f64::from(image.data[i]);
    }
    let n = images.len();
    out[n] = reference.gain * out[0] + reference.veil.at(pixels.places, i) - f64::from(pixel.value);
    if pixels.veil_terms == 1 {
        out[n + 1] = 1.0;
    } else {
        out[n + 1..].copy_from_slice(&pixels.places.monomials(i)[..pixels.veil_terms]);
    }
}

/// The images of a render and what their derivatives are taken in.
fn images(rendering: &Rendering) -> (Vec<&Image>, Vec<Quantity>) {
    let of_derivatives = rendering.derivatives.iter();
    let images = std::iter::once(&rendering.image).chain(of_derivatives.map(|(_, image)| image)).collect();
    (images, rendering.derivatives.iter().map(|(quantity, _)| *quantity).collect())
}

impl Products {
    /// From the Gram matrix of render, `derivatives`, residual at the exposure `reference`, and the veil's monomials.
    ///
    /// # Panics
    /// If the matrix is not square with a row for each of them, and for at least one monomial.
    pub fn new(reference: Exposure, derivatives: Vec<Quantity>, matrix: DMatrix<f64>) -> Self {
        let least = derivatives.len() + 3;
        assert!(matrix.is_square() && matrix.nrows() >= least, "a row and a column for each image");
        Self { reference, derivatives, matrix }
    }

    /// The products over `pixels` of `rendering` with the derivatives that it has.
    pub fn over(pixels: &Pixels, rendering: &Rendering) -> Self {
        let (images, derivatives) = images(rendering);
        let size = images.len() + 1 + pixels.veil_terms;
        let chunk = |pixels_here: &[Pixel]| {
            let (mut all, mut sums) = (vec![0.0; size], vec![0.0; size * size]);
            for pixel in pixels_here {
                columns(pixels, pixel, &images, &mut all);
                let weight = f64::from(pixel.weight);
                for (row, left) in sums.chunks_exact_mut(size).zip(&all) {
                    let left = left * weight;
                    row.iter_mut().zip(&all).for_each(|(sum, right)| *sum += left * right);
                }
            }
            DMatrix::from_row_slice(size, size, &sums)
        };
        let chunks: Vec<_> = pixels.counted.par_chunks(CHUNK).map(chunk).collect();
        Self { reference: pixels.reference, derivatives, matrix: total(chunks, size) }
    }

    /// The same of the products of one of two renders with the other, in which noise that they do not share has no part.
    pub fn between(pixels: &Pixels, renders: [&Rendering; 2]) -> Self {
        let [(first, derivatives), (second, _)] = renders.map(images);
        let size = first.len() + 1 + pixels.veil_terms;
        let chunk = |pixels_here: &[Pixel]| {
            let (mut a, mut b) = (DVector::zeros(size), DVector::zeros(size));
            let mut sums = DMatrix::zeros(size, size);
            for pixel in pixels_here {
                columns(pixels, pixel, &first, a.as_mut_slice());
                columns(pixels, pixel, &second, b.as_mut_slice());
                sums.ger(f64::from(pixel.weight), &a, &b, 1.0);
            }
            0.5 * (&sums + sums.transpose())
        };
        let chunks: Vec<_> = pixels.counted.par_chunks(CHUNK).map(chunk).collect();
        Self { reference: pixels.reference, derivatives, matrix: total(chunks, size) }
    }

    /// Takes out what noise of the object is expected to add: `power` to the products of render and derivatives in the medium, of which
    /// `left` stays in those of the residual.
    pub(crate) fn without_object_noise(mut self, power: &DMatrix<f64>, left: f64) -> Self {
        let of = |i: usize| match i {
            0 => Some((0, 1.0)),
            i if i <= self.derivatives.len() => {
                let quantity = self.derivatives[i - 1];
                Some((1 + Quantity::MEDIUM.iter().position(|q| *q == quantity)?, 1.0))
            }
            i if i == self.derivatives.len() + 1 => Some((0, self.reference.gain)),
            _ => None,
        };
        let columns: Vec<_> = (0..self.matrix.nrows()).map(of).collect();
        for (i, a) in columns.iter().enumerate() {
            for (j, b) in columns.iter().enumerate() {
                if let (Some((row, scale)), Some((column, other))) = (a, b) {
                    self.matrix[(i, j)] -= scale * other * power[(*row, *column)];
                }
            }
        }
        let residual = self.derivatives.len() + 1;
        self.matrix[(residual, residual)] += left;
        self
    }

    /// What the derivatives are taken in, in the order of their columns.
    pub fn derivatives(&self) -> &[Quantity] {
        &self.derivatives
    }

    /// Products of all derivatives with each other.
    pub fn of_derivatives(&self) -> DMatrix<f64> {
        let n = self.derivatives.len();
        self.matrix.view((1, 1), (n, n)).into_owned()
    }

    /// Products of the column `a` with all derivatives.
    pub fn with_derivatives(&self, a: &DVector<f64>) -> DVector<f64> {
        (&self.matrix * a).rows(1, self.derivatives.len()).into_owned()
    }

    /// The product of two combinations of the columns.
    pub fn of(&self, a: &DVector<f64>, b: &DVector<f64>) -> f64 {
        a.dot(&(&self.matrix * b))
    }

    /// The render as a combination of the columns.
    pub fn render(&self) -> DVector<f64> {
        self.unit(0)
    }

    /// The monomial number `term` of the veil as a combination of the columns.
    pub fn veil(&self, term: usize) -> DVector<f64> {
        self.unit(self.derivatives.len() + 2 + term)
    }

    /// The observation y as a combination of the columns.
    pub fn observation(&self) -> DVector<f64> {
        let Exposure { gain, veil } = self.reference;
        self.combination(gain, -1.0, veil)
    }

    /// The residual at another `exposure` as a combination of the columns.
    pub fn residual(&self, exposure: Exposure) -> DVector<f64> {
        let change = std::array::from_fn(|term| exposure.veil.0[term] - self.reference.veil.0[term]);
        self.combination(exposure.gain - self.reference.gain, 1.0, Veil(change))
    }

    fn combination(&self, render: f64, residual: f64, veil: Veil) -> DVector<f64> {
        let n = self.derivatives.len();
        let mut all = DVector::zeros(self.matrix.nrows());
        (all[0], all[n + 1]) = (render, residual);
        all.rows_range_mut(n + 2..).iter_mut().zip(veil.0).for_each(|(part, term)| *part = term);
        all
    }

    fn unit(&self, i: usize) -> DVector<f64> {
        DVector::from_fn(self.matrix.nrows(), |j, _| f64::from(u8::from(i == j)))
    }
}

fn total(chunks: Vec<DMatrix<f64>>, size: usize) -> DMatrix<f64> {
    chunks.into_iter().fold(DMatrix::zeros(size, size), |sum, chunk| sum + chunk)
}
