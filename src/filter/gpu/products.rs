//! What a fit reads back: sums over the pixels of the products of a few images.

use super::layout::{Sums, Total, products};
use super::render::Request;
use super::{GpuFilter, shaders};
use crate::error::Result;
use crate::filter::Optics;
use nalgebra::DMatrix;
use wgpu::Buffer;

/// An observation on the device: values and weights.
pub struct GpuObservation {
    pixels: Buffer,
}

/// Workgroups that sum products.
const SUMMING_GROUPS: usize = 64;

impl GpuFilter<'_> {
    /// Uploads an observation over the view: the value of each of its `pixels`, and its weight, 0 where it does not
    /// count.
    ///
    /// # Errors
    /// [`Error::Gpu`](crate::Error::Gpu) if the device cannot hold it.
    pub fn observe(&self, pixels: impl Iterator<Item = (f32, f32)>) -> Result<GpuObservation> {
        let pixels: Vec<[f32; 2]> = pixels.map(|(y, weight)| [y, weight]).collect();
        Ok(GpuObservation { pixels: self.gpu.upload("the observed image", &pixels)? })
    }

    /// Weighted sums over the pixels of `observation` of the products of images, a symmetric matrix. The images are the
    /// render m, its derivatives in sigma_s, sigma_a and the width of the phase function, with a shift those in the shift
    /// along x and y, the residual gain · m + veil - y at the exposure (gain, veil), and 1: six, with a shift eight.
    /// Derivatives are 0 unless they are wanted.
    ///
    /// # Errors
    /// As [`render`](Self::render), with a shift as [`render_shifted`](Self::render_shifted).
    pub fn products(
        &self,
        optics: &Optics,
        observation: &GpuObservation,
        [gain, veil]: [f64; 2],
        derivatives: bool,
        shift_px: Option<[f64; 2]>,
    ) -> Result<DMatrix<f64>> {
        let request = Request { optics, derivatives, shift: shift_px.map(|d| self.shift_by(d)).transpose()? };
        let mut recording = self.evaluate(&request)?;
        let parameters = Sums {
            pixels: self.plan.target.view.pixels() as u32,
            gain: gain as f32,
            veil: veil as f32,
            derivatives: u32::from(derivatives),
            zero: 0,
            padding: [0; 3],
        };
        let (images, stage) =
            if request.shift.is_some() { (8, &shaders::SUMS_OF_EIGHT) } else { (6, &shaders::SUMS) };
        let count = products(images);
        let partial = self.gpu.empty::<[f32; 2]>("partial sums", SUMMING_GROUPS * count)?;
        let whole = self.gpu.empty::<[f32; 2]>("sums", count)?;
        let total = Total { groups: SUMMING_GROUPS as u32, products: count as u32, zero: 0, padding: 0 };
        let read = [self.planes(&request)?, &observation.pixels, &partial];
        recording.dispatch_groups(&self.gpu.stage(stage), &parameters, &read, SUMMING_GROUPS);
        recording.dispatch_groups(&self.gpu.stage(&shaders::TOTAL), &total, &[&partial, &whole], 1);
        self.gpu.submit(recording)?;
        let sums: Vec<[f32; 2]> = self.gpu.read(&whole, count)?;
        let mut units = vec![1.0; images];
        units[..4].copy_from_slice(&self.units(optics).0);
        let mut all = DMatrix::zeros(images, images);
        let pairs = (0..images).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for ((i, j), [high, low]) in pairs.zip(sums) {
            all[(i, j)] = (f64::from(high) + f64::from(low)) * units[i] * units[j];
            all[(j, i)] = all[(i, j)];
        }
        Ok(all)
    }
}
