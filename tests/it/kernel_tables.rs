//! The reference tables of the spread kernels against the tracer: second moments, and the worst error of the encircled
//! energy. The reference numbers were measured with another photon tracer, written apart from this one, in a medium of
//! albedo .95 and sigma_t = 1.
//!
//! A reference number is known to half a unit of its last digit, and to the Monte-Carlo noise of its photons; ours to
//! the noise of ours. Nothing else is granted.

use narrowbeam::lab::compare::worst_encircled_error;
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, b_of_spread_angle};
use narrowbeam::spread::{Model, SecondMoments, second_moments};
use narrowbeam::trace::{RadialConfig, RadialProfile, log_spaced, trace_radial};
use std::sync::LazyLock;

const SIGMA_S: f64 = 0.95;
const SIGMA_A: f64 = 0.05;

/// Our paths for each spread angle.
const PATHS: u64 = 4_000_000;

/// Standard errors of a normal number beyond which one of 22 falls with a chance of 1 %: 22 erfc(3.5/√2) = .01.
const NORMAL: f64 = 3.5;

/// Kolmogorov's statistic sup|F_n - F| √n, exceeded with a chance of .001; among 30 numbers, of 3 %.
const KOLMOGOROV: f64 = 1.95;

fn medium(degrees: f64) -> Medium {
    Medium::new(SIGMA_S, SIGMA_A, phase(degrees).into()).unwrap()
}

fn phase(degrees: f64) -> Gaussian {
    Gaussian::new(b_of_spread_angle(degrees.to_radians())).unwrap()
}

/// Spread angles in degrees, and the depths of either table.
const PLANES: [(f64, &[f64]); 4] =
    [(5.0, &[1.0, 3.0, 10.0]), (10.0, &[1.0, 2.0, 3.0, 10.0]), (20.0, &[1.0, 2.0, 3.0]), (30.0, &[1.0, 3.0])];

/// Profiles of the [`PLANES`], those of an angle from one set of paths. Edges are 1 % apart, from a thousandth of the
/// kernel's width at the nearest plane to where hardly any light falls.
static TRACED: LazyLock<Vec<Vec<RadialProfile>>> = LazyLock::new(|| {
    let of_angle = |(degrees, depths): (f64, &[f64])| {
        let width = phase(degrees).b().sqrt();
        let edges = log_spaced(1e-3 * width * depths[0], 1e2 * depths[depths.len() - 1], 900);
        let config =
            RadialConfig { medium: medium(degrees), depths: depths.to_vec(), edges, paths: PATHS, seed: 20 };
        trace_radial(&config, &|_| ()).unwrap()
    };
    PLANES.map(of_angle).to_vec()
});

fn traced(degrees: f64, depth: f64) -> &'static RadialProfile {
    let angle = PLANES.iter().position(|p| p.0 == degrees).unwrap();
    let plane = PLANES[angle].1.iter().position(|z| *z == depth).unwrap();
    &TRACED[angle][plane]
}

/// A number of a reference table and half a unit of its last digit.
fn printed(text: &str) -> (f64, f64) {
    let decimals = text.split_once('.').map_or(0, |(_, digits)| digits.len());
    (text.parse().unwrap(), 0.5 * 0.1_f64.powi(decimals as i32))
}

/// Compares one number and returns it as a cell of the table.
fn compare(ours: f64, reference: &str, noise: f64, failures: &mut Vec<String>, place: &str) -> String {
    let (theirs, rounding) = printed(reference);
    if (ours - theirs).abs() > rounding + noise {
        failures.push(format!("{place}: {ours:.4}, reference {reference} ± {rounding} ± {noise:.4}"));
    }
    format!("{ours:.4} ({reference})")
}

