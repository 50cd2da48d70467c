//! The program's own filter: depth slices, with transforms in workgroup memory.

use super::{Scene, Work};
use narrowbeam::error::Result;
use narrowbeam::filter::Optics;
use narrowbeam::filter::gpu::GpuFilter;
use narrowbeam::gpu::Gpu;

/// The filter with `slices`, or those for its own tolerance.
pub fn prepare<'a>(
    gpu: &'a Gpu,
    scene: &'a Scene,
    optics: &Optics,
    slices: Option<usize>,
) -> Result<GpuFilter<'a>> {
    match slices {
        None => GpuFilter::new(gpu, scene.target(), optics, 1.0),
        Some(count) => GpuFilter::with_slices(gpu, scene.target(), count, scene.reach_px(1e-5)),
    }
}

/// Operations of the stage `gather` for each slice and quadruple of frequencies: the radial table (four weights, four
/// entries of four lanes), 64 for the aliases, the product, two frequencies times four lanes of complex numbers.
const GATHERED: f64 = 20.0 + 32.0 + 64.0 + 14.0 + 32.0;

/// Preparation transforms slices by pairs; a render reads all spectra (8 bytes for each of half the frequencies) and
/// needs one complex transform of 5 P log2 P operations, each pass of which reads and writes 8 bytes.
pub fn work(scene: &Scene, slices: Option<usize>) -> [Work; 2] {
    let (planned, side) = scene.plan();
    let slices = slices.unwrap_or(planned) as f64;
    let padded = (side * side) as f64;
    let pixels = (scene.n * scene.n) as f64;
    // Sides above 1024 take two passes.
    let passes = if side > 1024 { 4.0 } else { 2.0 };
    let transform =
        Work { flops: 5.0 * padded * padded.log2(), bytes: passes * 16.0 * padded, dispatches: passes };
    let weigh = Work::dispatch(padded, 6.0 * slices, 8.0) + Work { bytes: 32.0 * pixels, ..Work::default() };
    let split = Work::dispatch(padded, 4.0, 16.0);
    let prepare = (weigh + transform + split) * (slices / 2.0).ceil();
    let gather = Work::dispatch(padded / 4.0, GATHERED * slices, 16.0 * slices + 32.0);
    let collect = Work::dispatch(pixels, 10.0, 32.0 + 8.0 + 4.0);
    [prepare, gather + transform + collect]
}
