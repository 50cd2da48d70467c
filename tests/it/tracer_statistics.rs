//! The tracer's samplers and radial tallies against what is known exactly, by hypothesis tests with fixed seeds.

use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, HenyeyGreenstein, PhaseFunction};
use narrowbeam::trace::{RadialConfig, RadialProfile, Stream, free_path, log_spaced, trace_radial};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::PI;

/// Samples below this probability are called wrong. With fixed seeds a right sampler passes once and for all.
const LEVEL: f64 = 1e-3;

/// Probability of a chi-square as large as that of these counts if `shares` (of all samples) are true. Bins that
/// expect fewer than ten samples are pooled.
fn p_value(counts: &[u64], shares: &[f64]) -> f64 {
    assert_eq!(counts.len(), shares.len());
    let n = counts.iter().sum::<u64>() as f64;
    let (mut chi2, mut bins) = (0.0, 0);
    let mut pool = (0.0, 0.0);
    let mut add = |count: f64, expected: f64| {
        chi2 += (count - expected) * (count - expected) / expected;
        bins += 1;
    };
    for (&count, &share) in counts.iter().zip(shares) {
        if n * share < 10.0 {
            pool = (pool.0 + count as f64, pool.1 + n * share);
        } else {
            add(count as f64, n * share);
        }
    }
    if pool.1 >= 10.0 {
        add(pool.0, pool.1);
    } else {
        assert!(pool.0 < 40.0, "{} samples where {} are expected", pool.0, pool.1);
    }
    ChiSquared::new(f64::from(bins - 1)).unwrap().sf(chi2)
}

/// Counts of `samples` values of `draw` in `bins` equal bins of [0, end).
fn histogram(bins: usize, end: f64, samples: usize, mut draw: impl FnMut() -> f64) -> Vec<u64> {
    let mut counts = vec![0; bins];
    for _ in 0..samples {
        let bin = (draw() / end * bins as f64) as usize;
        counts[bin.min(bins - 1)] += 1;
    }
    counts
}

fn stream(seed: u64) -> Stream {
    Stream::new(Stream::key(seed), 0)
}

/// Shares of free paths in 80 bins of a tenth of a mean free path; the last holds the rest.
fn free_path_shares() -> Vec<f64> {
    (0..80)
        .map(|i| {
            let beyond = |i: i32| (-0.1 * f64::from(i)).exp();
            if i < 79 { beyond(i) - beyond(i + 1) } else { beyond(i) }
        })
        .collect()
}

#[test]
fn free_paths_are_exponentially_distributed() {
    for (seed, sigma_s) in [(1, 0.05_f32), (2, 1.0), (3, 40.0)] {
        let mut stream = stream(seed);
        let end = 8.0 / f64::from(sigma_s);
        let counts = histogram(80, end, 1_000_000, || f64::from(free_path(sigma_s, &mut stream)));
        let p = p_value(&counts, &free_path_shares());
        assert!(p > LEVEL, "sigma_s {sigma_s}: p {p}");
    }
}

/// Shares of the angles in `bins` equal bins of [0, end); the last holds all beyond.
fn angle_shares(phase: &dyn PhaseFunction, bins: usize, end: f64) -> Vec<f64> {
    let density = |theta: f64| 2.0 * PI * theta.sin() * phase.pdf(theta.cos());
    let bin = |i: usize| {
        // Simpson's rule on 64 panels.
        let (left, h) = (end * i as f64 / bins as f64, end / (bins * 64) as f64);
        let weight = |j: usize| if j == 0 || j == 64 { 1.0 } else { f64::from(2 + 2 * (j as u32 % 2)) };
        (0..=64).map(|j| weight(j) * density(left + h * j as f64)).sum::<f64>() * h / 3.0
    };
    let mut shares: Vec<f64> = (0..bins).map(bin).collect();
    shares[bins - 1] += 1.0 - shares.iter().sum::<f64>();
    shares
}

