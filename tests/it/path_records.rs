//! Path records against the radial tally, and replayed paths against those of the other medium.

use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, HenyeyGreenstein, b_of_spread_angle};
use narrowbeam::trace::{
    Likelihood, PathRecord, PathRecords, RadialConfig, ReplayedSum, Scattered, trace_paths, trace_radial,
};

const PATHS: u64 = 200_000;

/// In units of the plane's depth.
type Scaled = Medium<Gaussian>;

fn scaled(sigma_s: f64, sigma_a: f64, degrees: f64) -> Scaled {
    Medium::new(sigma_s, sigma_a, Gaussian::new(b_of_spread_angle(degrees.to_radians())).unwrap()).unwrap()
}

/// Light within `radius`.
fn within<P: Likelihood>(records: &PathRecords<P>, radius: f64) -> f64 {
    records.weight * records.paths.iter().filter(|h| f64::from(h.radius) < radius).count() as f64
}

/// Mean over independent runs of the light within `radius`, and its standard error: copies of a path are not independent.
fn light<P: Likelihood>(medium: Medium<P>, radius: f64) -> (f64, f64) {
    over_runs(|paths, seed| within(&trace_paths(medium, Scattered::Once, paths, seed).unwrap(), radius))
}

/// Mean and its standard error of `one` of so many paths and a seed.
fn over_runs(one: impl Fn(u64, u64) -> f64) -> (f64, f64) {
    let runs = 16;
    let values: Vec<f64> = (100..100 + runs).map(|seed| one(PATHS / runs, seed)).collect();
    let mean = values.iter().sum::<f64>() / runs as f64;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (squares / (runs * (runs - 1)) as f64).sqrt())
}

fn agrees_with_the_radial_tally<P: Likelihood>(medium: Medium<P>) {
    let radii = vec![0.3, 1.0];
    let config = RadialConfig { medium, depths: vec![1.0], edges: radii.clone(), paths: 1_000_000, seed: 12 };
    let profile = trace_radial(&config, &|_| ()).unwrap().remove(0);
    for (i, radius) in radii.into_iter().enumerate() {
        let (found, error) = light(medium, radius);
        let want = profile.encircled_energy(i);
        // Of a standard error from 16 runs, five are exceeded in one of 5000 cases.
        let noise = 5.0 * error.hypot(want.std_error);
        assert!((found - want.value).abs() < noise, "{medium:?} {radius}: {found} ± {error}, {want:?}");
        // A tenth less light would be seen.
        assert!(0.1 * found > noise, "{medium:?} {radius}: {noise}");
    }
}

#[test]
fn light_within_a_radius_is_that_of_the_radial_tally() {
    for medium in [scaled(0.1, 0.0, 10.0), scaled(2.0, 1.0, 30.0), scaled(4.0, 4.0, 40.0)] {
        agrees_with_the_radial_tally(medium);
    }
    let phase = HenyeyGreenstein::new(0.85).unwrap();
    agrees_with_the_radial_tally(Medium::new(2.0, 1.0, phase).unwrap());
}

/// Light within `radius` that is scattered more than once, by two ways to trace it.
fn more_than_once(medium: Scaled, radius: f64) -> [(f64, f64); 2] {
    [Scattered::Once, Scattered::Twice].map(|scattered| {
        over_runs(|paths, seed| {
            let mut records = trace_paths(medium, scattered, paths, seed).unwrap();
            records.paths.retain(|h| h.scatterings > 1);
            within(&records, radius)
        })
    })
}

#[test]
fn light_scattered_twice_is_that_of_the_paths_scattered_more_than_once() {
    for medium in
        [scaled(0.1, 0.0, 10.0), scaled(2.0, 1.0, 30.0), scaled(4.0, 4.0, 40.0), scaled(0.5, 0.3, 70.0)]
    {
        for radius in [0.3, 1.0, f64::INFINITY] {
            let [(once, once_error), (twice, error)] = more_than_once(medium, radius);
            let noise = 5.0 * error.hypot(once_error);
            assert!(
                (twice - once).abs() < noise,
                "{medium:?} {radius}: {twice} ± {error}, {once} ± {once_error}"
            );
            assert!(0.1 * once > noise, "{medium:?} {radius}: a tenth more would not be seen");
        }
    }
}

