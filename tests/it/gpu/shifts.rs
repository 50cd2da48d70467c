//! Renders moved by a fraction of a pixel: stages against their twins, images and sums against those of the CPU.

use super::gpu;
use super::scenes::{self, Scene};
use super::stages::{Draw, OBJECT, PIXELS, canvas, check, complex_buffer, floats, run};
use super::twins::{arrive, crop, shift};
use crate::common::{pixels, relative_l2};
use narrowbeam::filter::Optics;
use narrowbeam::filter::cpu::{CpuFilter, Rendering};
use narrowbeam::filter::gpu::{Collect, Crop, GpuFilter, ShiftBy, shaders};
use narrowbeam::image::Image;
use narrowbeam::medium::Medium;
use narrowbeam::spread::Model;

#[test]
fn arrive_equals_its_twin() {
    let mut draw = Draw::new(7);
    for (border, derivatives) in [(0, 1), (1, 1), (2, 1), (0, 0)] {
        let sources = draw.sources(2 * OBJECT, 1);
        let weights = draw.numbers(2 * 30);
        for (before, direct, weights) in [(0, 1, &weights[..]), (1, 0, &weights[..]), (0, 1, &[1.0])] {
            let parameters = Collect {
                canvas: canvas(border),
                view: [2, 1],
                view_size: [6, 5],
                sigma_t: 0.8,
                unit: 3.0,
                derivatives,
                before,
                direct,
                padding: [0; 3],
            };
            let pairs = [draw.complex(PIXELS), draw.complex(PIXELS)];
            let mut arrived = [draw.complex(PIXELS), draw.complex(PIXELS)];
            let buffers = [
                &gpu().upload("sources", &sources).unwrap(),
                &gpu().upload("weights", weights).unwrap(),
                &complex_buffer(&pairs[0]),
                &complex_buffer(&pairs[1]),
                &complex_buffer(&arrived[0]),
                &complex_buffer(&arrived[1]),
            ];
            let read = [(4, 2 * PIXELS), (5, 2 * PIXELS)];
            let device = run(&shaders::ARRIVE, &parameters, &buffers, PIXELS.div_ceil(64), &read);
            arrive::arrive(&parameters, &sources, weights, &pairs, &mut arrived);
            let case = format!("border {border}, gradient {derivatives}, before {before}");
            check("arrive", &case, &device[0], &floats(&arrived[0]));
            check("arrive", &case, &device[1], &floats(&arrived[1]));
        }
    }
}

#[test]
fn shift_equals_its_twin() {
    let mut draw = Draw::new(8);
    for derivatives in [0, 1] {
        let parameters = ShiftBy { size: [18, 14], derivatives, padding: 0 };
        let factors = draw.lanes(18 + 14);
        let still = [draw.complex(PIXELS), draw.complex(PIXELS)];
        let mut moved = [0, 1, 2].map(|_| draw.complex(PIXELS));
        let buffers = [
            &gpu().upload("factors", &factors).unwrap(),
            &complex_buffer(&still[0]),
            &complex_buffer(&still[1]),
            &complex_buffer(&moved[0]),
            &complex_buffer(&moved[1]),
            &complex_buffer(&moved[2]),
        ];
        let read = [3, 4, 5].map(|i| (i, 2 * PIXELS));
        let device = run(&shaders::SHIFT, &parameters, &buffers, PIXELS.div_ceil(64), &read);
        shift::shift(&parameters, &factors, &still, &mut moved);
        for (device, twin) in device.iter().zip(&moved) {
            check("shift", &format!("gradient {derivatives}"), device, &floats(twin));
        }
    }
}

#[test]
fn crop_equals_its_twin() {
    let mut draw = Draw::new(9);
    for derivatives in [0, 1] {
        let parameters = Crop { width: 18, corner: [6, 4], view_size: [6, 5], derivatives, padding: [0; 2] };
        let pairs = [0, 1, 2].map(|_| draw.complex(PIXELS));
        let mut planes = draw.numbers(6 * 30);
        let buffers = [
            &complex_buffer(&pairs[0]),
            &complex_buffer(&pairs[1]),
            &complex_buffer(&pairs[2]),
            &gpu().upload("planes", &planes).unwrap(),
        ];
        let device = run(&shaders::CROP, &parameters, &buffers, 1, &[(3, 6 * 30)]);
        crop::crop(&parameters, &pairs, &mut planes);
        check("crop", &format!("gradient {derivatives}"), &device[0], &planes);
    }
}

const SHIFT_PX: [f64; 2] = [1.3, -0.45];
/// Width of the phase function, rad².
const B: f64 = 0.003;

fn optics(b: f64) -> Optics {
    Optics { model: Model::SmallAngle, medium: Medium::gaussian(0.8, 0.1, b).unwrap() }
}

/// Image, derivatives in sigma_s, sigma_a, B and in the shift.
fn planes(rendering: Rendering) -> [Image; 6] {
    let ([s, a, b], [x, y]) = (rendering.gradient.unwrap(), rendering.motion.unwrap());
    [rendering.image, s, a, b, x, y]
}

