//! What a fit costs: one channel of a plane, start values and noise unknown, on an image made by the model with noise; by
//! the Gram matrix, as it is done, and by renders alone.
//!
//! The floor by renders is the time of the FFTs alone, those of the renders that choose the start and those of the
//! optimiser's evaluations. The floor by the Gram matrix is that of the FFTs that confirm the optimum, and of the products of all
//! images of the basis at the rate at which one product of two such blocks is summed. Reading files and writing results are not part of this.

mod common;
#[path = "../tests/it/common/mod.rs"]
mod scenes;

use common::{best_of, fft_seconds};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use narrowbeam::filter::basis::Basis;
use narrowbeam::filter::blur::dot;
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Optics, Target};
use narrowbeam::fit::{ChannelFit, HEADROOM, Observation, Parameters, Settings, fit_channel};
use narrowbeam::forward::Quantity;
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::b_of_spread_angle;
use narrowbeam::scene::{FitOptions, ParameterOptions};
use narrowbeam::spread::Model;
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Duration;

const SIGMA_S: f64 = 0.95;
const SIGMA_A: f64 = 0.05;
const SPREAD_ANGLE_DEG: f64 = 8.0;
const DEPTH: f64 = 2.0;
const PIXEL_PITCH: f64 = 0.02;
const NOISE: f64 = 0.01;

/// Padding of the filters that choose the start, in image sides, and their slices (there is one depth).
const START_PADDING: f64 = 0.5;

fn observed(target: Target) -> Image {
    let b = b_of_spread_angle(SPREAD_ANGLE_DEG.to_radians());
    let medium = Medium::gaussian(SIGMA_S, SIGMA_A, b).unwrap();
    let optics = Optics { model: Model::SmallAngle, medium };
    let clean = CpuFilter::new(target, &optics, 1.0).unwrap().render(&optics).unwrap();
    scenes::with_noise(&clean, NOISE, 1)
}

fn fit(c: &mut Criterion) {
    let mut floors = Vec::new();
    for n in [256, 512, 1024] {
        let radiance = scenes::texture(n, n);
        let geometry = Geometry::planar(n, n, PIXEL_PITCH, DEPTH).unwrap();
        let view = View::whole(n, n);
        let target = Target {
            radiance: &radiance,
            behind: &[],
            geometry: &geometry,
            border: Border::Zero,
            sampling: Sampling::Pixel,
            view,
            relief: None,
        };
        let observed = observed(target);
        let observation = Observation::plain(target, &observed);
        let by = |gram: bool| {
            let settings = Settings { gram, ..Settings::default() };
            move |options: &FitOptions| fit_channel(&[observation], options, &settings, &|| ()).unwrap()
        };
        let mut group = c.benchmark_group("fit of a plane");
        group.sample_size(10).throughput(Throughput::Elements((n * n) as u64));
        let automatic = FitOptions::default();
        group.bench_function(format!("{n} x {n} by the Gram matrix"), |b| b.iter(|| by(true)(&automatic)));
        group.bench_function(format!("{n} x {n} by renders"), |b| b.iter(|| by(false)(&automatic)));
        group.finish();
        floors.push(gram_floor(target, by(true)));
        floors.push(floor(target, by(false)));
    }
    floors.iter().for_each(|text| println!("{text}"));
}

/// Pixels whose products are summed together.
const BLOCK: usize = 256;

