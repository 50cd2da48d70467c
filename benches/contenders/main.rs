//! Which way to the image is the fastest on a graphics adapter, by kernel width and image size.
//!
//! Four contenders (`methods`) filter the same scenes: a texture at one depth, and on a slope of 16 depths. Each is
//! timed, compared with a reference and counted. `docs/contenders.md` has what came out and how to read it.
//!
//! ```sh
//! cargo bench --bench contenders -- --out docs          # all, some ten minutes on a software adapter
//! cargo bench --bench contenders -- --quick             # a small grid, half a minute
//! ```

mod chart;
#[path = "../../tests/it/common/mod.rs"]
mod common;
mod methods;
mod row;

use anyhow::Result;
use clap::Parser;
use methods::{Method, Scene, Work, errors};
use narrowbeam::gpu::Gpu;
use row::{Row, Timing};
use std::path::PathBuf;

#[derive(Debug, Parser)]
struct Arguments {
    /// Sides of the images that are timed, px.
    #[arg(long, value_delimiter = ',', default_value = "256,512,1024,2048")]
    sizes: Vec<usize>,
    /// Kernel widths z·sqrt(B)/pitch that are timed, px.
    #[arg(long, value_delimiter = ',', default_value = "0.3,0.5,1,2,4,8,16,32,64,128,256")]
    widths: Vec<f64>,
    /// Only 128 px and three widths.
    #[arg(long)]
    quick: bool,
    /// What would take more operations for one image is counted, but not timed.
    #[arg(long, default_value_t = 1.0)]
    most_gflop: f64,
    /// Where contenders.csv and contenders.png go; without it nothing is written.
    #[arg(long)]
    out: Option<PathBuf>,
    /// What `cargo bench` adds, but `cargo test` does not.
    #[arg(long, hide = true)]
    bench: bool,
}

/// The grid that is counted.
const SIZES: [usize; 4] = [256, 512, 1024, 2048];
const WIDTHS: [f64; 11] = [0.3, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0];
/// Time against error is charted for these widths, on this size.
const SWEPT: ([f64; 2], usize) = ([1.0, 16.0], 256);
/// Times that each is run, below and above this size.
const REPEATS: (usize, usize, usize) = (3, 512, 1);

fn main() -> Result<()> {
    let mut arguments = Arguments::parse();
    if !arguments.bench {
        println!("nothing timed: run by cargo bench");
        return Ok(());
    }
    if arguments.quick {
        (arguments.sizes, arguments.widths) = (vec![128], vec![1.0, 8.0, 64.0]);
    }
    let gpu = Gpu::open()?;
    println!("adapter: {}", gpu.adapter());
    let mut rows = Vec::new();
    for scene in scenes(&arguments) {
        let timed = arguments.sizes.contains(&scene.n) && arguments.widths.contains(&scene.width_px);
        let reference = if timed { Some(scene.reference()?) } else { None };
        for method in settings(&scene) {
            let row = run(&gpu, &scene, method, reference.as_deref(), arguments.most_gflop)?;
            if reference.is_some() {
                println!("{}", row.line());
            }
            rows.push(row);
        }
        // A run that is broken off leaves what it has.
        if let Some(out) = &arguments.out {
            std::fs::write(out.join("contenders.csv"), row::csv(&rows))?;
        }
    }
    against_f64()?;
    if let Some(out) = &arguments.out {
        chart::write(&rows, &out.join("contenders.png"))?;
    }
    Ok(())
}

/// Slopes of all sizes and widths, and planes of one size.
fn scenes(arguments: &Arguments) -> impl Iterator<Item = Scene> {
    let mut sizes = [&SIZES[..], &arguments.sizes].concat();
    let mut widths = [&WIDTHS[..], &arguments.widths].concat();
    sizes.sort_unstable();
    sizes.dedup();
    widths.sort_by(f64::total_cmp);
    widths.dedup();
    let planes = widths.clone();
    let slopes = sizes.into_iter().flat_map(move |n| widths.clone().into_iter().map(move |w| (n, w, true)));
    let planes = planes.into_iter().map(|w| (SWEPT.1, w, false));
    slopes.chain(planes).map(|(n, width_px, slope)| Scene::new(n, width_px, slope))
}

/// The grid's settings, and more where time is charted against error.
fn settings(scene: &Scene) -> Vec<Method> {
    let mut all = Method::GRID.to_vec();
    if scene.slope && scene.n == SWEPT.1 && SWEPT.0.contains(&scene.width_px) {
        all.extend([3, 4, 5].map(|slices| Method::Fft(Some(slices))));
        all.extend([1e-1, 1e-2, 1e-4].map(Method::Gather));
        for ratio in [3.0, 2.0, std::f64::consts::SQRT_2] {
            all.extend([Method::Gaussians(ratio), Method::Pyramid(ratio)]);
        }
    }
    all
}

/// Counts `method` and, with a `reference`, times it, if it takes less than `most_gflop`.
fn run(gpu: &Gpu, scene: &Scene, method: Method, reference: Option<&[f32]>, most_gflop: f64) -> Result<Row> {
    let work = method.work(scene);
    let Work { flops, .. } = work[0] + work[1];
    let (most, size, least) = REPEATS;
    let repeats = if scene.n <= size { most } else { least };
    let timing = match reference {
        Some(reference) if flops <= 1e9 * most_gflop || method == Method::Cpu => {
            let measured = method.measure(gpu, scene, &scene.optics(), repeats)?;
            let [l2, energy] = errors(&measured.image, reference);
            Some(Timing { prepare: measured.prepare, render: measured.render, l2, energy, repeats })
        }
        _ => None,
    };
    Ok(Row { method, n: scene.n, width_px: scene.width_px, slope: scene.slope, timing, work })
}

/// The reference is itself an approximation: its distance from the f64 implementation where that is quick.
fn against_f64() -> Result<()> {
    for width_px in [0.3, 1.0, 4.0] {
        let scene = Scene::new(128, width_px, true);
        let [l2, energy] = errors(&scene.reference()?, &scene.f64_image()?);
        println!(
            "reference at 128 px, width {width_px} px: {l2:.1e} from the f64 implementation, energy {energy:.1e}"
        );
    }
    Ok(())
}
