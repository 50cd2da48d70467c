//! How many scattered paths a second: a radial tally at tau = 2, 8 degrees, on all cores; and where the time goes.
//!
//! The floor is what the events of a path cost by themselves on one core: the seeding of its stream, its free paths
//! (a random number, a logarithm, a division), its deflections (random numbers, a logarithm, a square root, sine and
//! cosine) and turns. The rest is the bookkeeping of planes and bins, and mispredicted branches.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use narrowbeam::geometry::{Camera, Field, Geometry};
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, HenyeyGreenstein, PhaseFunction};
use narrowbeam::trace::{
    ImageConfig, Path, RadialConfig, Stream, free_path, log_spaced, trace_image, trace_radial,
};
use std::hint::black_box;
use std::time::{Duration, Instant};

const TAU: f64 = 2.0;
const SPREAD_ANGLE_DEG: f64 = 8.0;
const SIGMA_A: f64 = 0.05;
const PATHS: u64 = 1 << 20;

fn gaussian() -> Gaussian {
    let spread = SPREAD_ANGLE_DEG.to_radians();
    Gaussian::new(0.25 * spread * spread).unwrap()
}

fn config<P>(depths: Vec<f64>, phase: P) -> RadialConfig<P> {
    let medium = Medium::new(TAU, SIGMA_A, phase).unwrap();
    RadialConfig { medium, depths, edges: log_spaced(1e-3, 3.0, 100), paths: PATHS, seed: 1 }
}

/// Paths that scatter before the last plane: what the rates below count.
fn scattered_paths() -> u64 {
    (PATHS as f64 * -(-TAU).exp_m1()) as u64
}

fn radial(c: &mut Criterion) {
    let mut group = c.benchmark_group("scattered paths, tau 2, 8 degrees");
    group.sample_size(10).throughput(Throughput::Elements(scattered_paths()));
    let phase = gaussian();
    let same_mean_cosine = HenyeyGreenstein::new(phase.mean_cosine()).unwrap();
    let eight: Vec<f64> = (1..=8).map(|i| f64::from(i) / 8.0).collect();
    group
        .bench_function("gaussian, 1 plane", |b| b.iter(|| trace_radial(&config(vec![1.0], phase), &|_| ())));
    group.bench_function("gaussian, 8 planes", |b| {
        b.iter(|| trace_radial(&config(eight.clone(), phase), &|_| ()));
    });
    group.bench_function("henyey-greenstein, 1 plane", |b| {
        b.iter(|| trace_radial(&config(vec![1.0], same_mean_cosine), &|_| ()));
    });
    group.finish();
}

fn image(c: &mut Criterion) {
    let mut group = c.benchmark_group("image paths, tau 2, 8 degrees, 64 x 64 px");
    let samples = 64;
    group.sample_size(10).throughput(Throughput::Elements(64 * 64 * u64::from(samples)));
    let radiance = Image::filled(64, 64, 1.0);
    let tilted = Image::from_fn(64, 64, |x, _| 0.8 + 0.4 * (x as f32 + 0.5) / 64.0);
    for (name, depth) in [("one plane", Field::Uniform(1.0)), ("depth map", Field::Map(tilted))] {
        let camera = Camera::orthographic(0.02).unwrap();
        let geometry = Geometry {
            width: 64,
            height: 64,
            camera,
            depth,
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        };
        let medium = Medium::new(TAU, SIGMA_A, gaussian()).unwrap();
        let view = View::whole(64, 64);
        let config = ImageConfig {
            geometry: &geometry,
            radiance: &radiance,
            behind: &[],
            border: Border::Clamp,
            view,
            medium,
            samples,
            seed: 1,
        };
        group.bench_function(name, |b| b.iter(|| trace_image(&config, &|_| ())));
    }
    group.finish();
}

/// Nanoseconds that one call of `f` takes on this core, the best of a few rounds.
fn nanoseconds(mut f: impl FnMut()) -> f64 {
    const CALLS: u32 = 1_000_000;
    let mut round = || {
        let start = Instant::now();
        (0..CALLS).for_each(|_| f());
        start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
    };
    (0..5).map(|_| round()).fold(f64::INFINITY, f64::min)
}

fn where_the_time_goes(_: &mut Criterion) {
    let phase = gaussian();
    let mut stream = Stream::new(Stream::key(1), 0);
    let mut path = Path::new(Vec3::ZERO, Vec3::Z);
    let mut index = 0;
    let seeding = nanoseconds(|| {
        index += 1;
        black_box(Stream::new(7, index));
    });
    let number = nanoseconds(|| {
        black_box(stream.uniform());
    });
    let flight = nanoseconds(|| {
        black_box(free_path(2.0, &mut stream));
    });
    let deflection = nanoseconds(|| {
        black_box(phase.sample(&mut || stream.uniform()));
    });
    let turn = nanoseconds(|| {
        path.scatter(&phase, &mut stream);
        black_box(&path);
    }) - deflection;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let whole = (0..3)
        .map(|_| {
            let start = Instant::now();
            let profiles = pool.install(|| trace_radial(&config(vec![1.0], phase), &|_| ())).unwrap();
            black_box(profiles);
            start.elapsed().as_secs_f64() * 1e9 / scattered_paths() as f64
        })
        .fold(f64::INFINITY, f64::min);
    // Of the launched paths exp(-tau) are not scattered but cost a seed and a flight; tau scatterings a path.
    let launched = PATHS as f64 / scattered_paths() as f64;
    let (flights, scatterings) = ((TAU + 1.0) * launched, TAU * launched);
    let floor = seeding * launched + flight * flights + (deflection + turn) * scatterings;
    println!(
        "where the time goes, nanoseconds on one core:\n  \
         random number {number:.1}, seeding {seeding:.1}, free path {flight:.1}, deflection {deflection:.1}, \
         turn {turn:.1}\n  \
         per scattered path: {launched:.2} seeds, {flights:.2} free paths, {scatterings:.2} deflections and turns \
         = floor {floor:.0}\n  \
         measured {whole:.0}: {:.2} million scattered paths a second and core; planes, bins and branches take {:.0}",
        1e3 / whole,
        whole - floor
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    targets = radial, image, where_the_time_goes
}
criterion_main!(benches);