/// p-values of the polar angle and of the azimuth of deflections drawn from `drawn`, if `claimed` were true.
fn test_deflections(
    drawn: &impl PhaseFunction,
    claimed: &dyn PhaseFunction,
    end: f64,
    samples: usize,
) -> [f64; 2] {
    let mut stream = stream(5);
    let mut azimuths = vec![0; 24];
    let counts = histogram(100, end, samples, || {
        let [sin, cos, cos_phi, sin_phi] = drawn.sample(&mut || stream.uniform()).map(f64::from);
        assert!((sin.hypot(cos) - 1.0).abs() < 1e-6 && (sin_phi.hypot(cos_phi) - 1.0).abs() < 1e-6);
        let turn = sin_phi.atan2(cos_phi) / (2.0 * PI) + 0.5;
        azimuths[((24.0 * turn) as usize).min(23)] += 1;
        sin.atan2(cos)
    });
    [p_value(&counts, &angle_shares(claimed, 100, end)), p_value(&azimuths, &[1.0 / 24.0; 24])]
}

#[test]
fn gaussian_deflections_follow_the_phase_function_at_every_width() {
    for b in [1e-5, 1e-3, 0.01, 0.1, 0.3, 2.0_f64] {
        let phase = Gaussian::new(b).unwrap();
        let p = test_deflections(&phase, &phase, PI.min(7.0 * b.sqrt()), 1_000_000);
        assert!(p[0] > LEVEL && p[1] > LEVEL, "B {b}: p {p:?}");
    }
}

#[test]
fn henyey_greenstein_deflections_follow_the_phase_function_at_every_mean_cosine() {
    for g in [0.1, 0.5, 0.9, 0.98, 0.999] {
        let phase = HenyeyGreenstein::new(g).unwrap();
        let p = test_deflections(&phase, &phase, PI.min(20.0 * (1.0 - g)), 1_000_000);
        assert!(p[0] > LEVEL && p[1] > LEVEL, "g {g}: p {p:?}");
    }
}

#[test]
fn the_chi_square_test_rejects_a_wrong_distribution() {
    // A Gaussian 2 % off in B, and one that forgets sin(theta)/theta: the planar phase function, which differs at B = 0.1.
    let (drawn, claimed) = (Gaussian::new(0.0102).unwrap(), Gaussian::new(0.01).unwrap());
    assert!(test_deflections(&drawn, &claimed, 0.7, 1_000_000)[0] < 1e-9);
    let claimed = Gaussian::new(0.1).unwrap();
    let mut stream = stream(6);
    let mut planar = || (-0.4 * f64::from(stream.uniform_above_zero()).ln()).sqrt();
    let counts = histogram(100, 2.2, 1_000_000, &mut planar);
    assert!(p_value(&counts, &angle_shares(&claimed, 100, 2.2)) < 1e-9);
    let counts = histogram(80, 8.0, 1_000_000, || f64::from(free_path(1.02, &mut stream)));
    assert!(p_value(&counts, &free_path_shares()) < 1e-9);
}

fn gaussian(spread_angle_deg: f64) -> Gaussian {
    let spread = spread_angle_deg.to_radians();
    Gaussian::new(0.25 * spread * spread).unwrap()
}

fn medium<P>(sigma_s: f64, sigma_a: f64, phase: P) -> Medium<P> {
    Medium::new(sigma_s, sigma_a, phase).unwrap()
}

fn config<P>(medium: Medium<P>, depths: &[f64], paths: u64, seed: u64) -> RadialConfig<P> {
    RadialConfig { medium, depths: depths.to_vec(), edges: log_spaced(1e-4, 30.0, 120), paths, seed }
}

fn trace<P: PhaseFunction + Copy>(config: &RadialConfig<P>) -> Vec<RadialProfile> {
    trace_radial(config, &|_| ()).unwrap()
}

