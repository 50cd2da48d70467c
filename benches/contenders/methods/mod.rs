//! The contenders: four ways to the same image on a graphics adapter, and the CPU path beside them.

mod depths;
mod fft;
mod mixture;
mod pyramid;
mod scene;
mod stages;
mod tile;
mod work;

pub use scene::{Scene, errors};
pub use work::Work;

use super::common;
use narrowbeam::error::Result;
use narrowbeam::filter::Optics;
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::gpu::Gpu;
use std::fmt;
use std::time::Instant;

/// A contender, with what it trades time for error by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The program's filter on the CPU, with slices for its own tolerance.
    Cpu,
    /// The program's filter on the adapter: with this many slices, or those for its own tolerance.
    Fft(Option<usize>),
    /// Sums over a disc by way of tiles. The share of scattered light beyond the disc, to be spread over it.
    Gather(f64),
    /// A sum of Gaussians at full resolution. The ratio of neighbouring widths.
    Gaussians(f64),
    /// The same with wide ones on coarser images.
    Pyramid(f64),
}

/// Nodes in depth of the polynomials of tiles and Gaussians.
pub const NODES: usize = 6;

/// Seconds and the image.
pub struct Measured {
    /// What a fit pays once: all that does not depend on the medium.
    pub prepare: f64,
    /// What every image costs.
    pub render: f64,
    /// The image.
    pub image: Vec<f32>,
}

impl Method {
    /// All contenders at the settings of the grid.
    pub const GRID: [Method; 5] =
        [Method::Cpu, Method::Fft(None), Method::Gather(1e-3), Method::Gaussians(1.6), Method::Pyramid(1.6)];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Method::Cpu => "cpu",
            Method::Fft(_) => "fft",
            Method::Gather(_) => "gather",
            Method::Gaussians(_) => "gaussians",
            Method::Pyramid(_) => "pyramid",
        }
    }

    /// What it trades by, as a number; none where the program decides.
    pub fn setting(self) -> String {
        match self {
            Method::Cpu | Method::Fft(None) => String::new(),
            Method::Fft(Some(slices)) => slices.to_string(),
            Method::Gather(outside) => outside.to_string(),
            Method::Gaussians(ratio) | Method::Pyramid(ratio) => format!("{ratio:.3}"),
        }
    }

    /// Preparation and render of `scene` through the medium of `optics`, each the median of `repeats`.
    ///
    /// # Errors
    /// As [`Optics::kernel`], and [`Error::Gpu`](narrowbeam::error::Error::Gpu) if the device fails.
    pub fn measure(self, gpu: &Gpu, scene: &Scene, optics: &Optics, repeats: usize) -> Result<Measured> {
        match self {
            Method::Cpu => {
                let prepare = || CpuFilter::new(scene.target(), optics, 1.0);
                timed(repeats, prepare, |filter| Ok(filter.render(optics)?.data))
            }
            Method::Fft(slices) => {
                let prepare = || fenced(gpu, || fft::prepare(gpu, scene, optics, slices));
                timed(repeats, prepare, |filter| Ok(filter.render(optics)?.data))
            }
            Method::Gather(outside) => {
                let prepare = || fenced(gpu, || tile::Tiles::new(gpu, scene));
                timed(repeats, prepare, |tiles| tiles.render(optics, outside))
            }
            Method::Gaussians(ratio) | Method::Pyramid(ratio) => {
                let mixture = self.mixture(scene, ratio);
                let prepare = || fenced(gpu, || pyramid::Pyramid::new(gpu, scene, &mixture));
                timed(repeats, prepare, |pyramid| pyramid.render(optics))
            }
        }
    }

    /// What preparation and render ask of an adapter; the CPU's filter counts as the adapter's.
    pub fn work(self, scene: &Scene) -> [Work; 2] {
        match self {
            Method::Cpu => fft::work(scene, None),
            Method::Fft(slices) => fft::work(scene, slices),
            Method::Gather(outside) => tile::work(scene, outside),
            Method::Gaussians(ratio) | Method::Pyramid(ratio) => {
                pyramid::work(scene, &self.mixture(scene, ratio))
            }
        }
    }

    fn mixture(self, scene: &Scene, ratio: f64) -> mixture::GaussianMixture {
        let coarse = matches!(self, Method::Pyramid(_));
        mixture::GaussianMixture::new(
            scene.width_px * scene.depths(1).far() / scene.depths(1).middle,
            ratio,
            coarse,
        )
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.name(), self.setting())
    }
}

/// Runs `prepare` and `render` `repeats` times each; medians.
fn timed<T>(
    repeats: usize,
    prepare: impl Fn() -> Result<T>,
    render: impl Fn(&T) -> Result<Vec<f32>>,
) -> Result<Measured> {
    let (mut preparing, mut rendering) = (Vec::new(), Vec::new());
    let mut image = Vec::new();
    for _ in 0..repeats {
        let start = Instant::now();
        let prepared = prepare()?;
        preparing.push(start.elapsed().as_secs_f64());
        let start = Instant::now();
        image = render(&prepared)?;
        rendering.push(start.elapsed().as_secs_f64());
    }
    Ok(Measured { prepare: median(preparing), render: median(rendering), image })
}

fn median(mut seconds: Vec<f64>) -> f64 {
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// What `prepare` gives, when the device has done it.
fn fenced<T>(gpu: &Gpu, prepare: impl FnOnce() -> Result<T>) -> Result<T> {
    let prepared = prepare()?;
    gpu.read::<f32>(&gpu.empty::<f32>("fence", 1)?, 1)?;
    Ok(prepared)
}
