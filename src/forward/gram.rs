//! A scene by its Gram matrix: all that a fit needs of it, from one pass over the image.
//!
//! A render is a linear combination of images that do not depend on the medium, I = sum_c a_c E_c
//! ([`basis`](crate::filter::basis)). So the product of I, its derivatives and the observation, two at a time, follows from
//! the Gram matrix of the E_c, the observation y and 1 over the pixels that count. An evaluation then takes microseconds,
//! whatever the image's size.

use super::products::{Exposure, Pixels, Products};
use super::quantity::{Quantity, State};
use super::{ForwardModel, Rendering};
use crate::error::Result;
use crate::filter::basis::{Basis, Images, combination};
use crate::filter::blur::{Lane, dot};
use crate::filter::{Coverage, Optics, Target};
use crate::image::Image;
use crate::spread::{Dual, Model};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;

/// The Gram matrix of one scene.
pub struct GramModel<'a> {
    model: Model,
    basis: Basis<'a>,
    /// Products of the images, the observation and 1, summed over the pixels that count, each with its weight.
    matrix: DMatrix<f64>,
    /// Exposure at which residuals are formed.
    reference: Exposure,
}

/// Columns of a strip whose products are summed in f32: 256 pixels.
const BLOCK: usize = 16;
/// Largest error of a transfer function, relative to the scattered light, with which the matrix is believed.
const MOST_ERROR: f64 = 1e-3;

impl<'a> GramModel<'a> {
    /// The Gram matrix of `target` seen as `pixels`; `None` if its renders by `model` are no such combination.
    ///
    /// # Errors
    /// [`Error::Memory`](crate::Error::Memory).
    pub fn new(model: Model, target: Target<'a>, pixels: &Pixels) -> Result<Option<Self>> {
        let Some(basis) = Basis::new(target)? else { return Ok(None) };
        let images = basis.images();
        let size = basis.count() + 1 + pixels.veil_terms;
        let seen = Seen { values: pixels.values(), width: target.view.width, pixels };
        let strips = images.strips();
        let parts: Vec<Vec<f64>> =
            strips.par_iter().map(|strip| strip_products(&images, &seen, strip, size)).collect();
        let mut sums = vec![0.0; size * size];
        for part in &parts {
            sums.iter_mut().zip(part).for_each(|(sum, v)| *sum += v);
        }
        let matrix = DMatrix::from_fn(size, size, |i, j| sums[i.max(j) * size + i.min(j)]);
        Ok(Some(Self { model, basis, matrix, reference: pixels.reference }))
    }

    fn weights(&self, state: &State) -> Result<Vec<Dual>> {
        self.basis.weights(&self.optics(state))
    }

    fn optics(&self, state: &State) -> Optics {
        Optics { model: self.model, medium: state.medium }
    }
}

impl ForwardModel for GramModel<'_> {
    fn image(&self, state: &State) -> Result<Image> {
        let weights: Vec<f64> = self.weights(state)?.iter().map(|weight| weight.value).collect();
        Ok(combination(&weights, &self.basis.all_images()))
    }

    fn rendering(&self, state: &State) -> Result<Rendering> {
        let (weights, images) = (self.weights(state)?, self.basis.all_images());
        let slope = |axis: usize| {
            let slopes: Vec<f64> = weights.iter().map(|weight| weight.gradient[axis]).collect();
            combination(&slopes, &images)
        };
        let gradient = [0, 1, 2].map(slope);
        let values: Vec<f64> = weights.iter().map(|weight| weight.value).collect();
        Ok(Rendering::of_medium(combination(&values, &images), gradient))
    }

    fn products(&self, state: &State, _pixels: &Pixels) -> Result<Products> {
        let weights = self.weights(state)?;
        let (observation, one) = (weights.len(), weights.len() + 1);
        let Exposure { gain, veil } = self.reference;
        let residual = Quantity::MEDIUM.len() + 1;
        let terms = self.matrix.nrows() - one;
        let mut columns = DMatrix::zeros(one + terms, residual + 1 + terms);
        for (mut row, weight) in columns.row_iter_mut().zip(&weights) {
            row[0] = weight.value;
            row.iter_mut().skip(1).zip(weight.gradient).for_each(|(v, slope)| *v = slope);
            row[residual] = gain * weight.value;
        }
        columns[(observation, residual)] = -1.0;
        for term in 0..terms {
            columns[(one + term, residual)] = veil.0[term];
            columns[(one + term, residual + 1 + term)] = 1.0;
        }
        let products = columns.transpose() * (&self.matrix * &columns);
        Ok(Products::new(self.reference, Quantity::MEDIUM.to_vec(), products))
    }

    fn coverage(&self, state: &State) -> Result<Coverage> {
        Ok(Coverage { served: self.basis.error(&self.optics(state))? <= MOST_ERROR, cut: false })
    }
}

/// The observed values and weights of all pixels of a view.
struct Seen<'x> {
    values: Vec<(f32, f32)>,
    width: usize,
    pixels: &'x Pixels,
}

/// The lower half of the products over one strip, row-major.
fn strip_products(images: &Images, seen: &Seen, strip: &Range<usize>, size: usize) -> Vec<f64> {
    let mut sums = vec![0.0; size * size];
    images.blocks(strip, BLOCK, |columns, images| {
        let lanes = |f: &dyn Fn(usize) -> f32| -> Vec<Lane> {
            let lane = |x: usize| {
                let pixel = |y: usize| (strip.start + y) * seen.width + x;
                std::array::from_fn(|y| if y < strip.len() { f(pixel(y)) } else { 0.0 })
            };
            columns.clone().map(lane).collect()
        };
        let one = lanes(&|i| seen.values[i].1.sqrt());
        let y = lanes(&|i| seen.values[i].0 * seen.values[i].1.sqrt());
        let counted: Vec<Vec<Lane>> = images.iter().map(|image| times(image, &one)).collect();
        let slopes = (1..seen.pixels.veil_terms).map(|term| {
            lanes(&|i| (seen.pixels.places.monomials(i)[term] * f64::from(seen.values[i].1.sqrt())) as f32)
        });
        let veil: Vec<Vec<Lane>> = std::iter::once(one.clone()).chain(slopes).collect();
        let all: Vec<&[f32]> =
            counted.iter().chain([&y]).chain(&veil).map(|image| image.as_flattened()).collect();
        for (i, a) in all.iter().enumerate() {
            for (sum, b) in sums[i * size..].iter_mut().zip(&all[..=i]) {
                *sum += f64::from(dot(a, b));
            }
        }
    });
    sums
}

fn times(a: &[Lane], b: &[Lane]) -> Vec<Lane> {
    let product = |(a, b): (&Lane, &Lane)| -> Lane { std::array::from_fn(|y: usize| a[y] * b[y]) };
    a.iter().zip(b).map(product).collect()
}
