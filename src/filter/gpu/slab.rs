//! What lies between two occluders, on the device: the spectra of its slices.

use super::super::canvas::Canvas;
use super::super::plan::Plan;
use super::super::slices::{Node, Slices};
use super::super::sources::Layer;
use super::fft::FftPlan;
use super::layout::{NOTHING, Store, Weigh};
use super::{Resident, shaders};
use crate::error::Result;
use crate::gpu::{Gpu, Shader};
use wgpu::Buffer;

/// Sources between two occluders.
pub(super) struct Slab {
    slices: Option<Slices>,
    /// Number of occluders that its light must pass.
    pub passed: usize,
    /// Whether each slice has a slope term.
    pub sloping: bool,
    /// Its spectra, cut so that each part can be bound.
    pub parts: Vec<Part>,
    /// What its light must pass.
    pub occluder: Option<Node>,
}

/// Bytes of the largest part: even a slow adapter gathers it in a tenth of a second, well within a watchdog's patience.
const LARGEST_PART: usize = 128 << 20;

/// Some columns of all spectra: for each column the slices, then their slope terms.
pub(super) struct Part {
    pub begin: usize,
    pub columns: usize,
    pub spectra: Buffer,
}

impl Slab {
    pub(super) fn new(
        gpu: &Gpu,
        (plan, layers): (&Plan, &[Layer]),
        canvas: &Canvas,
        fft: &FftPlan,
        resident: &Resident,
        passed: usize,
    ) -> Result<Self> {
        let slices = plan.slices[passed].clone();
        let mut mine = layers.iter().flatten().flatten().filter(|s| s.occluders == passed);
        let sloping = mine.any(|s| s.slope != [0.0; 2]);
        let occluder = plan.occluder(passed).map(|occluder| plan.node(occluder));
        let mut slab = Self { slices, passed, sloping, parts: Vec::new(), occluder };
        slab.parts = Part::all(gpu, canvas, slab.planes())?;
        slab.fill(gpu, canvas, fft, resident)?;
        Ok(slab)
    }

    pub(super) fn nodes(&self) -> &[Node] {
        self.slices.as_ref().map_or(&[], |s| &s.nodes)
    }

    /// Weighs the object for each slice and transforms it.
    fn fill(&self, gpu: &Gpu, canvas: &Canvas, fft: &FftPlan, resident: &Resident) -> Result<()> {
        let Some(slices) = &self.slices else { return Ok(()) };
        let (count, (counts, exact)) = (slices.nodes.len(), slices.counts());
        let nodes = gpu.upload("slices", &slices.node_places())?;
        let size = [canvas.fft.width as u32, canvas.fft.height as u32];
        let mut pairs = resident.pairs.borrow_mut();
        let mut transform = |chosen: [u32; 2], sloping: bool, store: &Shader, places: [u32; 2]| {
            let mut recording = gpu.record();
            let weigh = Weigh {
                canvas: resident.layout,
                slab: self.passed as u32,
                exact: u32::from(exact),
                counts: counts.map(|n| n as u32),
                slices: chosen,
                sloping: u32::from(sloping),
                padding: 0,
            };
            let buffers = [&resident.sources, &nodes, &pairs[0]];
            recording.dispatch(&gpu.stage(&shaders::WEIGH), &weigh, &buffers, canvas.pixels());
            fft.record(&mut recording, &mut pairs, &[0], false);
            for part in &self.parts {
                let parameters = Store {
                    size,
                    begin: part.begin as u32,
                    columns: part.columns as u32,
                    planes: self.planes() as u32,
                    places,
                    padding: 0,
                };
                let values = part.columns * canvas.fft.height;
                recording.dispatch(&gpu.stage(store), &parameters, &[&pairs[0], &part.spectra], values);
            }
            gpu.submit(recording)
        };
        for first in (0..count as u32).step_by(2) {
            let second = if first + 1 < count as u32 { first + 1 } else { NOTHING };
            transform([first, second], false, &shaders::SPLIT, [first, second])?;
        }
        if self.sloping {
            for slice in 0..count as u32 {
                transform([slice, NOTHING], true, &shaders::SLOPE_CORRECTION, [count as u32 + slice, 0])?;
            }
        }
        Ok(())
    }

    /// Spectra of each column.
    fn planes(&self) -> usize {
        self.nodes().len() * if self.sloping { 2 } else { 1 }
    }
}

impl Part {
    /// Parts for `planes` spectra.
    fn all(gpu: &Gpu, canvas: &Canvas, planes: usize) -> Result<Vec<Self>> {
        let (half, height) = (canvas.fft.half_width(), canvas.fft.height);
        let column = planes.max(1) * height * size_of::<[f32; 2]>();
        gpu.check_size("a column of the slices", column)?;
        let bytes = (gpu.adapter().most_bytes as usize).min(LARGEST_PART);
        let most = (bytes / column).clamp(1, half);
        let part = |begin: usize| {
            let columns = most.min(half - begin);
            let spectra = gpu.empty::<[f32; 2]>("the slices", columns * planes * height)?;
            Ok(Self { begin, columns, spectra })
        };
        (0..half).step_by(most).map(part).collect()
    }
}
