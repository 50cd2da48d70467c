//! The filter on a graphics adapter: the same planes, slices and tables as on the CPU, the rest in the shaders of
//! `shaders/`.
//!
//! Two real images are transformed as one complex one: two slices when a target is prepared, image and derivatives when
//! it is rendered. Spectra of the slices stay on the device; a render uploads the tables of its transfer functions and
//! reads back an image, or, in a fit, 21 sums.

mod fft;
mod layout;
mod segment;
mod tables;

pub mod shaders;

pub use fft::FftPlan;
pub use layout::{
    Canvas as CanvasLayout, Collect, Gather, NOTHING, PRODUCTS, Pass, Source, Store, Sums, Total, Weigh,
};
pub use tables::Record;

use super::canvas::Canvas;
use super::plan::{Coverage, Plan};
use super::sources::Sheet;
use super::transfer::Way;
use super::{Optics, Target};
use crate::error::Result;
use crate::gpu::{Gpu, Recording};
use crate::image::Image;
use crate::phase::PhaseFunction;
use segment::Segment;
use tables::{Tables, Units, axes};
use wgpu::Buffer;

/// A target prepared on a graphics adapter for many renders.
pub struct GpuFilter<'a> {
    gpu: &'a Gpu,
    plan: Plan<'a>,
    canvas: Canvas,
    fft: FftPlan,
    /// From near to far; all but the first lie behind a screen.
    segments: Vec<Segment>,
    resident: Resident,
}

/// What stays on the device from one render to the next.
struct Resident {
    layout: CanvasLayout,
    sources: Buffer,
    /// For each object pixel a bit for each screen.
    opaque: Buffer,
    axes: Buffer,
    /// Of the obliquities.
    weights: Buffer,
    /// Image and derivatives over the view.
    planes: Buffer,
    /// Image and first derivative, second and third, each as one complex image; working space.
    pairs: std::cell::RefCell<[Buffer; 3]>,
}

/// An observation on the device: values and weights.
pub struct GpuObservation {
    pixels: Buffer,
}

/// Workgroups that sum products.
const SUMMING_GROUPS: usize = 64;

impl<'a> GpuFilter<'a> {
    /// Prepares `target` for kernels up to as wide as those of `optics`, times `headroom`.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::Gpu`](crate::Error::Gpu) if the device cannot hold it.
    pub fn new(gpu: &'a Gpu, target: Target<'a>, optics: &Optics, headroom: f64) -> Result<Self> {
        Self::of(gpu, Plan::new(target, optics, headroom)?)
    }

    /// Prepares `target` with at most `count` slices along z between any two screens and padding for kernels that reach
    /// `reach_px` pixels.
    ///
    /// # Errors
    /// [`Error::Gpu`](crate::Error::Gpu) if the device cannot hold it.
    pub fn with_slices(gpu: &'a Gpu, target: Target<'a>, count: usize, reach_px: f64) -> Result<Self> {
        Self::of(gpu, Plan::with_slices(target, count, reach_px))
    }

