//! What a fit needs of a scene, without renders: sums over its pixels, made once.
//!
//! A render is a linear combination of images that do not depend on the medium, I = sum_c a_c E_c
//! ([`basis`](crate::filter::basis)). So the sum of any product of I, its derivatives and the observation follows from
//! the Gram matrix of the E_c, the observation y and 1 over the pixels that count. After one pass over the image an
//! evaluation takes microseconds, whatever the image's size.

use super::equations::Products;
use super::observed::Observed;
use crate::error::Result;
use crate::filter::Optics;
use crate::filter::basis::{Basis, Images};
use crate::filter::blur::{Lane, dot};
use nalgebra::{DMatrix, Matrix6, Vector2};
use rayon::prelude::*;
use std::ops::Range;

/// The sums of one scene.
pub(super) struct Sums<'a> {
    basis: Basis<'a>,
    /// Products of the images, the observation and 1, summed over the pixels that count, each with its weight.
    gram: DMatrix<f64>,
    /// Gain and veil at which residuals are formed.
    reference: Vector2<f64>,
}

/// Columns of a strip whose products are summed in f32: 256 pixels.
const BLOCK: usize = 16;
/// Largest error of a transfer function, relative to the scattered light, with which what the sums say is believed.
const MOST_ERROR: f64 = 1e-3;

impl<'a> Sums<'a> {
    /// The sums of every scene, if all of them have such.
    pub(super) fn of_all(observed: &[Observed<'a>]) -> Option<Vec<Self>> {
        observed.iter().map(Self::new).collect()
    }

    /// The sums of `observed`; `None` if its renders are no such combination.
    pub(super) fn new(observed: &Observed<'a>) -> Option<Self> {
        let basis = Basis::new(observed.datum.target)?;
        let images = basis.images();
        let number = basis.count() + 2;
        let (values, width) = (observed.values(), observed.datum.target.view.width);
        let strips = images.strips();
        let parts: Vec<Vec<f64>> =
            strips.par_iter().map(|strip| strip_sums(&images, (&values, width), strip, number)).collect();
        let mut sums = vec![0.0; number * number];
        for part in &parts {
            sums.iter_mut().zip(part).for_each(|(sum, v)| *sum += v);
        }
        let gram = DMatrix::from_fn(number, number, |i, j| sums[i.max(j) * number + i.min(j)]);
        Some(Self { basis, gram, reference: observed.given_exposure() })
    }

    /// What a fit needs of a render and its derivatives.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub(super) fn products(&self, optics: &Optics) -> Result<Products> {
        let weights = self.basis.weights(optics)?;
        let (observation, one) = (weights.len(), weights.len() + 1);
        let [gain, veil] = [self.reference[0], self.reference[1]];
        let mut six = DMatrix::zeros(one + 1, 6);
        for (mut row, weight) in six.row_iter_mut().zip(&weights) {
            let [s, a, b] = weight.gradient;
            row.copy_from_slice(&[weight.value, s, a, b, gain * weight.value, 0.0]);
        }
        six[(observation, 4)] = -1.0;
        six[(one, 4)] = veil;
        six[(one, 5)] = 1.0;
        let sums = six.transpose() * (&self.gram * &six);
        Ok(Products { reference: self.reference, sums: Matrix6::from_fn(|i, j| sums[(i, j)]) })
    }

    /// Whether the kernels of `optics` are what the sums can tell of.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub(super) fn serves(&self, optics: &Optics) -> Result<bool> {
        Ok(self.basis.error(optics)? <= MOST_ERROR)
    }
}

/// The lower half of the sums of products over one strip, row-major. `values` are those of all pixels and
/// their weights, in a view of `width` columns.
fn strip_sums(
    images: &Images,
    (values, width): (&[(f32, f32)], usize),
    strip: &Range<usize>,
    number: usize,
) -> Vec<f64> {
    let mut sums = vec![0.0; number * number];
    images.blocks(strip, BLOCK, |columns, images| {
        let lanes = |f: &dyn Fn(usize) -> f32| -> Vec<Lane> {
            let lane = |x: usize| {
                std::array::from_fn(|y| if y < strip.len() { f((strip.start + y) * width + x) } else { 0.0 })
            };
            columns.clone().map(lane).collect()
        };
        let one = lanes(&|i| values[i].1.sqrt());
        let y = lanes(&|i| values[i].0 * values[i].1.sqrt());
        let counted: Vec<Vec<Lane>> = images.iter().map(|image| times(image, &one)).collect();
        let all: Vec<&[f32]> = counted.iter().chain([&y, &one]).map(|image| image.as_flattened()).collect();
        for (i, a) in all.iter().enumerate() {
            for (sum, b) in sums[i * number..].iter_mut().zip(&all[..=i]) {
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
