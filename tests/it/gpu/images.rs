//! Images and their derivatives against those of the CPU and of the f64 definition.

use super::gpu;
use super::scenes::{self, Scene};
use crate::common::{pixels, relative_l2};
use narrowbeam::filter::cpu::{CpuFilter, Rendering};
use narrowbeam::filter::gpu::GpuFilter;
use narrowbeam::filter::{Optics, composite_sum, direct_sum, per_depth};
use narrowbeam::image::{Border, Image};
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;

/// CPU and device read the same tables and differ by the roundings of their transforms, some 1e-7 of an image; where
/// light is taken through occluders, the quotients of transfer functions magnify them. A hundredth of the slices' 1e-4.
const SAME: f64 = 1e-6;
const SAME_BEHIND_OCCLUDERS: f64 = 1e-5;

/// Width of the phase function, rad².
const B: f64 = 0.003;

fn planes(rendering: Rendering) -> [Image; 4] {
    let [s, a, b] = rendering.gradient.unwrap();
    [rendering.image, s, a, b]
}

fn distance(a: &Image, b: &Image) -> f64 {
    relative_l2(pixels(a), pixels(b))
}

/// Distance of image and derivatives, and of the image alone, from those of the CPU.
fn distances(scene: &Scene, model: Model) -> [f64; 5] {
    let phase = Gaussian::new(B).unwrap();
    let optics = Optics { model, medium: Medium::new(0.8, 0.1, phase.into()).unwrap() };
    let cpu = CpuFilter::new(scene.target(), &optics, 1.0).unwrap();
    let filter = GpuFilter::new(gpu(), scene.target(), &optics, 1.0).unwrap();
    let theirs = planes(cpu.render_with_gradient(&optics).unwrap());
    let ours = planes(filter.render_with_gradient(&optics).unwrap());
    let alone = distance(&filter.render(&optics).unwrap(), &theirs[0]);
    let of = |i: usize| {
        // Beer-Lambert's light does not depend on B; roundings are a share of the light times 1/B.
        let scale = if theirs[i].data.iter().all(|v| *v == 0.0) { &theirs[0] } else { &theirs[i] };
        let unit = if i == 3 && std::ptr::eq(scale, &theirs[0]) { B } else { 1.0 };
        let apart = pixels(&ours[i]).zip(pixels(&theirs[i])).map(|(a, b)| unit * (a - b).abs());
        apart.map(|v| v * v).sum::<f64>().sqrt() / pixels(scale).map(|v| v * v).sum::<f64>().sqrt()
    };
    [of(0), of(1), of(2), of(3), alone]
}

#[test]
fn images_and_derivatives_equal_those_of_the_cpu() {
    println!("scene                        image   d/dsigma_s d/dsigma_a d/dB    image alone");
    for scene in scenes::all() {
        let d = distances(&scene, Model::SmallAngle);
        println!("{:28} {:.1e} {:.1e}    {:.1e}    {:.1e} {:.1e}", scene.name, d[0], d[1], d[2], d[3], d[4]);
        let same = if scene.name.contains("box") { SAME_BEHIND_OCCLUDERS } else { SAME };
        // Derivatives are differences of transfer functions a few times larger than they are.
        assert!(d[0].max(d[4]) < same && d[1].max(d[2]).max(d[3]) < 5.0 * same, "{}: {d:?}", scene.name);
    }
}

#[test]
fn every_model_equals_its_cpu_image() {
    let scene = scenes::all().into_iter().find(|s| s.name == "box and layer, mirror").unwrap();
    for model in Model::ALL {
        let d = distances(&scene, model);
        println!("{model:20} {d:.1?}");
        assert!(d.iter().all(|d| *d < 5.0 * SAME_BEHIND_OCCLUDERS), "{model}: {d:?}");
    }
}

#[test]
fn another_medium_is_told_apart() {
    let scene = &scenes::all()[0];
    let phase = Gaussian::new(B).unwrap();
    let optics = |sigma_s: f64| Optics {
        model: Model::SmallAngle,
        medium: Medium::new(sigma_s, 0.1, phase.into()).unwrap(),
    };
    let cpu = CpuFilter::new(scene.target(), &optics(0.8), 1.0).unwrap().render(&optics(0.8)).unwrap();
    let filter = GpuFilter::new(gpu(), scene.target(), &optics(0.8), 1.0).unwrap();
    let off = distance(&filter.render(&optics(0.8 * (1.0 + 1e-4))).unwrap(), &cpu);
    println!("sigma_s off by 1e-4: image off by {off:.1e}");
    assert!(off > SAME_BEHIND_OCCLUDERS);
}

