//! CPU and graphics adapter on the same scenes: what preparing a target, a render and one evaluation of a fit cost, and
//! the floor of each.
//!
//! - *prepare*: from the object in memory to its slices' spectra; on a device this uploads the object.
//! - *render*: transfer functions, image, and on a device its way back.
//! - *evaluate*: image and three derivatives, and the 21 sums of a fit; on a device, which holds the observation, only
//!   these come back.
//!
//! The floor of the CPU is the time of its real 2-D FFTs alone, that of a device the bytes of its stages over the speed at
//! which it copies. Arguments are image sides, or WIDTHxHEIGHT; without any: 256 512 1024 2048.
//!
//! ```sh
//! cargo bench --bench backends -- 256 1920x1080
//! ```

mod common;
#[path = "../tests/it/common/mod.rs"]
mod scenes;

use common::fft_seconds;
use narrowbeam::filter::{Backend, Filter, Optics, Prepared, Target};
use narrowbeam::geometry::Geometry;
use narrowbeam::gpu::Gpu;
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;
use std::time::Instant;

const DEPTH: f64 = 2.0;
const PIXEL_PITCH: f64 = 0.01;
/// Kernel width z sqrt(B), px.
const WIDTH_PX: f64 = 5.0;
/// Slope of the depth map: 15 degrees.
const SLOPE: f64 = 0.27;
/// Each figure is a median of measurements that together take about this long, seconds.
const PATIENCE: f64 = 2.0;

fn main() {
    // `cargo test` runs this file too, and times nothing.
    if !std::env::args().any(|a| a == "--bench") {
        return;
    }
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let sizes =
        if wanted.is_empty() { ["256", "512", "1024", "2048"].map(String::from).to_vec() } else { wanted };
    let gpu = Gpu::open();
    match &gpu {
        Ok(gpu) => println!("adapter: {}, copies {:.1} GB/s", gpu.adapter(), bandwidth(gpu) / 1e9),
        Err(e) => println!("{e}"),
    }
    println!("CPU: {} threads\n", std::thread::available_parallelism().map_or(1, |n| n.get()));
    println!("| scene | backend | slices, padded | prepare | render | floor | evaluate | floor |");
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    for size in &sizes {
        let Some((width, height)) = parse(size) else {
            eprintln!("{size}: give a side or WIDTHxHEIGHT, in pixels");
            std::process::exit(2);
        };
        for sloping in [false, true] {
            let scene = Scene::new(width, height, sloping);
            scene.row(Backend::Cpu, None);
            if let Ok(gpu) = &gpu {
                scene.row(Backend::Gpu(gpu), Some(bandwidth(gpu)));
            }
        }
    }
}

fn parse(size: &str) -> Option<(usize, usize)> {
    let (width, height) = size.split_once('x').unwrap_or((size, size));
    Some((width.parse().ok()?, height.parse().ok()?)).filter(|(w, h)| *w > 0 && *h > 0)
}

struct Scene {
    name: String,
    radiance: Image,
    geometry: Geometry,
    filter: Filter,
}

impl Scene {
    fn new(width: usize, height: usize, sloping: bool) -> Self {
        let geometry = if sloping {
            scenes::sloping(
                width,
                height,
                PIXEL_PITCH,
                DEPTH.max(0.6 * SLOPE * PIXEL_PITCH * width as f64),
                SLOPE,
            )
        } else {
            Geometry::planar(width, height, PIXEL_PITCH, DEPTH).unwrap()
        };
        let kind = if sloping { "depth map, composite" } else { "one depth" };
        Self {
            name: format!("{width}x{height}, {kind}"),
            radiance: scenes::texture(width, height),
            filter: if sloping { Filter::Composite } else { Filter::Eq29 },
            geometry,
        }
    }

    fn row(&self, backend: Backend, bandwidth: Option<f64>) {
        let relief = self.filter.relief(&self.geometry);
        let view = View::whole(self.geometry.width, self.geometry.height);
        let target = Target {
            radiance: &self.radiance,
            behind: &[],
            geometry: &self.geometry,
            border: Border::Zero,
            sampling: Sampling::Pixel,
            view,
            relief: relief.as_ref(),
        };
        let phase = Gaussian::new((WIDTH_PX * PIXEL_PITCH / DEPTH).powi(2)).unwrap();
        let medium = Medium::new(0.95, 0.05, phase.into()).unwrap();
        let optics = Optics { model: Model::SmallAngle, medium };
        let prepare = || backend.prepare(target, &optics, 1.0).expect("the device holds it");
        let prepared = prepare();
        let preparing = median(|| finish(&prepare()));
        let rendering = median(|| drop(prepared.render(&optics).unwrap()));
        let (evaluating, slices, floors) = match &prepared {
            Prepared::Cpu(filter) => {
                let evaluating = median(|| drop(filter.render_with_gradient(&optics).unwrap()));
                let (one, four, size) = filter.transforms();
                let floor = fft_seconds(size);
                (evaluating, filter.slice_count(), [one as f64 * floor, four as f64 * floor])
            }
            Prepared::Gpu(filter) => {
                let observation = filter.observe(self.radiance.data.iter().map(|&v| (v, 1.0))).unwrap();
                let evaluate = || filter.products(&optics, &observation, [1.0, 0.0], true, None).unwrap();
                let evaluating = median(|| _ = evaluate());
                let (one, four) = filter.traffic();
                let speed = bandwidth.expect("a device has one");
                (evaluating, filter.slice_count(), [one, four].map(|bytes| bytes as f64 / speed))
            }
        };
        let (_, _, [width, height]) = prepared.transforms();
        println!(
            "| {} | {} | {slices}, {width}x{height} | {} | {} | {} | {} | {} |",
            self.name,
            backend.name(),
            ms(preparing),
            ms(rendering),
            ms(floors[0]),
            ms(evaluating),
            ms(floors[1])
        );
    }
}

/// Waits until the device has done what it was asked for.
fn finish(prepared: &Prepared) {
    if let Prepared::Gpu(filter) = prepared {
        filter.gpu().wait().expect("the device goes on");
    }
}

fn ms(seconds: f64) -> String {
    let ms = 1e3 * seconds;
    if ms < 10.0 { format!("{ms:.2} ms") } else { format!("{ms:.0} ms") }
}

/// Median time of `f`, seconds.
fn median(mut f: impl FnMut()) -> f64 {
    let mut once = || {
        let start = Instant::now();
        f();
        start.elapsed().as_secs_f64()
    };
    let first = once();
    let repeats = (PATIENCE / first.max(1e-9)).clamp(1.0, 50.0) as usize;
    let mut all: Vec<f64> = (0..repeats).map(|_| once()).collect();
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// Bytes read and written a second by copies of 64 MiB.
fn bandwidth(gpu: &Gpu) -> f64 {
    const BYTES: usize = 64 << 20;
    const COPIES: usize = 8;
    let [from, to] = [0; 2].map(|_| gpu.empty::<u8>("copy", BYTES).unwrap());
    let copy = || {
        let mut recording = gpu.record();
        (0..COPIES).for_each(|_| recording.copy(&from, &to, BYTES as u64));
        gpu.submit(recording).unwrap();
        gpu.wait().unwrap();
    };
    (2 * BYTES * COPIES) as f64 / median(copy)
}
