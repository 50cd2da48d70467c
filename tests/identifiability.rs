//! What is determined where not everything is, and whether the advised measurements keep what they promise.

use narrowbeam::filter::Filter;
use narrowbeam::fit::forecast::{Plan, forecast};
use narrowbeam::fit::noise::with_noise;
use narrowbeam::fit::scenes::{SceneFit, fit_scenes};
use narrowbeam::fit::{NAMES, Settings, Status};
use narrowbeam::geometry::{Field, Geometry};
use narrowbeam::image::{Channel, Image};
use narrowbeam::scene::{Gain, MediumValues, Scene};
use narrowbeam::spread::Model;
use narrowbeam::study::{Setting, Texture};
use rustfft::num_complex::Complex;

fn scene(plane: &Setting, noise: f64, seed: u64) -> Scene {
    plane.scene(with_noise(&plane.render(Model::SmallAngle).unwrap(), noise, seed), Some(noise)).unwrap()
}

fn fit(scenes: &[Scene]) -> SceneFit {
    let mut fit = fit_scenes(scenes, &Settings::default(), Filter::Auto).unwrap();
    fit.add_advice(scenes, &Settings::default(), Filter::Auto).unwrap();
    fit
}

fn show(fit: &SceneFit) {
    for row in fit.report.table("1/m") { println!("{}", row.join("  ")); }
    for line in fit.report.remarks() { println!("{line}"); }
    for w in &fit.report.warnings { println!("{}: {}", w.code, w.message); }
}

#[test]
fn explore_thick() {
    for tau in [8.0, 10.0, 12.0] {
        for noise in [0.0003, 0.001, 0.003, 0.01] {
            let plane = Setting { texture: Texture::Checker, side: 48, pixel_pitch: 0.03, z: 2.0,
                medium: MediumValues { sigma_s: tau / 2.0, sigma_a: 0.1, b: 0.0005 } };
            println!("=== tau {tau} noise {noise}");
            show(&fit(&[scene(&plane, noise, 1)]));
        }
    }
}

#[test]
fn explore_gain() {
    let plane = Setting { texture: Texture::Checker, side: 48, pixel_pitch: 0.03, z: 2.0,
        medium: MediumValues { sigma_s: 0.7, sigma_a: 0.15, b: 0.004 } };
    let mut s = scene(&plane, 0.01, 1);
    s.observation.as_mut().unwrap().gain = Gain::Free;
    show(&fit(&[s]));
    for noise in [0.001, 0.003, 0.01] {
        let flat = Setting { texture: Texture::NearlyFlat, ..plane };
        println!("=== flat {noise}");
        show(&fit(&[scene(&flat, noise, 1)]));
    }
}

fn one_over_f(side: usize, contrast: f32) -> Image {
    let mut planner = rustfft::FftPlanner::<f64>::new();
    let fft = planner.plan_fft_inverse(side);
    let noise = with_noise(&Image::filled(side, side, 0.0), 1.0, 9);
    let phase = with_noise(&Image::filled(side, side, 0.0), 1.0, 10);
    let f = |i: usize| (if i > side / 2 { i as f64 - side as f64 } else { i as f64 }) / side as f64;
    let mut data: Vec<Complex<f64>> = (0..side * side).map(|i| {
        let k = f(i % side).hypot(f(i / side));
        if k == 0.0 { Complex::default() } else { Complex::new(f64::from(noise.data[i]), f64::from(phase.data[i])) / k }
    }).collect();
    for _ in 0..2 {
        data.chunks_mut(side).for_each(|row| fft.process(row));
        data = (0..side * side).map(|i| data[(i % side) * side + i / side]).collect();
    }
    let rms = (data.iter().map(|c| c.re * c.re).sum::<f64>() / data.len() as f64).sqrt();
    Image::from_fn(side, side, |x, y| 1.0 + contrast * (data[y * side + x].re / rms) as f32)
}

#[test]
fn explore_table() {
    for contrast in [0.25, 0.35, 0.5] {
        let side = 256;
        let object = one_over_f(side, contrast);
        println!("contrast {contrast} min {:?}", object.data.iter().copied().fold(f32::INFINITY, f32::min));
        for tau in [0.5, 1.0, 2.0, 4.0, 6.0, 8.0] {
            let z = 2.0;
            let plane = Setting { texture: Texture::Checker, side, pixel_pitch: 0.001 * z, z,
                medium: MediumValues { sigma_s: tau / z, sigma_a: 0.05 * tau / z, b: 0.05f64.powi(2) / 4.0 } };
            let mut one = plane.scene(Image::filled(side, side, 1.0), None).unwrap();
            one.object = vec![Channel { name: "Y".into(), image: object.clone() }];
            one.border = narrowbeam::image::Border::Mirror;
            let mut near = one.clone();
            near.geometry = Geometry::planar(side, side, 0.001 * z / 2.0, z / 2.0).unwrap();
            let mut spanning = one.clone();
            spanning.geometry.depth = Field::Map(Image::from_fn(side, side, |x, _| if 2 * x < side { z as f32 / 2.0 } else { z as f32 }));
            let run = |scenes: &[Scene], free: bool| {
                let plan = Plan { noise: 0.01, free_gain: free, free_veil: free };
                let fit = forecast(scenes, &[plane.medium], &plan, &Settings::default(), Filter::Eq29).unwrap();
                let fit = &fit.channels[0].1;
                let e = |i: usize| fit.uncertainty.std_error(i).map_or(f64::NAN, |e| 100.0 * if i == 1 { e / fit.parameters.values()[1] } else { e });
                [e(0), e(2), e(1)]
            };
            println!("tau {tau}: known {:.3?} two free {:.3?} two known {:.3?} spanning free {:.3?}", run(&[one.clone()], false), run(&[near.clone(), one.clone()], true), run(&[near.clone(), one.clone()], false), run(&[spanning], true));
        }
    }
    let _ = (NAMES, Status::Free);
}