#[test]
fn direct_light_follows_beer_and_lambert() {
    let medium = medium(0.8, 0.3, gaussian(20.0));
    let config = config(medium, &[0.01, 0.3, 1.0, 2.0, 4.0, 8.0], 1_000_000, 11);
    for profile in trace(&config) {
        let z = profile.direct().z_score((-1.1 * profile.z).exp());
        assert!(z.abs() < 4.0, "z = {}: {z} standard errors", profile.z);
    }
}

#[test]
fn without_absorption_all_light_arrives_or_is_lost_through_the_surface() {
    let wide = Gaussian::new(0.3).unwrap();
    let mut last = 0.0;
    for profile in trace(&config(medium(1.5, 0.0, wide), &[0.1, 0.5, 1.0, 2.0, 3.0], 200_000, 12)) {
        let (direct, scattered, lost) = (profile.direct(), profile.scattered(), profile.lost());
        assert!((direct.value + scattered.value + lost.value - 1.0).abs() < 1e-12, "z = {}", profile.z);
        assert!(lost.value >= last, "a path lost to a plane is lost to all behind it");
        last = lost.value;
    }
    assert!(last > 0.01, "wide phase functions turn light back: {last}");
}

#[test]
fn isotropic_scatterers_transmit_what_chandrasekhar_says() {
    // Total transmittance at normal incidence of a thick slab of isotropic scatterers without absorption:
    // H(1)/sqrt(3) / (tau + 1.4208), with Chandrasekhar's H(1) = 2.9078 (Radiative Transfer, 1960, table XI).
    let exact = 2.9078 / 3.0_f64.sqrt() / (4.0 + 1.4208);
    let nearly_isotropic = HenyeyGreenstein::new(1e-4).unwrap();
    let profile = &trace(&config(medium(1.0, 0.0, nearly_isotropic), &[4.0], 400_000, 13))[0];
    let arrived = profile.direct().value + profile.scattered().value;
    // The formula is asymptotic: the rest falls like exp(-tau) and faster.
    assert!((arrived - exact).abs() < 4.0 * profile.lost().std_error + 1e-3, "{arrived} {exact}");
}

#[test]
fn the_second_moment_stands_to_the_exact_formula_as_tabled() {
    // R = (4/3) sigma_s B z³ exp(-sigma_a z) holds for small angles. The table was traced with 4·10⁵ paths and is
    // printed to two decimals; four standard errors of both traces and half a digit are allowed.
    let table: [(f64, &[f64], &[f64]); 2] =
        [(5.0, &[1.0, 3.0, 10.0], &[1.02, 1.03, 1.06]), (10.0, &[1.0, 3.0], &[1.07, 1.14])];
    for (spread_angle_deg, depths, ratios) in table {
        let phase = gaussian(spread_angle_deg);
        let paths = 1_600_000;
        let profiles = trace(&config(medium(0.95, 0.05, phase), depths, paths, 14));
        for (profile, &tabled) in profiles.iter().zip(ratios) {
            let z = profile.z;
            let exact = 4.0 / 3.0 * 0.95 * phase.b() * z.powi(3) * (-0.05 * z).exp();
            let moment = profile.second_moment();
            let (ratio, noise) = (moment.value / exact, moment.std_error / exact);
            let tabled_noise = noise * (paths as f64 / 4e5).sqrt();
            println!("spread {spread_angle_deg}°, z {z}: ratio {ratio:.3} ± {noise:.3}, tabled {tabled}");
            let allowed = 4.0 * noise.hypot(tabled_noise) + 0.005;
            assert!((ratio - tabled).abs() < allowed, "{spread_angle_deg}° z {z}: {ratio} ± {noise}");
            assert!(noise < 0.01);
        }
    }
}

