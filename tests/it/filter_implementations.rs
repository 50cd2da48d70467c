//! The three implementations of the filter against each other, and what a filter must do whatever its kernel.

use crate::common::{pixels, relative_l2, sloping, texture};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Optics, Target, direct_sum, per_depth};
use narrowbeam::geometry::{Camera, Field, Geometry};
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;
use proptest::prelude::*;

fn optics(model: Model, phase: &Gaussian) -> Optics {
    Optics { model, medium: Medium::new(0.9, 0.1, (*phase).into()).unwrap() }
}

fn target<'a>(radiance: &'a Image, geometry: &'a Geometry, border: Border) -> Target<'a> {
    Target::plain(radiance, geometry, border, View::whole(radiance.width, radiance.height))
}

fn fast(target: &Target, optics: &Optics) -> Vec<f64> {
    let filter = CpuFilter::new(*target, optics, 1.0).unwrap();
    pixels(&filter.render(optics).unwrap()).collect()
}

/// The implementations' stated differences, as relative L2: quadrature and tabulation in the direct sum, the tail of the alias
/// sum (largest far below a pixel) and the 1e-8 beyond the padding in the second implementation.
const SECOND_RUNG: f64 = 2e-5;
/// Against the second implementation: f32, 1e-5 of the light beyond the padding, 1e-4 of slice interpolation.
const FAST_RUNG: f64 = 1e-4;

#[test]
fn one_depth_agrees_in_all_implementations_for_every_model_and_width() {
    println!("model                width/px   per depth - direct sum   fast - per depth   (relative L2)");
    let radiance = texture(24, 20);
    let phase = Gaussian::new(0.004).unwrap();
    for model in Model::ALL {
        // The definition sums over all of a kernel's reach, and grazing light goes far.
        let widest = if model == Model::WideAngle { 1.0 } else { 60.0 };
        for width_px in [0.05, 0.4, 1.0, 3.0, 12.0, 60.0].into_iter().filter(|&w| w <= widest) {
            let z = 1.5;
            let geometry = Geometry::planar(24, 20, z * 0.004_f64.sqrt() / width_px, z).unwrap();
            let target = target(&radiance, &geometry, Border::Zero);
            let optics = optics(model, &phase);
            let definition = direct_sum::render(&target, &optics).unwrap();
            let second = per_depth::render(&target, &optics).unwrap();
            let errors =
                [relative_l2(second.clone(), definition), relative_l2(fast(&target, &optics), second)];
            println!("{:20} {width_px:8}   {:22.1e}   {:16.1e}", model.name(), errors[0], errors[1]);
            assert!(errors[0] < SECOND_RUNG && errors[1] < FAST_RUNG, "{model} {width_px}: {errors:?}");
        }
    }
}

#[test]
fn borders_agree_in_all_implementations() {
    let radiance = texture(20, 16);
    let phase = Gaussian::new(0.004).unwrap();
    let geometry = Geometry::planar(20, 16, 0.1, 1.5).unwrap();
    for border in [Border::Zero, Border::Clamp, Border::Mirror] {
        let target = target(&radiance, &geometry, border);
        let optics = optics(Model::SmallAngle, &phase);
        let definition = direct_sum::render(&target, &optics).unwrap();
        let second = per_depth::render(&target, &optics).unwrap();
        let errors = [relative_l2(second.clone(), definition), relative_l2(fast(&target, &optics), second)];
        println!("{border:?}: {errors:?}");
        assert!(errors[0] < SECOND_RUNG && errors[1] < FAST_RUNG, "{border:?}: {errors:?}");
    }
}

/// Steps in depth and surface, along the camera's axis.
fn perspective(width: usize, height: usize) -> Geometry {
    let camera = Camera::perspective(40.0).unwrap();
    let depth = Field::Uniform(2.0);
    let flat = Geometry { width, height, camera, depth, behind: Vec::new(), surface: Field::Uniform(0.3) };
    let along_ray = |planar: &dyn Fn(usize, usize) -> f64| {
        Field::Map(Image::from_fn(width, height, |x, y| (planar(x, y) / flat.cos_off_axis(x, y)) as f32))
    };
    let depth = along_ray(&|x, y| 2.0 + 0.1 * (x / 5) as f64 + 0.05 * (y / 8) as f64);
    let surface = along_ray(&|x, _| 0.3 + 0.04 * (x / 10) as f64);
    Geometry { depth, surface, ..flat }
}