#[test]
fn traced_second_moments_are_those_of_the_reference_table() {
    /// Photons of the reference table.
    const REFERENCE_PATHS: f64 = 4e5;
    // Spread angle in degrees; depth, traced moment by the printed one, traced moment by the exact one.
    type Row = (f64, &'static str, &'static str);
    let table: [(f64, &[Row]); 4] = [
        (5.0, &[(1.0, ".55", "1.02"), (3.0, ".40", "1.03"), (10.0, ".36", "1.06")]),
        (10.0, &[(1.0, ".58", "1.07"), (3.0, ".45", "1.14"), (10.0, ".45", "1.33")]),
        (20.0, &[(1.0, ".88", "1.64"), (3.0, ".79", "2.02")]),
        (30.0, &[(1.0, "1.42", "2.65"), (3.0, ".76", "1.94")]),
    ];
    println!("second moment of the traced light by that of the models; in brackets the reference");
    println!("angle  depth  printed R       exact R         standard error");
    let mut failures = Vec::new();
    for (degrees, rows) in table {
        for &(z, by_printed, by_exact) in rows {
            let moment = traced(degrees, z).second_moment();
            let SecondMoments { exact, printed: as_printed } = second_moments(&medium(degrees), z).unwrap();
            // One path's contribution scatters alike in both tracers, so the reference's noise is ours for the number
            // of its paths; the two are independent.
            let paths = PATHS as f64 / REFERENCE_PATHS;
            let noise = NORMAL * moment.std_error * (1.0 + paths).sqrt();
            let mut cell = |by: f64, reference| {
                let place = format!("{degrees}°, depth {z}");
                compare(moment.value / by, reference, noise / by, &mut failures, &place)
            };
            let (first, second) = (cell(as_printed, by_printed), cell(exact, by_exact));
            println!("{degrees:5}  {z:5}  {first:14}  {second:14}  {:.4}", moment.std_error / exact);
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn worst_errors_of_the_encircled_energy_are_those_of_the_reference_table() {
    /// Photons of the reference table.
    const REFERENCE_PATHS: f64 = 5e5;
    const MODELS: [Model; 5] = [
        Model::SingleScatter,
        Model::Gaussian,
        Model::NarrowBeamPrinted,
        Model::NarrowBeam,
        Model::SmallAngle,
    ];
    // Spread angle in degrees; depth and the errors of the models.
    type Row = (f64, [&'static str; 5]);
    let table: [(f64, &[Row]); 4] = [
        (5.0, &[(1.0, [".40", ".18", ".13", ".03", ".004"]), (10.0, ["1.0", ".04", ".22", ".18", ".02"])]),
        (10.0, &[(2.0, [".66", ".15", ".17", ".06", ".013"])]),
        (20.0, &[(2.0, [".65", ".15", ".14", ".07", ".05"])]),
        (30.0, &[(1.0, [".36", ".17", ".08", ".07", ".08"]), (3.0, [".78", ".23", ".15", ".19", ".20"])]),
    ];
    println!("worst error of the encircled energy; in brackets the reference");
    println!("angle  depth  {}  standard error", MODELS.map(|m| format!("{:20}", m.name())).join(""));
    let mut failures = Vec::new();
    for (degrees, rows) in table {
        for (z, references) in rows {
            let (profile, medium) = (traced(degrees, *z), medium(degrees));
            let (mut cells, mut std_error) = (String::new(), 0.0_f64);
            for (model, reference) in MODELS.into_iter().zip(references) {
                let kernel = model.kernel(&medium, *z).unwrap();
                let worst = worst_encircled_error(profile, &*kernel).unwrap();
                // A largest value moves by no more than the largest change anywhere. E_traced/S is an empirical
                // distribution of the paths that arrive scattered, off by Kolmogorov's statistic; E_model/S is off by
                // the relative error of S, a binomial share of all paths.
                let arrive = profile.scattered_paths() as f64 / PATHS as f64;
                let model_share = kernel.scattered() / profile.scattered().value;
                let noise = |paths: f64| {
                    let total = NORMAL * ((1.0 - arrive) / arrive / paths).sqrt();
                    KOLMOGOROV / (arrive * paths).sqrt() + model_share * total
                };
                let both = noise(REFERENCE_PATHS) + noise(PATHS as f64);
                let place = format!("{degrees}°, depth {z}, {model}");
                cells +=
                    &format!("{:20}", compare(worst.share.value, reference, both, &mut failures, &place));
                std_error = std_error.max(worst.share.std_error);
            }
            println!("{degrees:5}  {z:5}  {cells}  {std_error:.4}");
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}