#[test]
fn where_no_path_is_lost_light_scattered_twice_is_without_noise() {
    let tau = 0.5_f64;
    let [(_, once_error), (twice, error)] = more_than_once(scaled(tau, 0.0, 3.0), f64::INFINITY);
    let exact = 1.0 - (1.0 + tau) * (-tau).exp();
    // Paths turned by 3 degrees are longer by some permille: so much more light scatters again.
    assert!((twice / exact - 1.0).abs() < 2e-3, "{twice} {exact}");
    assert!(error < 0.01 * once_error, "{error} {once_error}");
}

#[test]
fn path_records_do_not_depend_on_the_number_of_threads() {
    let medium = scaled(3.0, 1.0, 25.0);
    let trace = || trace_paths(medium, Scattered::Twice, 5_000, 3).unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(trace);
    assert_eq!(one, trace());
}

fn medium([sigma_s, sigma_a, b]: [f64; 3]) -> Scaled {
    Medium::new(sigma_s, sigma_a, Gaussian::new(b).unwrap()).unwrap()
}

/// Light near the axis.
fn near(path: &PathRecord<[f32; 1]>) -> f64 {
    f64::from(u8::from(path.radius < 0.25))
}

#[test]
fn replayed_paths_are_those_of_the_other_medium() {
    let from = trace_paths(scaled(1.0, 0.3, 20.0), Scattered::Once, PATHS, 21).unwrap();
    let to = scaled(1.15, 0.5, 21.5);
    let reweighted = from.replay(&to, near);
    let fresh = within(&trace_paths(to, Scattered::Once, PATHS, 22).unwrap(), 0.25);
    assert!(reweighted.effective_paths > 0.5 * PATHS as f64);
    let noise = fresh * 4.0 * (1.0 / reweighted.effective_paths + 1.0 / PATHS as f64).sqrt();
    assert!((reweighted.value - fresh).abs() < noise, "{reweighted:?} {fresh}");
    // The medium itself is farther off than that.
    assert!((within(&from, 0.25) - fresh).abs() > 2.0 * noise);
}

#[test]
fn derivatives_of_reweighted_light_are_those_of_its_differences() {
    let from = trace_paths(scaled(1.0, 0.3, 20.0), Scattered::Once, PATHS, 23).unwrap();
    let at = |p: [f64; 3]| -> ReplayedSum { from.replay(&medium(p), near) };
    let p = [1.1, 0.35, 0.031];
    for i in 0..3 {
        let step = 1e-4 * p[i];
        let (mut up, mut down) = (p, p);
        up[i] += step;
        down[i] -= step;
        let difference = (at(up).value - at(down).value) / (2.0 * step);
        // The same paths on both sides: only the step's square is left.
        let off = (at(p).gradient[i] - difference).abs() * p[i];
        assert!(off < 1e-6 * at(p).value, "{i}: {} {difference}", at(p).gradient[i]);
    }
}

#[test]
fn derivatives_are_those_of_fresh_tracing() {
    let p = [1.0, 0.3, b_of_spread_angle(20.0_f64.to_radians())];
    let paths = 4 * PATHS;
    let gradient =
        trace_paths(medium(p), Scattered::Once, paths, 31).unwrap().replay(&medium(p), near).gradient;
    for i in 0..3 {
        let step = 0.2 * p[i];
        let (mut up, mut down) = (p, p);
        up[i] += step;
        down[i] -= step;
        let light = |p: [f64; 3], seed: u64| {
            within(&trace_paths(medium(p), Scattered::Once, paths, seed).unwrap(), 0.25)
        };
        let (more, less) = (light(up, 32), light(down, 33));
        let difference = (more - less) / (2.0 * step);
        // Five standard errors of the difference, and the next order of a step of a fifth.
        let noise = 5.0 * (2.0 * more * (1.0 - more) / paths as f64).sqrt() / (2.0 * step);
        let bound = noise + 0.06 * difference.abs();
        assert!((gradient[i] - difference).abs() < bound, "{i}: {} {difference} {noise}", gradient[i]);
    }
}

#[test]
fn effective_paths_fall_with_the_distance_of_the_medium() {
    let from = trace_paths(scaled(1.0, 0.0, 20.0), Scattered::Once, PATHS, 41).unwrap();
    let effective = |to| from.replay(&to, |_| 1.0).effective_paths;
    let here = effective(scaled(1.0, 0.0, 20.0));
    assert!((here - from.paths.len() as f64).abs() < 1e-6 * here);
    let (near, far) = (effective(scaled(1.1, 0.1, 21.0)), effective(scaled(3.0, 0.1, 30.0)));
    assert!(near > 0.9 * here && far < 0.3 * here, "{here} {near} {far}");
}
