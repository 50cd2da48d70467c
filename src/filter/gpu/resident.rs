//! What stays on the device from one render to the next.

use super::layout::{Canvas as CanvasLayout, sources};
use super::tables::axes;
use crate::error::Result;
use crate::filter::canvas::Canvas;
use crate::filter::plan::Plan;
use crate::filter::sources::Layer;
use crate::gpu::Gpu;
use std::cell::RefCell;
use wgpu::Buffer;

/// Buffers of a prepared target.
pub(super) struct Resident {
    pub layout: CanvasLayout,
    pub sources: Buffer,
    /// For each object pixel a bit for each occluder.
    pub opaque: Buffer,
    pub axes: Buffer,
    /// Of the obliquities.
    pub weights: Buffer,
    /// Image and derivatives over the view.
    pub planes: Buffer,
    /// Image and first derivative, second and third, each as one complex image; working space.
    pub pairs: RefCell<[Buffer; 3]>,
}

impl Resident {
    pub(super) fn new(gpu: &Gpu, plan: &Plan, canvas: &Canvas, layers: &[Layer]) -> Result<Self> {
        let (view, pixels) = (plan.target.view.pixels(), canvas.pixels());
        let mut opaque = vec![0u32; plan.target.radiance.data.len()];
        for (i, occluder) in plan.occluders().iter().enumerate() {
            let marked = opaque.iter_mut().zip(&occluder.opaque).filter(|(_, opaque)| **opaque);
            marked.for_each(|(bits, _)| *bits |= 1 << i);
        }
        let weights: Vec<f32> =
            plan.obliquities.iter().flat_map(|(_, w)| w.unwrap_or(&[1.0]).to_vec()).collect();
        let pair = || gpu.empty::<[f32; 2]>("the padded image", pixels);
        Ok(Self {
            layout: CanvasLayout::new(canvas, plan.target.border, layers.len()),
            sources: gpu.upload("the object image", &sources(layers, &plan.slices))?,
            opaque: gpu.upload("occluders", &opaque)?,
            axes: gpu.upload("frequencies", &axes(canvas))?,
            weights: gpu.upload("the weights of the obliquities", &weights)?,
            planes: gpu.empty::<f32>("the rendered image", 4 * view)?,
            pairs: RefCell::new([pair()?, pair()?, pair()?]),
        })
    }
}
