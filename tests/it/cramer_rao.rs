//! Cramér-Rao floors of planned measurements: docs/identifiability.md has the table.

use narrowbeam::filter::Filter;
use narrowbeam::fit::noise::with_noise;
use narrowbeam::fit::{Plan, Settings, forecast};
use narrowbeam::geometry::{Field, Geometry};
use narrowbeam::image::{Border, Image};
use narrowbeam::lab::study::{Setting, Texture};
use narrowbeam::medium::Medium;
use narrowbeam::phase::b_of_spread_angle;
use narrowbeam::scene::Scene;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

const SIDE: usize = 256;
const Z: f64 = 2.0;
/// Angle of a pixel, rad.
const PIXEL: f64 = 1e-3;
const NOISE: f64 = 0.01;

/// Normal noise whose amplitude falls with frequency f like 1/f to the `power`, mean 1, standard deviation `contrast`.
fn noise_of_spectrum(power: f64, contrast: f64) -> Image {
    let fft = FftPlanner::<f64>::new().plan_fft_inverse(SIDE);
    let normal = |seed| with_noise(&Image::filled(SIDE, SIDE, 0.0), 1.0, seed).data;
    let (re, im) = (normal(1), normal(2));
    let along = |i: usize| if i > SIDE / 2 { SIDE - i } else { i } as f64;
    let mut waves: Vec<Complex<f64>> = (0..SIDE * SIDE)
        .map(|i| {
            let f = along(i % SIDE).hypot(along(i / SIDE));
            let amplitude = if f == 0.0 { 0.0 } else { f.powf(-power) };
            amplitude * Complex::new(f64::from(re[i]), f64::from(im[i]))
        })
        .collect();
    for _ in 0..2 {
        waves.chunks_mut(SIDE).for_each(|row| fft.process(row));
        waves = (0..SIDE * SIDE).map(|i| waves[(i % SIDE) * SIDE + i / SIDE]).collect();
    }
    let rms = (waves.iter().map(|w| w.re * w.re).sum::<f64>() / waves.len() as f64).sqrt();
    Image::from_fn(SIDE, SIDE, |x, y| (1.0 + contrast * waves[y * SIDE + x].re / rms) as f32)
}

fn medium(tau: f64) -> Medium {
    Medium::gaussian(tau / Z, 0.1 / Z, b_of_spread_angle(0.05)).unwrap()
}

fn scene(object: &Image, z: f64, tau: f64) -> Scene {
    let plane =
        Setting { texture: Texture::Edge, side: SIDE, pixel_pitch: PIXEL * z, z, medium: medium(tau) };
    let mut scene = plane.scene(object.clone(), None).unwrap().scene;
    scene.object[0].image = object.clone();
    scene.border = Border::Mirror;
    scene
}

/// Half of the object at half the depth, pixels of one length.
fn spanning(object: &Image, tau: f64) -> Scene {
    let mut scene = scene(object, Z, tau);
    let depth = Image::from_fn(SIDE, SIDE, |x, _| if 2 * x < SIDE { 0.5 * Z as f32 } else { Z as f32 });
    scene.geometry = Geometry { depth: Field::Map(depth), ..scene.geometry };
    scene
}

/// Standard errors of ln sigma_s, ln B and sigma_a Z in percent; NaN if undetermined.
fn floors(scenes: &[Scene], tau: f64, free: bool) -> [f64; 3] {
    let plan = Plan { noise: NOISE, free_gain: free, free_veil: free };
    let fit = forecast(scenes, &[medium(tau)], &plan, &Settings::default(), Filter::Eq29).unwrap();
    let (_, fit) = &fit.channels[0];
    let error = |name| {
        let id = fit.parameters.find(name).unwrap();
        fit.covariance.std_error(id).unwrap_or(f64::NAN)
    };
    [100.0 * error("sigma_s"), 100.0 * error("b"), 100.0 * Z * error("sigma_a")]
}

/// Scattering depths of the table.
const TAUS: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 6.0, 8.0];
/// The same floors, in percent, by a calculation that shares no code with this program, for a target of which only the 1/f
/// spectrum is on record: of ln sigma_s and ln B with one depth, then with two.
const ELSEWHERE: [[f64; 6]; 4] = [
    [0.21, 0.16, 0.20, 0.52, 1.4, 2.8],
    [0.58, 0.35, 0.26, 0.36, 0.81, 1.6],
    [0.27, 0.17, 0.14, 0.18, 0.27, 0.46],
    [0.72, 0.44, 0.32, 0.30, 0.34, 0.43],
];

#[test]
fn floors_follow_scattering_depth_as_they_should() {
    let object = noise_of_spectrum(1.0, 0.25);
    let mut found = [[0.0; 6]; 4];
    let mut absorption = [0.0; 6];
    println!(
        "| tau | one depth: `sigma_s`, `b`, `sigma_a` z | two depths, gains and veils free: `sigma_s`, `b` | one exposure of two depths, gain and veil free: `sigma_s`, `b`, `sigma_a` z |"
    );
    println!("| --- | --- | --- | --- |");
    for (i, tau) in TAUS.into_iter().enumerate() {
        let one = floors(&[scene(&object, Z, tau)], tau, false);
        let two = floors(&[scene(&object, 0.5 * Z, tau), scene(&object, Z, tau)], tau, true);
        let at_once = floors(&[spanning(&object, tau)], tau, true);
        println!(
            "| {tau} | {:.3}, {:.3}, {:.4} | {:.3}, {:.3} | {:.3}, {:.3}, {:.4} |",
            one[0], one[1], one[2], two[0], two[1], at_once[0], at_once[1], at_once[2]
        );
        assert!(two[2].is_nan(), "each gain hides the absorption before it");
        [one[0], one[1], two[0], two[1]].into_iter().zip(&mut found).for_each(|(v, row)| row[i] = v);
        absorption[i] = at_once[2];
    }
    for (name, (found, elsewhere)) in ["sigma_s, one depth", "b, one depth", "sigma_s, two", "b, two"]
        .iter()
        .zip(found.iter().zip(&ELSEWHERE))
    {
        let ratios: Vec<f64> = found.iter().zip(elsewhere).map(|(a, b)| b / a).collect();
        let (low, high) = ratios.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), r| (l.min(*r), h.max(*r)));
        println!("{name}: elsewhere {low:.2} to {high:.2} times as large");
        // A target of another contrast, or with more of it in coarse or fine detail, moves a row as a whole; tau moves it tenfold.
        assert!(high / low < 1.35, "{name}: {ratios:?}");
    }
    // At tau 8 one depth leaves sigma_s six times less certain than two, whose gains are not even known.
    assert!((4.0..9.0).contains(&(found[0][5] / found[2][5])), "{found:?}");
    assert!(absorption.iter().all(|a| a.is_finite()));
}