#[test]
fn depth_maps_surface_maps_and_perspective_agree_in_all_implementations() {
    let radiance = texture(20, 16);
    let phase = Gaussian::new(0.004).unwrap();
    let mut holes = sloping(20, 16, 0.1, 1.5, 0.3);
    if let Field::Map(depth) = &mut holes.depth {
        depth.data[45] = f32::INFINITY;
        depth.data[100] = 0.0;
    }
    for (name, geometry) in [("slope with holes", holes), ("perspective", perspective(20, 16))] {
        let target = target(&radiance, &geometry, Border::Zero);
        let optics = optics(Model::NarrowBeam, &phase);
        let definition = direct_sum::render(&target, &optics).unwrap();
        let second = per_depth::render(&target, &optics).unwrap();
        let errors = [relative_l2(second.clone(), definition), relative_l2(fast(&target, &optics), second)];
        println!("{name}: {errors:?}");
        assert!(errors[0] < SECOND_RUNG && errors[1] < FAST_RUNG, "{name}: {errors:?}");
    }
}

#[test]
fn the_comparison_rejects_a_filter_with_the_kernel_of_another_depth() {
    let radiance = texture(20, 16);
    let phase = Gaussian::new(0.004).unwrap();
    let (near, far) =
        (Geometry::planar(20, 16, 0.1, 1.5).unwrap(), Geometry::planar(20, 16, 0.1, 1.51).unwrap());
    let optics = optics(Model::SmallAngle, &phase);
    let right = per_depth::render(&target(&radiance, &near, Border::Zero), &optics).unwrap();
    let wrong = fast(&target(&radiance, &far, Border::Zero), &optics);
    assert!(relative_l2(wrong, right) > 5.0 * FAST_RUNG);
}

#[test]
fn slices_against_error_fall_as_tabulated() {
    let radiance = texture(32, 32);
    let phase = Gaussian::new(0.005).unwrap();
    // Error bounds: measured, times two. They fall geometrically, as Chebyshev interpolation must.
    let scenes = [
        (
            "slope 15°, z 1.91-2.09",
            sloping(32, 32, 0.02, 2.0, 0.268),
            [(2, 4e-3), (3, 2e-4), (4, 2e-5), (6, 2e-6)],
        ),
        (
            "slope 60°, z .95-2.05",
            sloping(32, 32, 0.02, 1.5, 1.732),
            [(3, 4e-2), (6, 2e-3), (10, 6e-5), (16, 4e-6)],
        ),
    ];
    println!("scene                  slices   relative L2 error");
    for (name, geometry, rows) in scenes {
        let target = target(&radiance, &geometry, Border::Zero);
        let optics = optics(Model::SmallAngle, &phase);
        let reference = per_depth::render(&target, &optics).unwrap();
        for (count, bound) in rows {
            let filter = CpuFilter::with_slices(target, count, 250.0).unwrap();
            assert_eq!(filter.slice_count(), count);
            let error = relative_l2(pixels(&filter.render(&optics).unwrap()), reference.clone());
            println!("{name:22} {count:6}   {error:.1e}");
            assert!(error < bound, "{name}, {count} slices: {error}");
        }
        assert!(relative_l2(fast(&target, &optics), reference) < FAST_RUNG);
    }
}

#[test]
fn image_derivatives_match_central_differences() {
    let radiance = texture(32, 32);
    for geometry in [Geometry::planar(32, 32, 0.05, 2.0).unwrap(), sloping(32, 32, 0.05, 2.0, 0.3)] {
        let target = target(&radiance, &geometry, Border::Zero);
        for model in Model::ALL {
            let point = [0.9, 0.1, 0.004];
            let filter = CpuFilter::new(target, &optics(model, &Gaussian::new(0.004).unwrap()), 1.5).unwrap();
            let render = |p: [f64; 3]| {
                let phase = Gaussian::new(p[2]).unwrap();
                let optics = Optics { model, medium: Medium::new(p[0], p[1], phase.into()).unwrap() };
                filter.render_with_gradient(&optics).unwrap()
            };
            let gradient = render(point).gradient.unwrap();
            for i in 0..3 {
                let h = 0.02 * point[i];
                let (mut up, mut down) = (point, point);
                up[i] += h;
                down[i] -= h;
                let (up, down) = (render(up).image, render(down).image);
                let difference: Vec<f64> =
                    pixels(&up).zip(pixels(&down)).map(|(u, d)| (u - d) / (2.0 * h)).collect();
                if model == Model::BeerLambert && i == 2 {
                    assert!(difference.iter().all(|d| *d == 0.0));
                    continue;
                }
                // Step squared over six times the third derivative, and f32 rounding over the step.
                let error = relative_l2(pixels(&gradient[i]), difference);
                assert!(error < 1e-3, "{model}, parameter {i}: {error}");
            }
        }
    }
}