#[test]
fn narrow_lobes_have_the_transfer_function_of_small_angle_theory() {
    // tau 4B = .0024 at 2 degrees: theory is within .19 of that.
    let (phase, sigma_s, sigma_a, z) = (gaussian(2.0), 2.0, 0.2, 1.0);
    let profile = &trace(&config(medium(sigma_s, sigma_a, phase), &[z], 1_000_000, 15))[0];
    for k in [0.0, 5.0, 20.0, 50.0, 100.0, 200.0, 500.0] {
        let mean = phase.mean_planar_transform(k * z);
        let theory = (-(sigma_s + sigma_a) * z + sigma_s * z * mean).exp();
        let traced = profile.mtf(k);
        let error = (traced.value - theory).abs();
        assert!(error < 4.0 * traced.std_error + 5e-4, "k {k}: {traced:?} {theory}");
    }
    let total = profile.direct().value + profile.scattered().value;
    assert!((profile.mtf(0.0).value - total).abs() < 1e-12);
}

#[test]
fn encircled_energy_density_and_total_are_sums_of_the_same_bins() {
    let profile = &trace(&config(medium(2.0, 0.1, gaussian(8.0)), &[1.0], 100_000, 16))[0];
    let last = profile.edges.len() - 1;
    let area = |i: usize| PI * profile.edges[i] * profile.edges[i];
    let rings: f64 = (0..last).map(|i| profile.density(i, i + 1).value * (area(i + 1) - area(i))).sum();
    let whole = profile.encircled_energy(last).value;
    assert!((rings + profile.encircled_energy(0).value - whole).abs() < 1e-12);
    assert!((profile.scattered().value - whole).abs() < 1e-3, "hardly any light lands beyond 30 depths");
    assert!(profile.scattered_paths() > 80_000);
}

#[test]
fn planes_traced_together_agree_with_each_traced_alone() {
    let phase = gaussian(15.0);
    let together = trace(&config(medium(1.0, 0.1, phase), &[0.5, 1.0, 2.0], 200_000, 17));
    for profile in &together {
        let alone = &trace(&config(medium(1.0, 0.1, phase), &[profile.z], 200_000, 17))[0];
        // The same streams: the same paths up to this plane.
        assert_eq!(profile.scattered_paths(), alone.scattered_paths());
        assert_eq!(profile.second_moment(), alone.second_moment());
    }
}

#[test]
fn radial_tallies_are_the_same_for_any_number_of_threads() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trace(&config(medium(2.0, 0.1, gaussian(8.0)), &[0.5, 1.0], 150_000, 18)))
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
    let other = trace(&config(medium(2.0, 0.1, gaussian(8.0)), &[0.5, 1.0], 150_000, 19));
    assert_ne!(one, other, "another seed gives other paths");
    let z = (one[1].scattered().value - other[1].scattered().value) / one[1].scattered().std_error;
    assert!(z.abs() < 4.0 * 2.0_f64.sqrt(), "{z}");
}

#[test]
fn progress_counts_every_path() {
    use std::sync::atomic::{AtomicU64, Ordering};
    let told = AtomicU64::new(0);
    let progress = |n| {
        told.fetch_add(n, Ordering::Relaxed);
    };
    trace_radial(&config(medium(1.0, 0.0, gaussian(8.0)), &[1.0], 50_001, 20), &progress).unwrap();
    assert_eq!(told.into_inner(), 50_001);
}

#[test]
fn a_radial_trace_that_makes_no_sense_is_refused_by_name() {
    let good = config(medium(1.0, 0.0, gaussian(8.0)), &[1.0], 10, 1);
    let message = |bad: RadialConfig<Gaussian>| trace_radial(&bad, &|_| ()).unwrap_err().to_string();
    assert!(
        message(RadialConfig { depths: vec![1.0, 0.5], ..good.clone() }).contains("depth of a plane = 0.5")
    );
    assert!(message(RadialConfig { depths: vec![], ..good.clone() }).contains("count of depth"));
    assert!(
        message(RadialConfig { depths: vec![f64::NAN], ..good.clone() }).contains("depth of a plane = NaN")
    );
    assert!(
        message(RadialConfig { edges: vec![0.0, 1.0], ..good.clone() }).contains("edge of a radius bin = 0")
    );
    assert!(message(RadialConfig { paths: 0, ..good }).contains("paths = 0"));
}