/// Distances of the images of a [`Rendering`] from those of the CPU, then of the image alone; the device moves by
/// `shift_px`, the CPU by [`SHIFT_PX`]. The last is that of the derivative in B, times B, as a share of the image.
fn distances(scene: &Scene, shift_px: [f64; 2]) -> [f64; 8] {
    let optics = optics(B);
    let cpu = CpuFilter::new(scene.target(), &optics, 1.0).unwrap();
    let filter = GpuFilter::new(gpu(), scene.target(), &optics, 1.0).unwrap();
    let theirs = planes(cpu.render_shifted_with_gradient(&optics, SHIFT_PX).unwrap());
    let alone = filter.render_shifted(&optics, shift_px).unwrap();
    let ours = planes(filter.render_shifted_with_gradient(&optics, shift_px).unwrap());
    let of = |i: usize| relative_l2(pixels(&ours[i]), pixels(&theirs[i]));
    let norm = |image: &Image| pixels(image).map(|v| v * v).sum::<f64>().sqrt();
    let share = B * of(3) * norm(&theirs[3]) / norm(&theirs[0]);
    [of(0), of(1), of(2), of(3), of(4), of(5), relative_l2(pixels(&alone), pixels(&theirs[0])), share]
}

#[test]
fn moved_images_and_derivatives_equal_those_of_the_cpu() {
    println!(
        "scene                        image   ds      da      dB      dx      dy      alone   B dB/image"
    );
    let all: Vec<_> = scenes::all().into_iter().map(|s| (s.name, distances(&s, SHIFT_PX))).collect();
    for (name, d) in &all {
        println!("{name:28} {}", d.map(|d| format!("{d:.1e}")).join(" "));
    }
    for (name, [image, s, a, b, x, y, alone, share]) in all {
        // The bounds of still images, tests/gpu/images.rs.
        let same = if name.contains("box") { 1e-5 } else { 1e-6 };
        assert!(image.max(alone) < same, "{name}: {image:.1e} {alone:.1e}");
        assert!([s, a, x, y].iter().all(|d| *d < 5.0 * same), "{name}: {s:.1e} {a:.1e} {x:.1e} {y:.1e}");
        // The derivative in sigma_a, which is transformed along with that in B, holds direct light, and through three
        // transforms its roundings are noise there: little of the image, more of the derivative where blur has taken
        // most of that.
        assert!(share < same && b < 50.0 * same, "{name}: {share:.1e} {b:.1e}");
    }
}

#[test]
fn another_shift_is_told_apart() {
    let d = distances(&scenes::all()[0], [SHIFT_PX[0] + 0.01, SHIFT_PX[1]]);
    println!("shift off by 0.01 px: {d:.5?}");
    assert!(d[..7].iter().all(|d| *d > 1e-4), "{d:?}");
}

#[test]
fn no_shift_changes_nothing_and_plain_renders_stay_what_they_are() {
    for scene in scenes::all().iter().filter(|s| s.name.starts_with("perspective") || s.name == "two depths")
    {
        let filter = GpuFilter::new(gpu(), scene.target(), &optics(B), 1.0).unwrap();
        let plain = filter.render(&optics(B)).unwrap();
        let still = filter.render_shifted(&optics(B), [0.0; 2]).unwrap();
        let off = relative_l2(pixels(&still), pixels(&plain));
        assert!(off < 1e-6, "{}: {off:.1e}", scene.name);
        assert_eq!(filter.render(&optics(B)).unwrap(), plain, "{}", scene.name);
    }
}

#[test]
fn sums_of_a_moved_render_are_those_of_its_images() {
    let optics = optics(2e-5);
    let scene = Scene::slope((96, 64), 96).border(narrowbeam::image::Border::Mirror);
    let cpu = CpuFilter::new(scene.target(), &optics, 1.0).unwrap();
    let images = planes(cpu.render_shifted_with_gradient(&optics, SHIFT_PX).unwrap());
    let observed = crate::common::with_noise(&images[0], 0.005, 4);
    let filter = GpuFilter::new(gpu(), scene.target(), &optics, 1.0).unwrap();
    let observation = filter.observe(observed.data.iter().map(|&y| (y, 1.0))).unwrap();
    let products = |shift_px, derivatives| {
        filter.products(&optics, &observation, [1.0, 0.0], derivatives, Some(shift_px)).unwrap()
    };
    let columns = |at: usize| -> Vec<f64> {
        let value = |image: &Image| f64::from(image.data[at]);
        let m = value(&images[0]);
        images.iter().map(value).chain([m - value(&observed), 1.0]).collect()
    };
    let mut exact = [[0.0; 8]; 8];
    for at in 0..observed.data.len() {
        let all = columns(at);
        (0..8).for_each(|i| (0..8).for_each(|j| exact[i][j] += all[i] * all[j]));
    }
    let apart = |device: &nalgebra::DMatrix<f64>, i: usize, j: usize| {
        (device[(i, j)] - exact[i][j]).abs() / (exact[i][i] * exact[j][j]).sqrt()
    };
    let device = products(SHIFT_PX, true);
    assert_eq!(device.shape(), (8, 8));
    let worst = (0..64).map(|k| apart(&device, k / 8, k % 8)).fold(0.0, f64::max);
    println!("sums apart by {worst:.1e} of the norms of the two images");
    // As for still images, tests/gpu/fits.rs.
    assert!(worst < 2e-4, "{worst}");
    let off = products([SHIFT_PX[0] + 0.01, SHIFT_PX[1]], true);
    assert!(apart(&off, 6, 4) > 1e-3, "a shift off by 0.01 px shows in the residual");

    let levels = products(SHIFT_PX, false);
    for (i, j) in (0..64).map(|k| (k / 8, k % 8)) {
        let derivative = (1..6).contains(&i) || (1..6).contains(&j);
        assert!(if derivative { levels[(i, j)] == 0.0 } else { apart(&levels, i, j) < 2e-4 }, "{i}, {j}");
    }
}
