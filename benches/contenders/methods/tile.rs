//! A sum over the disc of each pixel's kernel, tile by tile.

use super::depths::{Depths, ROOM, padded};
use super::stages::{TILE, Tile};
use super::{NODES, Scene, Work};
use narrowbeam::error::Result;
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Optics, Target};
use narrowbeam::geometry::Geometry;
use narrowbeam::gpu::Gpu;
use narrowbeam::image::{Border, Image, Sampling, View};
use wgpu::Buffer;

/// The object on the device.
pub struct Tiles<'a> {
    gpu: &'a Gpu,
    scene: &'a Scene,
    depths: Depths,
    sources: Buffer,
    image: Buffer,
}

impl<'a> Tiles<'a> {
    pub fn new(gpu: &'a Gpu, scene: &'a Scene) -> Result<Self> {
        let depths = scene.depths(NODES);
        let sources: Vec<[f32; 2]> = scene.sources(&depths).collect();
        Ok(Self {
            gpu,
            scene,
            sources: gpu.upload("sources", &sources)?,
            image: gpu.empty::<f32>("image", scene.n * scene.n)?,
            depths,
        })
    }

    /// The image, with the share `outside` of the light spread over the discs instead of beyond them.
    pub fn render(&self, optics: &Optics, outside: f64) -> Result<Vec<f32>> {
        let (n, terms) = (self.scene.n, self.depths.terms());
        let radius = radius(self.scene, optics, outside)?;
        let weights = weights(&self.depths, self.scene.pitch(), optics, radius)?;
        let parameters = Tile {
            size: [n as u32; 2],
            radius: radius as u32,
            disc: (radius * radius) as u32,
            terms: terms as u32,
            middle: self.depths.middle as f32,
            half_range: self.depths.half_range as f32,
            sigma_t: optics.medium.sigma_t() as f32,
        };
        let weights = self.gpu.upload("weights", &weights)?;
        let mut recording = self.gpu.record();
        let buffers = [&self.sources, &weights, &self.image];
        recording.dispatch_groups(&self.gpu.stage(&TILE), &parameters, &buffers, n.div_ceil(SIDE).pow(2));
        self.gpu.submit(recording)?;
        self.gpu.read(&self.image, n * n)
    }
}

/// Outputs of a workgroup along one side, and the sources that it reads for as many offsets.
const SIDE: usize = 16;
const SOURCES: f64 = 31.0;

/// Radius of the discs, px, no more than the image needs.
fn radius(scene: &Scene, optics: &Optics, outside: f64) -> Result<usize> {
    let reach = optics.kernel(scene.depths(1).far())?.support(outside) / scene.pitch();
    // Half a pixel on either side: a weight belongs to two pixel areas.
    Ok((reach + 1.0).ceil() as usize)
}

/// For each offset down and across the coefficients of the weight in depth: images of one bright pixel at the nodes'
/// depths, scaled so that the disc holds all scattered light.
fn weights(depths: &Depths, pitch: f64, optics: &Optics, radius: usize) -> Result<Vec<[f32; ROOM]>> {
    let side = radius + 1;
    let point = Image::from_fn(side, side, |x, y| f32::from(u8::from(x + y == 0)));
    let mut at_nodes = Vec::new();
    for z in depths.path_lengths() {
        let geometry = Geometry::planar(side, side, pitch, z)?;
        let kernel = optics.kernel(z)?;
        let target = Target {
            radiance: &point,
            behind: &[],
            geometry: &geometry,
            border: Border::Zero,
            sampling: Sampling::Pixel,
            view: View::whole(side, side),
            relief: None,
        };
        let filter = CpuFilter::with_slices(target, 1, kernel.support(1e-6) / pitch).unwrap();
        let mut image: Vec<f64> = filter.render(optics)?.data.iter().map(|&v| f64::from(v)).collect();
        image[0] -= kernel.direct().value;
        let inside = |i: usize| (i % side).pow(2) + (i / side).pow(2) <= radius * radius;
        let copies = |d: usize| if d == 0 { 1.0 } else { 2.0 };
        let held =
            |(i, v): (usize, &f64)| if inside(i) { copies(i % side) * copies(i / side) * v } else { 0.0 };
        let scale = kernel.scattered() / image.iter().enumerate().map(held).sum::<f64>();
        image.iter_mut().for_each(|v| *v *= scale);
        at_nodes.push(image);
    }
    let to_powers = depths.to_powers();
    let mut values = vec![0.0; depths.terms()];
    let mut weights = Vec::with_capacity(side * side);
    for i in 0..side * side {
        values.iter_mut().zip(&at_nodes).for_each(|(v, image)| *v = image[i]);
        weights.push(padded(&depths.coefficients(&to_powers, &values)));
    }
    Ok(weights)
}

/// A weight's polynomial and its product, for each offset in the disc; a workgroup reads 31² sources of 8 bytes for 16²
/// outputs and as many offsets.
pub fn work(scene: &Scene, outside: f64) -> [Work; 2] {
    let radius =
        radius(scene, &scene.optics(), outside).expect("a Gaussian phase function suits every model") as f64;
    let terms = scene.depths(NODES).terms() as f64;
    let (offsets, side) = (std::f64::consts::PI * radius * radius, SIDE as f64);
    let blocks = ((2.0 * radius + 1.0) / side).ceil().powi(2);
    let read = blocks * SOURCES * SOURCES / (side * side) * 8.0;
    let pixels = (scene.n * scene.n) as f64;
    let render = Work::dispatch(pixels, offsets * 2.0 * terms + 3.0, read + 12.0);
    [Work { bytes: 8.0 * pixels, ..Work::default() }, render]
}
