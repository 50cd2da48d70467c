//! What one image costs: the fast path on planes of three sizes and on a slope, with and without derivatives.
//!
//! The floor is the time of its FFTs alone. Preparing a target (its own transforms, once a fit) is measured apart.
//!
//! The composite filter is measured against eq29 at the same number of slices, in turns: on a slope, and on two half
//! planes of which one covers the other. Promised for a render: less than twice the time without edges, less than three
//! times with one covering. Derivatives are stated only.

mod common;
#[path = "../tests/it/common/mod.rs"]
mod scenes;

use common::{best_of, fft_seconds};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Filter, Optics, Target};
use narrowbeam::geometry::{Field, Geometry};
use narrowbeam::image::{Border, Image, Sampling, View};
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

/// Far half plane's distance over the near one's, and the ripple of both, as a share of their distance.
const FARTHER: f32 = 2.0;
const RIPPLE: f32 = 0.05;

/// Slices of the comparison: over all depths by eq29; by composite, as many in all, shared out among the slabs.
const SLICES: usize = 8;

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

/// Two half planes with gentle ripples, the near one on the left.
fn half_planes(n: usize, pitch: f64) -> Geometry {
    let depth = Image::from_fn(n, n, |x, y| {
        let plane = DEPTH as f32 * if x < n / 2 { 1.0 } else { FARTHER };
        plane * (1.0 + RIPPLE * (0.05 * x as f32).sin() * (0.04 * y as f32).cos())
    });
    Geometry { depth: Field::Map(depth), ..Geometry::planar(n, n, pitch, DEPTH).unwrap() }
}

fn filter(c: &mut Criterion) {
    let phase = Gaussian::new(b_of_spread_angle(SPREAD_ANGLE_DEG.to_radians())).unwrap();
    let medium = Medium::new(SIGMA_S, SIGMA_A, phase.into()).unwrap();
    let optics = Optics { model: Model::SmallAngle, medium };
    let mut floors = Vec::new();
    for scene in scenes(&phase) {
        let (width, height) = (scene.radiance.width, scene.radiance.height);
        let target = Target {
            radiance: &scene.radiance,
            behind: &[],
            geometry: &scene.geometry,
            border: Border::Zero,
            sampling: Sampling::Pixel,
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
    let pitch = DEPTH * phase.b().sqrt() / WIDTH_PX;
    let slope = scenes::sloping(256, 256, pitch, DEPTH, SLOPE);
    println!("{}", against_eq29("slope 256, no edges (promise: render < 2 x)", &slope, &optics));
    println!(
        "{}",
        against_eq29(
            "half planes 256, one covering (promise: render < 3 x)",
            &half_planes(256, pitch),
            &optics
        )
    );
}

/// The time of composite over that of eq29, with and without derivatives.
fn against_eq29(name: &str, geometry: &Geometry, optics: &Optics) -> String {
    let radiance = scenes::texture(geometry.width, geometry.height);
    let relief = Filter::Composite.relief(geometry).expect("composite sees a relief");
    let eq29 = Target {
        radiance: &radiance,
        behind: &[],
        geometry,
        border: Border::Zero,
        sampling: Sampling::Pixel,
        view: View::whole(geometry.width, geometry.height),
        relief: None,
    };
    let composite = Target { relief: Some(&relief), ..eq29 };
    let far = geometry.path_lengths().into_iter().fold(0.0, f64::max);
    let reach_px = optics.kernel(far).unwrap().support(1e-5) / geometry.pixel_pitch(far);
    let eq29 = CpuFilter::with_slices(eq29, SLICES, reach_px).unwrap();
    let composite =
        CpuFilter::with_slices(composite, SLICES / (relief.occluders.len() + 1), reach_px).unwrap();
    assert_eq!(eq29.slice_count(), composite.slice_count(), "{name}: {} occluders", relief.occluders.len());

    let render = in_turns([&eq29, &composite], |filter| {
        black_box(filter.render(optics).unwrap());
    });
    let gradient = in_turns([&eq29, &composite], |filter| {
        black_box(filter.render_with_gradient(optics).unwrap());
    });
    let ratio = |what: &str, [eq29, composite]: [f64; 2]| {
        let (ratio, eq29, composite) = (composite / eq29, 1e3 * eq29, 1e3 * composite);
        format!("{what} {composite:.2} ms / {eq29:.2} ms = {ratio:.2}")
    };
    format!(
        "{name}: {} slices, {} occluder(s), composite / eq29: {}, {}",
        eq29.slice_count(),
        relief.occluders.len(),
        ratio("render", render),
        ratio("with derivatives", gradient)
    )
}

/// Seconds that `f` takes with each filter, the best of many rounds, in turns so that a busy machine slows both.
fn in_turns(filters: [&CpuFilter; 2], f: impl Fn(&CpuFilter)) -> [f64; 2] {
    let round = |best: [f64; 2]| std::array::from_fn(|i| best[i].min(best_of(1, || f(filters[i]))));
    (0..30).fold([f64::INFINITY; 2], |best, _| round(best))
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