#[test]
fn zero_scattering_leaves_the_image_sharp() {
    let radiance = texture(16, 16);
    let geometry = Geometry::planar(16, 16, 0.1, 2.0).unwrap();
    let phase = Gaussian::new(0.004).unwrap();
    let target = target(&radiance, &geometry, Border::Zero);
    for model in Model::ALL {
        let optics = Optics { model, medium: Medium::new(0.0, 0.3, phase.into()).unwrap() };
        let want = pixels(&radiance).map(|v| v * (-0.6_f64).exp());
        assert!(relative_l2(fast(&target, &optics), want) < 1e-6, "{model}");
    }
}

#[test]
fn a_uniform_mirrored_plane_is_only_scaled_by_the_total_transmission() {
    let radiance = Image::filled(24, 24, 0.8);
    let geometry = Geometry::planar(24, 24, 0.1, 2.0).unwrap();
    let phase = Gaussian::new(0.004).unwrap();
    for model in Model::ALL {
        let optics = optics(model, &phase);
        let total = optics.kernel(2.0).unwrap().mtf(0.0).value;
        let image = fast(&target(&radiance, &geometry, Border::Mirror), &optics);
        assert!(image.iter().all(|v| (v - 0.8 * total).abs() < 1e-6), "{model}");
    }
}

#[test]
fn a_kernel_narrower_than_a_pixel_conserves_energy() {
    let mut radiance = Image::filled(32, 32, 0.0);
    radiance.data[16 * 32 + 16] = 1.0;
    let phase = Gaussian::new(0.004).unwrap();
    for width_px in [0.01, 0.1, 0.5] {
        let geometry = Geometry::planar(32, 32, 2.0 * 0.004_f64.sqrt() / width_px, 2.0).unwrap();
        let optics = optics(Model::SmallAngle, &phase);
        let sum: f64 = fast(&target(&radiance, &geometry, Border::Zero), &optics).iter().sum();
        // 1e-5 of the scattered light may fall outside; f32 sums over a thousand pixels.
        assert!((sum - (-0.2_f64).exp()).abs() < 2e-5, "{width_px}: {sum}");
    }
}

#[test]
fn a_view_shows_its_part_of_the_whole_image() {
    let radiance = texture(32, 24);
    let geometry = sloping(32, 24, 0.05, 2.0, 0.2);
    let phase = Gaussian::new(0.004).unwrap();
    let optics = optics(Model::SmallAngle, &phase);
    let whole = target(&radiance, &geometry, Border::Zero);
    let view = View { x: 5, y: 3, width: 12, height: 10 };
    let all = CpuFilter::new(whole, &optics, 1.0).unwrap().render(&optics).unwrap();
    let part = CpuFilter::new(Target { view, ..whole }, &optics, 1.0).unwrap().render(&optics).unwrap();
    assert_eq!(all.crop(view), part);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

    #[test]
    fn filtering_is_linear_and_shift_equivariant(x in 4usize..20, y in 4usize..20, a in 0.1f32..3.0) {
        let geometry = Geometry::planar(40, 40, 0.1, 1.5).unwrap();
        let phase = Gaussian::new(0.002).unwrap();
        let optics = optics(Model::SmallAngle, &phase);
        let point = |x: usize, y: usize, v: f32| {
            let mut image = Image::filled(40, 40, 0.0);
            image.data[y * 40 + x] = v;
            fast(&target(&image, &geometry, Border::Zero), &optics)
        };
        let (origin, moved) = (point(4, 4, 1.0), point(x, y, a));
        for j in 0..20 {
            for i in 0..20 {
                let (want, got) = (origin[j * 40 + i] * f64::from(a), moved[(j + y - 4) * 40 + i + x - 4]);
                prop_assert!((want - got).abs() < 1e-6 * f64::from(a));
            }
        }
    }

    #[test]
    fn light_is_never_negative_and_more_scattering_never_sharpens(sigma_s in 0.1f64..2.0) {
        let radiance = texture(32, 32);
        let geometry = Geometry::planar(32, 32, 0.05, 2.0).unwrap();
        let phase = Gaussian::new(0.003).unwrap();
        let contrast = |sigma_s: f64| {
            let optics = Optics { model: Model::SmallAngle, medium: Medium::new(sigma_s, 0.0, phase.into()).unwrap() };
            let image = fast(&target(&radiance, &geometry, Border::Mirror), &optics);
            assert!(image.iter().all(|v| *v > 0.0));
            let mean = image.iter().sum::<f64>() / image.len() as f64;
            image.iter().map(|v| (v - mean).powi(2)).sum::<f64>()
        };
        prop_assert!(contrast(sigma_s * 1.1) < contrast(sigma_s));
    }
}
