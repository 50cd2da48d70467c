//! What the kernels cost: transfer functions with their derivatives, densities, and the aliases of a pixel grid.
//!
//! The floor of the exact small-angle transfer function is one error function, one exp and one exp_m1 a frequency;
//! the filter evaluates it at some hundreds of frequencies a depth slice and at their aliases.

mod common;

use common::nanoseconds;
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use narrowbeam::filter::footprint::aliases;
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, b_of_spread_angle};
use narrowbeam::spread::{Model, SpreadKernel};
use narrowbeam::trace::log_spaced;
use std::hint::black_box;
use std::time::Duration;

const TAU: f64 = 2.0;
const SIGMA_A: f64 = 0.05;
const SPREAD_ANGLE_DEG: f64 = 8.0;

/// Aliases summed one by one to each side, as many as the filter takes.
const REACH: i32 = 6;

/// Frequencies x = sqrt(B) k z from where the transfer function is flat to where only direct light is left.
const X: (f64, f64) = (1e-2, 2e1);

fn phase() -> Gaussian {
    Gaussian::new(b_of_spread_angle(SPREAD_ANGLE_DEG.to_radians())).unwrap()
}

fn kernel(model: Model, phase: &Gaussian) -> Box<dyn SpreadKernel> {
    model.kernel(&Medium::new(TAU, SIGMA_A, (*phase).into()).unwrap(), 1.0).unwrap()
}

fn transfer(c: &mut Criterion) {
    let phase = phase();
    let frequencies = log_spaced(X.0 / phase.b().sqrt(), X.1 / phase.b().sqrt(), 1000);
    let mut group = c.benchmark_group("transfer function with derivatives");
    group.sample_size(20).throughput(Throughput::Elements(frequencies.len() as u64));
    for model in Model::ALL {
        let kernel = kernel(model, &phase);
        group.bench_function(model.name(), |b| {
            b.iter(|| {
                frequencies.iter().map(|&k| kernel.scattered_transfer(black_box(k)).value).sum::<f64>()
            });
        });
    }
    group.finish();
}

/// The wide-angle kernel is interpolated for each medium and depth: what that costs, before any frequency is asked for.
fn interpolation(c: &mut Criterion) {
    let phase = Gaussian::new(b_of_spread_angle(35f64.to_radians())).unwrap();
    let medium = Medium::new(3.0, 0.4, phase.into()).unwrap();
    c.bench_function("a wide-angle kernel with derivatives", |b| {
        b.iter(|| {
            let kernel = Model::WideAngle.kernel(black_box(&medium), 1.0).unwrap();
            kernel.scattered_transfer(1.0).value
        });
    });
}

fn density(c: &mut Criterion) {
    let phase = phase();
    let width = phase.b().sqrt();
    let radii = log_spaced(1e-2 * width, 2e1 * width, 80);
    let mut group = c.benchmark_group("density at 80 radii");
    group.sample_size(20).throughput(Throughput::Elements(radii.len() as u64));
    for model in Model::ALL {
        let kernel = kernel(model, &phase);
        group.bench_function(model.name(), |b| {
            b.iter(|| radii.iter().map(|&r| kernel.psf(black_box(r))).sum::<f64>());
        });
    }
    group.finish();
    let kernel = kernel(Model::SmallAngle, &phase);
    c.bench_function("aliases of one frequency, small-angle, 3 px wide", |b| {
        b.iter(|| aliases(&*kernel, black_box(width / 3.0), 1.0, 1.0, REACH));
    });
}

fn floor(_: &mut Criterion) {
    let phase = phase();
    let x = log_spaced(X.0, X.1, 1000);
    let erf = nanoseconds(&x, |x| {
        black_box(libm::erf(black_box(x)));
    });
    let exp = nanoseconds(&x, |x| {
        black_box((-black_box(x) * x).exp());
    });
    let exp_m1 = nanoseconds(&x, |x| {
        black_box((black_box(x) / X.1).exp_m1());
    });
    let kernel = kernel(Model::SmallAngle, &phase);
    let scale = 1.0 / phase.b().sqrt();
    let whole = nanoseconds(&x, |x| {
        black_box(kernel.scattered_transfer(black_box(x * scale)));
    });
    let sum = erf + exp + exp_m1;
    println!(
        "floor of small-angle with derivatives, nanoseconds on one core: erf {erf:.1} + exp {exp:.1} + exp_m1 \
         {exp_m1:.1} = {sum:.1}\n  measured {whole:.1}; the gap of {:.1} is {:.0} % of it",
        whole - sum,
        100.0 * (whole - sum) / whole
    );
}

criterion_group! {
    name = benches;
    config = Criterion::default().warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    targets = transfer, interpolation, density, floor
}
criterion_main!(benches);