    pub(super) fn of(gpu: &'a Gpu, (plan, sheets): (Plan<'a>, Vec<Sheet>)) -> Result<Self> {
        let canvas = Canvas::new(&plan.target, plan.reach_px);
        let fft = FftPlan::new(gpu, canvas.fft.width, canvas.fft.height)?;
        let resident = Resident::new(gpu, &plan, &canvas, &sheets)?;
        let segments = (0..plan.slices.len())
            .map(|passed| Segment::new(gpu, (&plan, &sheets), &canvas, &fft, &resident, passed))
            .collect::<Result<_>>()?;
        Ok(Self { gpu, plan, canvas, fft, segments, resident })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        self.gpu
    }

    /// How far padding and slices serve the kernels of `optics` too.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn coverage(&self, optics: &Optics) -> Result<Coverage> {
        self.plan.coverage(optics)
    }

    /// Number of slices.
    pub fn slice_count(&self) -> usize {
        self.plan.slice_count()
    }

    /// Number of complex 2-D FFTs that one render takes, without and with the derivatives, and their size.
    pub fn transforms(&self) -> (usize, usize, [usize; 2]) {
        let images = (2 * self.segments.len() - 1) * self.plan.obliquities.count();
        (images, 2 * images, [self.canvas.fft.width, self.canvas.fft.height])
    }

    /// Bytes that the stages of one render read and write on the device, without and with the derivatives: what no
    /// rearrangement of the same stages can save. Tables, which stay in caches, do not count.
    pub fn traffic(&self) -> (usize, usize) {
        let complex = size_of::<[f32; 2]>();
        let (canvas, view) = (self.canvas.pixels(), self.plan.target.view.pixels());
        let source = size_of::<Source>() * self.resident.layout.sheets as usize;
        let of = |images: usize| {
            let pairs = images.div_ceil(2) * canvas * complex;
            let segment = |segment: &Segment| {
                let spectra: usize = segment.parts.iter().map(|part| part.spectra.size() as usize).sum();
                let fft = 2 * self.fft.passes() * pairs;
                // A screen: light from it is read where it is gathered, passed, and transformed once more.
                let screen = if segment.screen.is_some() { 3 * pairs + canvas * source + fft } else { 0 };
                spectra + pairs + fft + screen
            };
            let once: usize = self.segments.iter().map(segment).sum();
            let collected = view * (images.div_ceil(2) * complex + source + images * size_of::<f32>());
            self.plan.obliquities.count() * (once + collected)
        };
        (of(1), of(4))
    }

    /// The image through the medium, over the target's view.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::Gpu`](crate::Error::Gpu) if the device fails.
    pub fn render(&self, optics: &Optics) -> Result<Image> {
        self.gpu.submit(self.evaluate(optics, false)?)?;
        let (width, height) = (self.plan.target.view.width, self.plan.target.view.height);
        let data = self.gpu.read(&self.resident.planes, width * height)?;
        Ok(Image { width, height, data })
    }

    /// The image and its derivatives in sigma_s, sigma_a and B, over the target's view.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_with_gradient(&self, optics: &Optics) -> Result<super::cpu::Rendering> {
        self.gpu.submit(self.evaluate(optics, true)?)?;
        let (width, height) = (self.plan.target.view.width, self.plan.target.view.height);
        let all: Vec<f32> = self.gpu.read(&self.resident.planes, 4 * width * height)?;
        let units = self.units(optics).0;
        let plane = |i: usize| {
            let values = &all[i * width * height..(i + 1) * width * height];
            let data = values.iter().map(|v| (f64::from(*v) * units[i]) as f32).collect();
            Image { width, height, data }
        };
        Ok(super::cpu::Rendering { image: plane(0), gradient: Some([plane(1), plane(2), plane(3)]), motion: None })
    }

    /// Uploads an observation over the view: the value of each of its `pixels`, and its weight, 0 where it does not count.
    ///
    /// # Errors
    /// [`Error::Gpu`](crate::Error::Gpu) if the device cannot hold it.
    pub fn observe(&self, pixels: impl Iterator<Item = (f32, f32)>) -> Result<GpuObservation> {
        let pixels: Vec<[f32; 2]> = pixels.map(|(y, weight)| [y, weight]).collect();
        Ok(GpuObservation { pixels: self.gpu.upload("the observed image", &pixels)? })
    }

    /// Weighted sums over the pixels of `observation` of the products of six images: the render m, its derivatives
    /// in sigma_s, sigma_a and B (0 unless wanted), the residual gain · m + veil - y, and 1.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn products(
        &self,
        optics: &Optics,
        observation: &GpuObservation,
        [gain, veil]: [f64; 2],
        derivatives: bool,
        _shift: Option<[f64; 2]>,
    ) -> Result<nalgebra::DMatrix<f64>> {
        let mut recording = self.evaluate(optics, derivatives)?;
        let view = self.plan.target.view;
        let parameters = Sums {
            pixels: view.pixels() as u32,
            gain: gain as f32,
            veil: veil as f32,
            derivatives: u32::from(derivatives),
            zero: 0,
            padding: [0; 3],
        };
        let partial = self.gpu.empty::<[f32; 2]>("partial sums", SUMMING_GROUPS * PRODUCTS)?;
        let whole = self.gpu.empty::<[f32; 2]>("sums", PRODUCTS)?;
        let total = Total { groups: SUMMING_GROUPS as u32, products: PRODUCTS as u32, zero: 0, padding: 0 };
        let (sums_stage, total_stage) = (self.gpu.stage(&shaders::SUMS), self.gpu.stage(&shaders::TOTAL));
        let read = [&self.resident.planes, &observation.pixels, &partial];
        recording.dispatch_groups(&sums_stage, &parameters, &read, SUMMING_GROUPS);
        recording.dispatch_groups(&total_stage, &total, &[&partial, &whole], 1);
        self.gpu.submit(recording)?;
        let sums: Vec<[f32; 2]> = self.gpu.read(&whole, PRODUCTS)?;
        let [m, s, a, b] = self.units(optics).0;
        let units = [m, s, a, b, 1.0, 1.0];
        let mut all = [[0.0; 6]; 6];
        let pairs = (0..6).flat_map(|i| (0..=i).map(move |j| (i, j)));
        for ((i, j), [high, low]) in pairs.zip(sums) {
            all[i][j] = (f64::from(high) + f64::from(low)) * units[i] * units[j];
            all[j][i] = all[i][j];
        }
        Ok(nalgebra::DMatrix::from_fn(6, 6, |i, j| all[i][j]))
    }

    fn units(&self, optics: &Optics) -> Units {
        Units::new(self.plan.farthest(), optics.medium.phase().planar_width())
    }

    /// Records what leaves the image, and its derivatives if they are wanted, in the resident planes. Where light passes
    /// screens or obliquities are many, all but the last step is submitted already.
    fn evaluate(&self, optics: &Optics, derivatives: bool) -> Result<Recording> {
        let mut last: Option<Recording> = None;
        for (before, (obliquity, _)) in self.plan.obliquities.iter().enumerate() {
            let mut carried = None;
            for segment in self.segments.iter().rev() {
                if let Some(before) = last.take() {
                    self.gpu.submit(before)?;
                }
                let mut recording = self.gpu.record();
                let way = Way::new(
                    segment.nodes(),
                    segment.sloping.then_some(self.plan.target.geometry.pitch_per_depth()),
                    carried,
                    segment.screen,
                    (optics, obliquity),
                )?;
                self.gather(
                    &mut recording,
                    segment,
                    &Tables::new(&way, &self.units(optics)),
                    carried.is_some(),
                    derivatives,
                )?;
                let which: &[usize] = if derivatives { &[0, 1] } else { &[0] };
                let mut pairs = self.resident.pairs.borrow_mut();
                self.fft.record(&mut recording, &mut pairs, which, true);
                if segment.screen.is_some() {
                    self.pass(&mut recording, segment, optics, &pairs, derivatives);
                    self.fft.record(&mut recording, &mut pairs, which, false);
                } else {
                    self.collect(&mut recording, optics, &pairs, before, derivatives);
                }
                last = Some(recording);
                carried = segment.screen;
            }
        }
        Ok(last.unwrap_or_else(|| self.gpu.record()))
    }

    fn gather(
        &self,
        recording: &mut Recording,
        segment: &Segment,
        tables: &Tables,
        carried: bool,
        derivatives: bool,
    ) -> Result<()> {
        let records = self.gpu.upload("slices", &tables.records)?;
        let entries = self.gpu.upload("tables", &tables.entries)?;
        let (width, height) = (self.canvas.fft.width, self.canvas.fft.height);
        let pairs = self.resident.pairs.borrow();
        for part in &segment.parts {
            let parameters = Gather {
                size: [width as u32, height as u32],
                begin: part.begin as u32,
                columns: part.columns as u32,
                slices: segment.nodes().len() as u32,
                sloping: u32::from(segment.sloping),
                carried: u32::from(carried),
                gated: u32::from(segment.screen.is_some()),
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

    fn pass(
        &self,
        recording: &mut Recording,
        segment: &Segment,
        optics: &Optics,
        pairs: &[Buffer; 3],
        derivatives: bool,
    ) {
        let Some(screen) = segment.screen else { return };
        let parameters = Pass {
            canvas: self.resident.layout,
            segment: segment.passed as u32,
            bit: 1 << (segment.passed - 1),
            z: screen.z as f32,
            sigma_t: optics.medium.sigma_t() as f32,
            unit: self.plan.farthest() as f32,
            derivatives: u32::from(derivatives),
            padding: [0; 2],
        };
        let buffers = [&self.resident.sources, &self.resident.opaque, &pairs[0], &pairs[1]];
        recording.dispatch(&self.gpu.stage(&shaders::PASS), &parameters, &buffers, self.canvas.pixels());
    }

    fn collect(
        &self,
        recording: &mut Recording,
        optics: &Optics,
        pairs: &[Buffer; 3],
        before: usize,
        derivatives: bool,
    ) {
        let view = self.plan.target.view;
        let parameters = Collect {
            canvas: self.resident.layout,
            view: [view.x as u32, view.y as u32],
            view_size: [view.width as u32, view.height as u32],
            sigma_t: optics.medium.sigma_t() as f32,
            unit: self.plan.farthest() as f32,
            derivatives: u32::from(derivatives),
            before: before as u32,
            direct: u32::from(before == 0),
            padding: [0; 3],
        };
        let Resident { sources, weights, planes, .. } = &self.resident;
        let buffers = [sources, weights, &pairs[0], &pairs[1], planes];
        recording.dispatch(&self.gpu.stage(&shaders::COLLECT), &parameters, &buffers, view.pixels());
    }
}

impl Resident {
    fn new(gpu: &Gpu, plan: &Plan, canvas: &Canvas, sheets: &[Sheet]) -> Result<Self> {
        let (view, pixels) = (plan.target.view.pixels(), canvas.pixels());
        let mut opaque = vec![0u32; plan.target.radiance.data.len()];
        for (i, screen) in plan.screens().iter().enumerate() {
            let marked = opaque.iter_mut().zip(&screen.opaque).filter(|(_, opaque)| **opaque);
            marked.for_each(|(bits, _)| *bits |= 1 << i);
        }
        let weights: Vec<f32> =
            plan.obliquities.iter().flat_map(|(_, w)| w.unwrap_or(&[1.0]).to_vec()).collect();
        let pair = || gpu.empty::<[f32; 2]>("the padded image", pixels);
        Ok(Self {
            layout: CanvasLayout::new(canvas, plan.target.border, sheets.len()),
            sources: gpu.upload("the object image", &layout::sources(sheets, &plan.slices))?,
            opaque: gpu.upload("screens", &opaque)?,
            axes: gpu.upload("frequencies", &axes(canvas))?,
            weights: gpu.upload("the weights of the obliquities", &weights)?,
            planes: gpu.empty::<f32>("the rendered image", 4 * view)?,
            pairs: std::cell::RefCell::new([pair()?, pair()?, pair()?]),
        })
    }
}
