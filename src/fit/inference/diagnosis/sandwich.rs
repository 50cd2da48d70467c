//! The covariance of the cost's gradient by what the residual shows, the filling of a sandwich (Huber 1967).

use super::fields::Fields;
use super::frame::Frame;
use super::noise::Noise;
use nalgebra::{DMatrix, DVector};

/// Side of the blocks whose sums count as independent, px.
const BLOCK_PX: usize = 16;

/// By the `noise` that was found, and by blocks of residuals, of all `count` coordinates.
pub(super) fn gradients(frame: &Frame, fields: &Fields, noise: &Noise, count: usize) -> [DMatrix<f64>; 2] {
    let Fields { residual, slopes, .. } = fields;
    let n = slopes.len();
    let by_noise = DMatrix::from_fn(n, n, |i, j| noise.covariance(frame, &slopes[i], &slopes[j]));
    let mut by_blocks = DMatrix::zeros(n, n);
    block_sums(frame, slopes, residual).iter().for_each(|sums| by_blocks += sums * sums.transpose());
    [by_noise, by_blocks].map(|values| of_coordinates(frame, &values, count))
}

/// The same of all `count` coordinates, of which those that the frame's derivatives are taken in have these `values`.
pub(super) fn of_coordinates(frame: &Frame, values: &DMatrix<f64>, count: usize) -> DMatrix<f64> {
    let rows: Vec<usize> = frame.rows().collect();
    let mut all = DMatrix::zeros(count, count);
    for (i, &row) in rows.iter().enumerate() {
        rows.iter().enumerate().for_each(|(j, &column)| all[(row, column)] = values[(i, j)]);
    }
    all
}

/// The gradient's part by each block.
fn block_sums(frame: &Frame, slopes: &[Vec<f64>], residual: &[f64]) -> Vec<DVector<f64>> {
    let image = frame.observed().observation.observed;
    let across = image.width.div_ceil(BLOCK_PX);
    let mut sums = vec![DVector::zeros(slopes.len()); across * image.height.div_ceil(BLOCK_PX)];
    for (k, pixel) in frame.observed().counted().iter().enumerate() {
        let (x, y) = (pixel.index as usize % image.width, pixel.index as usize / image.width);
        let sum = &mut sums[y / BLOCK_PX * across + x / BLOCK_PX];
        sum.iter_mut().zip(slopes).for_each(|(sum, slope)| *sum += slope[k] * residual[k]);
    }
    sums
}