/// The bound for images, and for the light that they add up to.
const IMAGE: f64 = 1e-3;
const ENERGY: f64 = 1e-4;

/// Small-angle optics whose kernel is `width_px` pixels wide at the mean depth of a [`Scene::slope`].
fn width(width_px: f64) -> Gaussian {
    Gaussian::new((width_px * scenes::PITCH / scenes::MEAN_DEPTH).powi(2)).unwrap()
}

/// GPU, CPU, and the light that the GPU's image adds up to, against the f64 image `exact`.
fn against(scene: &Scene, optics: &Optics, exact: &[f64]) -> [f64; 3] {
    let ours = GpuFilter::new(gpu(), scene.target(), optics, 1.0).unwrap().render(optics).unwrap();
    let cpu = CpuFilter::new(scene.target(), optics, 1.0).unwrap().render(optics).unwrap();
    let sum: f64 = pixels(&ours).sum();
    let to = |image: &Image| relative_l2(pixels(image), exact.iter().copied());
    [to(&ours), to(&cpu), (sum / exact.iter().sum::<f64>() - 1.0).abs()]
}

fn row(what: &str, width_px: f64, [gpu, cpu, energy]: [f64; 3]) {
    println!("{what:34} {width_px:5}   {gpu:.1e} {cpu:.1e} {energy:.1e}");
    assert!(gpu < IMAGE && energy < ENERGY, "{what}, {width_px} px: {gpu}, {energy}");
}

#[test]
fn images_equal_the_definition_at_every_kernel_width() {
    println!("reference                        width/px   gpu     cpu     gpu's total light");
    let medium = |width_px| Medium::new(0.8, 0.1, width(width_px).into()).unwrap();
    for width_px in [0.05, 1.0, 4.0] {
        let optics = Optics { model: Model::SmallAngle, medium: medium(width_px) };
        let scene = Scene::slope((32, 24), 8);
        let exact = direct_sum::render(&scene.target(), &optics).unwrap();
        row("direct sum, f64, 32x24 slope", width_px, against(&scene, &optics, &exact));
    }
    for width_px in [0.3, 2.0, 16.0] {
        let optics = Optics { model: Model::SmallAngle, medium: medium(width_px) };
        let scene = Scene::slope((128, 96), 12);
        let exact = per_depth::render(&scene.target(), &optics).unwrap();
        row("per depth, f64, 128x96 slope", width_px, against(&scene, &optics, &exact));
        let scene = Scene::slope((24, 16), 24).composite();
        let exact = composite_sum::render(&scene.target(), &optics).unwrap();
        row("composite sum, f64, 24x16 slope", width_px, against(&scene, &optics, &exact));
    }
}

/// Of a mirrored scene no light leaves; without absorption all of it arrives.
#[test]
fn light_is_neither_lost_nor_made() {
    for width_px in [0.1, 1.0, 10.0, 100.0] {
        let phase = width(width_px);
        let optics =
            Optics { model: Model::SmallAngle, medium: Medium::new(1.2, 0.0, phase.into()).unwrap() };
        let scene = Scene::slope((64, 48), 64).border(Border::Mirror);
        let image = GpuFilter::new(gpu(), scene.target(), &optics, 1.0).unwrap().render(&optics).unwrap();
        let (arrived, sent) = (pixels(&image).sum::<f64>(), pixels(scene.target().radiance).sum::<f64>());
        println!("kernel {width_px} px: {:.1e} of the light is lost", 1.0 - arrived / sent);
        assert!((arrived / sent - 1.0).abs() < ENERGY);
    }
}

#[test]
#[ignore = "half an hour on a software adapter; cargo test --release --test it full_size -- --ignored --nocapture"]
fn a_full_size_image_equals_the_definition_at_every_kernel_width() {
    println!("reference                        width/px   gpu     cpu     gpu's total light");
    for width_px in [0.3, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0, 256.0] {
        let phase = width(width_px);
        let medium = Medium::new(0.8, 0.1, phase.into()).unwrap();
        let optics = Optics { model: Model::SmallAngle, medium };
        let scene = Scene::slope((512, 512), 16);
        let exact = per_depth::render(&scene.target(), &optics).unwrap();
        row("per depth, f64, 512x512 slope", width_px, against(&scene, &optics, &exact));
    }
}
