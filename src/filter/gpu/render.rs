//! The steps of one render: light is gathered from far to near, passes the occluders, and is collected at the camera.

use super::layout::{Collect, Gather, Pass};
use super::slab::Slab;
use super::tables::{Tables, Units};
use super::{GpuFilter, Resident, shaders};
use crate::error::Result;
use crate::filter::Optics;
use crate::filter::shift::Shift;
use crate::filter::transfer::Way;
use crate::gpu::Recording;
use crate::phase::PhaseFunction;
use wgpu::Buffer;

/// What a render is to give.
pub(super) struct Request<'r> {
    pub optics: &'r Optics,
    /// Whether its derivatives too.
    pub derivatives: bool,
    pub shift: Option<Shift>,
}

impl Request<'_> {
    /// The pairs of images that it takes.
    pub(super) fn pairs(&self) -> &'static [usize] {
        if self.derivatives { &[0, 1] } else { &[0] }
    }

    /// Images that come out.
    pub(super) fn images(&self) -> usize {
        match (self.derivatives, &self.shift) {
            (false, _) => 1,
            (true, None) => 4,
            (true, Some(_)) => 6,
        }
    }
}

impl GpuFilter<'_> {
    pub(super) fn units(&self, optics: &Optics) -> Units {
        Units::new(self.plan.farthest(), optics.medium.phase().planar_width())
    }

    /// Records what leaves the images that are asked for in the [planes](Self::planes). Where light passes occluders or
    /// obliquities are many, all but the last step is submitted already.
    pub(super) fn evaluate(&self, request: &Request) -> Result<Recording> {
        let mut last: Option<Recording> = None;
        for (before, (obliquity, _)) in self.plan.obliquities.iter().enumerate() {
            let mut carried = None;
            for slab in self.slabs.iter().rev() {
                if let Some(before) = last.take() {
                    self.gpu.submit(before)?;
                }
                let mut recording = self.gpu.record();
                let way = Way::new(
                    slab.nodes(),
                    slab.sloping.then_some(self.plan.target.geometry.pitch_per_depth()),
                    carried,
                    slab.occluder,
                    (request.optics, obliquity, self.plan.target.sampling),
                )?;
                let tables = Tables::new(&way, &self.units(request.optics));
                self.gather(&mut recording, slab, &tables, carried.is_some(), request.derivatives)?;
                let mut pairs = self.resident.pairs.borrow_mut();
                self.fft.record(&mut recording, &mut pairs, request.pairs(), true);
                if slab.occluder.is_some() {
                    self.pass(&mut recording, slab, request, &pairs);
                    self.fft.record(&mut recording, &mut pairs, request.pairs(), false);
                } else if request.shift.is_some() {
                    self.arrive(&mut recording, request, &pairs, before)?;
                } else {
                    self.collect(&mut recording, request, &pairs, before);
                }
                last = Some(recording);
                carried = slab.occluder;
            }
        }
        let mut recording = last.unwrap_or_else(|| self.gpu.record());
        if let Some(shift) = &request.shift {
            self.shift(&mut recording, request, shift)?;
        }
        Ok(recording)
    }

    fn gather(
        &self,
        recording: &mut Recording,
        slab: &Slab,
        tables: &Tables,
        carried: bool,
        derivatives: bool,
    ) -> Result<()> {
        let records = self.gpu.upload("slices", &tables.records)?;
        let entries = self.gpu.upload("tables", &tables.entries)?;
        let (width, height) = (self.canvas.fft.width, self.canvas.fft.height);
        let pairs = self.resident.pairs.borrow();
        for part in &slab.parts {
            let parameters = Gather {
                size: [width as u32, height as u32],
                begin: part.begin as u32,
                columns: part.columns as u32,
                slices: slab.nodes().len() as u32,
                sloping: u32::from(slab.sloping),
                carried: u32::from(carried),
                occluded: u32::from(slab.occluder.is_some()),
                derivatives: u32::from(derivatives),
                scale: tables.scale.0,
                scale_per_w: tables.scale.1,
                padding: 0,
            };
            let buffers = [&records, &entries, &self.resident.axes, &part.spectra, &pairs[0], &pairs[1]];
            let groups = part.columns * (height / 2 + 1).div_ceil(64);
            recording.dispatch_groups(&self.gpu.stage(&shaders::GATHER), &parameters, &buffers, groups);
            if part.begin + part.columns < self.canvas.fft.half_width() {
                // One part is short enough for a watchdog; several need not be.
                self.gpu.submit(std::mem::replace(recording, self.gpu.record()))?;
            }
        }
        Ok(())
    }

    fn pass(&self, recording: &mut Recording, slab: &Slab, request: &Request, pairs: &[Buffer; 3]) {
        let Some(occluder) = slab.occluder else { return };
        let parameters = Pass {
            canvas: self.resident.layout,
            slab: slab.passed as u32,
            bit: 1 << (slab.passed - 1),
            z: occluder.z as f32,
            sigma_t: request.optics.medium.sigma_t() as f32,
            unit: self.plan.farthest() as f32,
            derivatives: u32::from(request.derivatives),
            padding: [0; 2],
        };
        let buffers = [&self.resident.sources, &self.resident.opaque, &pairs[0], &pairs[1]];
        recording.dispatch(&self.gpu.stage(&shaders::PASS), &parameters, &buffers, self.canvas.pixels());
    }

    fn collect(&self, recording: &mut Recording, request: &Request, pairs: &[Buffer; 3], before: usize) {
        let Resident { sources, weights, planes, .. } = &self.resident;
        let buffers = [sources, weights, &pairs[0], &pairs[1], planes];
        let parameters = self.collecting(request, before);
        let pixels = self.plan.target.view.pixels();
        recording.dispatch(&self.gpu.stage(&shaders::COLLECT), &parameters, &buffers, pixels);
    }

    /// How the light of the obliquity number `before` is collected.
    pub(super) fn collecting(&self, request: &Request, before: usize) -> Collect {
        let view = self.plan.target.view;
        Collect {
            canvas: self.resident.layout,
            view: [view.x as u32, view.y as u32],
            view_size: [view.width as u32, view.height as u32],
            sigma_t: request.optics.medium.sigma_t() as f32,
            unit: self.plan.farthest() as f32,
            derivatives: u32::from(request.derivatives),
            before: before as u32,
            direct: u32::from(before == 0),
            padding: [0; 3],
        }
    }
}
