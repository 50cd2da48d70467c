//! What one image costs: the fast path on planes of three sizes and on a slope, with and without derivatives.
//!
//! The floor is the time of its FFTs alone. Preparing a target (its own transforms, once a fit) is measured apart.

mod common;
#[path = "../tests/common/mod.rs"]
mod scenes;

use common::{best_of, fft_seconds};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Optics, Target};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, b_of_spread_angle};
use narrowbeam::spread::Model;
use std::hint::black_box;
use std::time::Duration;

const SIGMA_S: f64 = 0.95;
const SIGMA_A: f64 = 0.05;
const SPREAD_ANGLE_DEG: f64 = 8.0;
const DEPTH: f64 = 2.0;

/// Kernel width z sqrt(B) in pixels, whatever the image size.
const WIDTH_PX: f64 = 5.0;

/// A slope of 15 degrees is tan 15° = .27; its depth varies by that times the image's width.
const SLOPE: f64 = 0.27;

struct Scene {
    name: &'static str,
    radiance: Image,
    geometry: Geometry,
}

fn scenes(phase: &Gaussian) -> Vec<Scene> {
    let pitch = DEPTH * phase.b().sqrt() / WIDTH_PX;
    let plane = |name, n| Scene {
        name,
        radiance: scenes::texture(n, n),
        geometry: Geometry::planar(n, n, pitch, DEPTH).unwrap(),
    };
    let slope = Scene {
        name: "slope 256",
        radiance: scenes::texture(256, 256),
        geometry: scenes::sloping(256, 256, pitch, DEPTH, SLOPE),
    };
    vec![plane("plane 256", 256), plane("plane 512", 512), plane("plane 1024", 1024), slope]
}

fn filter(c: &mut Criterion) {
    let phase = Gaussian::new(b_of_spread_angle(SPREAD_ANGLE_DEG.to_radians())).unwrap();
    let medium = Medium::new(SIGMA_S, SIGMA_A).unwrap();
    let optics = Optics { model: Model::SmallAngle, medium, phase: &phase };
    let mut floors = Vec::new();
    for scene in scenes(&phase) {
        let (width, height) = (scene.radiance.width, scene.radiance.height);
        let target = Target {
            radiance: &scene.radiance,
            behind: &[],
            geometry: &scene.geometry,
            border: Border::Zero,
            view: View::whole(width, height),
            relief: None,
        };
        let filter = CpuFilter::new(target, &optics, 1.0).unwrap();
        let mut group = c.benchmark_group(scene.name);
        group.sample_size(10).throughput(Throughput::Elements((width * height) as u64));
        group.bench_function("prepare", |b| b.iter(|| CpuFilter::new(target, &optics, 1.0).unwrap()));
        group.bench_function("render", |b| b.iter(|| filter.render(&optics).unwrap()));
        group.bench_function("render with derivatives", |b| {
            b.iter(|| filter.render_with_gradient(&optics).unwrap());
        });
        group.finish();
        floors.push(floor(scene.name, &filter, &optics));
    }
    floors.iter().for_each(|line| println!("{line}"));
}

/// The time of a scene's FFTs beside that of its renders.
fn floor(name: &str, filter: &CpuFilter, optics: &Optics) -> String {
    let (plain, derived, size) = filter.transforms();
    let fft = fft_seconds(size);
    let render = best_of(10, || {
        black_box(filter.render(optics).unwrap());
    });
    let gradient = best_of(10, || {
        black_box(filter.render_with_gradient(optics).unwrap());
    });
    let line = |what: &str, count: usize, seconds: f64| {
        let floor = 1e3 * fft * count as f64;
        format!(
            "{what} {:.2} ms, floor {count} FFTs = {floor:.2} ms, {:.1} x",
            1e3 * seconds,
            1e3 * seconds / floor
        )
    };
    format!(
        "{name}: {} slice(s), FFTs of {}x{}; {}; {}",
        filter.slice_count(),
        size[0],
        size[1],
        line("render", plain, render),
        line("with derivatives", derived, gradient)
    )
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    targets = filter
}
criterion_main!(benches);