/// What a fit by the Gram matrix must do at least, its parts, and the gap to the whole.
fn gram_floor(target: Target, fit: impl Fn(&FitOptions) -> ChannelFit) -> String {
    let found = fit(&FitOptions::default());
    let optics = Optics { model: Model::SmallAngle, medium: found.parameters.medium().unwrap() };
    let basis = Basis::new(target).unwrap().unwrap();
    let weights =
        best_of(5, || (0..100).for_each(|_| drop(black_box(basis.weights(&optics).unwrap())))) / 100.0;
    let images = best_of(5, || {
        let images = basis.images();
        images.strips().par_iter().for_each(|strip| {
            images.blocks(strip, 16, |_, block| {
                black_box(block.len());
            })
        });
    });
    let (a, c) = (vec![0.5_f32; BLOCK], vec![0.25_f32; BLOCK]);
    const REPEATS: usize = 10_000;
    let block = best_of(5, || {
        (0..REPEATS).for_each(|_| {
            black_box(dot(black_box(&a), black_box(&c)));
        })
    });
    let number = basis.count() + 2;
    let blocks = target.view.pixels().div_ceil(BLOCK) * number * (number + 1) / 2;
    let products = block / REPEATS as f64 * blocks as f64 / rayon::current_num_threads() as f64;
    let filter = CpuFilter::new(target, &optics, HEADROOM).unwrap();
    let (_, per_render, size) = filter.transforms();
    let ffts = (found.evaluations as usize * per_render + 1) as f64 * fft_seconds(size);
    let whole = best_of(5, || {
        black_box(fit(&FitOptions::default()));
    });
    let floor = products + ffts;
    format!(
        "{side} x {side} by the Gram matrix: {} images, {} evaluations by it with weights in {:.3} ms each, {} renders\n  \
         floor: products {:.1} ms, FFTs {:.1} ms, together {:.1} ms; the images themselves take {:.1} ms\n  \
         measured {:.1} ms, {:.1} x",
        basis.count(),
        found.gram_evaluations,
        1e3 * weights,
        found.evaluations,
        1e3 * products,
        1e3 * ffts,
        1e3 * floor,
        1e3 * images,
        1e3 * whole,
        whole / floor,
        side = target.radiance.width,
    )
}

/// Options of a fit that starts at these values.
fn started_at(parameters: &Parameters) -> FitOptions {
    let start = |quantity| ParameterOptions {
        start: Some(parameters.value(quantity)),
        ..ParameterOptions::default()
    };
    FitOptions {
        sigma_s: start(Quantity::SigmaS),
        sigma_a: start(Quantity::SigmaA),
        phase: start(Quantity::Phase),
        ..FitOptions::default()
    }
}

/// The FFTs of a fit by renders, their time alone, and the gap to the whole.
fn floor(target: Target, fit: impl Fn(&FitOptions) -> ChannelFit) -> String {
    let found = fit(&FitOptions::default());
    // From the same start the optimiser takes the same path, without the renders that choose it.
    let started = fit(&started_at(&found.start));
    let starts = found.evaluations - started.evaluations;

    let side = target.radiance.width;
    let start_filter = CpuFilter::with_slices(target, 1, START_PADDING * side as f64).unwrap();
    let optics = Optics { model: Model::SmallAngle, medium: found.start.medium().unwrap() };
    let filter = CpuFilter::new(target, &optics, HEADROOM).unwrap();
    let (per_start, _, start_size) = start_filter.transforms();
    let (_, _, size) = filter.transforms();

    // Each filter also transforms the object once.
    let start_ffts = starts as usize * per_start + 1;
    let ffts = started.evaluations as usize * started.transforms + 1;
    let start_seconds = start_ffts as f64 * fft_seconds(start_size);
    let seconds = ffts as f64 * fft_seconds(size);
    let whole = best_of(5, || {
        black_box(fit(&FitOptions::default()));
    });
    let floor = start_seconds + seconds;
    format!(
        "{side} x {side} by renders: {starts} renders for the start, {} evaluations with {} FFTs each\n  \
         floor: {start_ffts} FFTs of {}x{} = {:.1} ms, {ffts} FFTs of {}x{} = {:.1} ms, together {:.1} ms\n  \
         measured {:.1} ms, {:.1} x; the gap of {:.1} ms is transfer functions, normal equations, and memory",
        started.evaluations,
        started.transforms,
        start_size[0],
        start_size[1],
        1e3 * start_seconds,
        size[0],
        size[1],
        1e3 * seconds,
        1e3 * floor,
        1e3 * whole,
        whole / floor,
        1e3 * (whole - floor)
    )
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    targets = fit
}
criterion_main!(benches);
