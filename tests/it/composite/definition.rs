//! The fast path against the definition, and its derivatives against its differences.

use super::scenes::{B, EMPTY, SIZE, Scene, nested, optics};
use crate::common::{pixels, relative_l2};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Filter, Optics, composite_sum, per_depth};
use narrowbeam::geometry::Camera;
use narrowbeam::image::Border;
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;

/// Relative L2 distance of the fast path from the definition: 1e-4 of the scattered light by slices, 1e-5 by padding.
const FAST: f64 = 1e-4;

#[test]
fn the_fast_path_renders_what_is_defined() {
    let phase = Gaussian::new(B).unwrap();
    println!(
        "scene                              model                relative L2 at .3, 1, 5 px (wide-angle 2, once 5)"
    );
    for (i, (name, _)) in Scene::all(1.0).into_iter().enumerate() {
        for model in Model::ALL {
            let optics = optics(model, &phase);
            // The definition sums over all of a kernel's reach, and grazing light goes far: one scene shows it.
            let widest = if model == Model::WideAngle && i > 0 { 2.0 } else { 5.0 };
            let errors = [0.3, 1.0, widest].map(|width_px| {
                let scene = Scene::all(width_px).swap_remove(i).1;
                let definition = scene.definition(Filter::Composite, &optics);
                relative_l2(scene.fast(Filter::Composite, &optics), definition)
            });
            println!("{name:34} {:19} {}", model.name(), errors.map(|e| format!("{e:.1e}")).join("  "));
            assert!(errors.iter().all(|e| *e < FAST), "{name}, {model}: {errors:?}");
        }
    }
}

#[test]
fn the_comparison_rejects_other_occluders_slopes_and_layers() {
    let phase = Gaussian::new(B).unwrap();
    let optics = optics(Model::SmallAngle, &phase);
    let rejects = |index: usize, what: &str, wrong: &dyn Fn(&mut Scene)| {
        let scene = Scene::all(1.0).swap_remove(index).1;
        let mut other = scene.clone();
        wrong(&mut other);
        let right = scene.definition(Filter::Composite, &optics);
        let error = relative_l2(other.fast(Filter::Composite, &optics), right);
        println!("{what}: {error:.1e}");
        assert!(error > 5.0 * FAST, "{what}: {error}");
    };
    rejects(0, "without the occluder", &|scene| scene.relief.occluders.clear());
    rejects(0, "one row of the occluder open", &|scene| {
        scene.relief.occluders[0].opaque[..SIZE.0].fill(false)
    });
    rejects(1, "without the first of two occluders", &|scene| drop(scene.relief.occluders.remove(0)));
    rejects(4, "without slopes", &|scene| scene.relief.slopes[0] = None);
    rejects(3, "without the layer", &|scene| scene.behind[0].data.fill(0.0));
    rejects(4, "slopes the other way", &|scene| {
        let slopes = scene.relief.slopes[0].iter_mut().flatten();
        slopes.for_each(|slope| *slope = slope.map(|s| -s));
    });
}

#[test]
fn without_a_relief_the_definition_is_eq29() {
    let phase = Gaussian::new(B).unwrap();
    for (name, scene) in Scene::all(1.0) {
        let optics = optics(Model::NarrowBeam, &phase);
        let eq29 = per_depth::render(&scene.target(Filter::Eq29), &optics).unwrap();
        let error = relative_l2(scene.definition(Filter::Eq29, &optics), eq29);
        println!("{name}: {error:.1e}");
        // 1e-8 of the light goes round either lattice.
        assert!(error < 1e-7, "{name}: {error}");
    }
}

#[test]
fn image_derivatives_match_central_differences() {
    let pitch = 0.05;
    let depth = |x: usize, y: usize| nested(x, y) + 0.02 * x as f64;
    let scene = Scene::new(SIZE, pitch, depth).before(|x, y| if depth(x, y) < 1.5 { 3.5 } else { EMPTY });
    assert_eq!(scene.relief.occluders.len(), 2);
    for model in Model::ALL {
        let point = [0.8, 0.1, 0.004];
        let phase = Gaussian::new(point[2]).unwrap();
        let target = scene.target(Filter::Composite);
        let filter = CpuFilter::new(target, &optics(model, &phase), 1.5).unwrap();
        let render = |p: [f64; 3]| {
            let phase = Gaussian::new(p[2]).unwrap();
            let optics = Optics { model, medium: Medium::new(p[0], p[1], phase.into()).unwrap() };
            filter.render_with_gradient(&optics).unwrap()
        };
        let gradient = render(point).gradient.unwrap();
        let errors: Vec<f64> = (0..if model.spreads() { 3 } else { 2 })
            .map(|i| {
                let h = 0.02 * point[i];
                let (mut up, mut down) = (point, point);
                up[i] += h;
                down[i] -= h;
                let (up, down) = (render(up).image, render(down).image);
                let difference = pixels(&up).zip(pixels(&down)).map(|(u, d)| (u - d) / (2.0 * h));
                relative_l2(pixels(&gradient[i]), difference)
            })
            .collect();
        println!("{:19} {}", model.name(), errors.iter().map(|e| format!("{e:.1e}  ")).collect::<String>());
        // Step squared over six times the third derivative, and f32 rounding over the step.
        assert!(errors.iter().all(|e| *e < 1e-3), "{model}: {errors:?}");
    }
}

#[test]
fn what_is_not_defined_is_refused_by_name() {
    let phase = Gaussian::new(B).unwrap();
    let optics = optics(Model::SmallAngle, &phase);
    let refused = |change: &dyn Fn(&mut Scene), word: &str| {
        let mut scene = Scene::new(SIZE, 0.05, nested);
        change(&mut scene);
        let error = composite_sum::render(&scene.target(Filter::Composite), &optics).unwrap_err().to_string();
        assert!(error.contains(word), "{word} is not in: {error}");
    };
    refused(&|scene| scene.geometry.camera = Camera::perspective(30.0).unwrap(), "perspective");
    refused(&|scene| scene.border = Border::Mirror, "mirrored border");
    refused(&|scene| *scene = Scene::new((65, 4), 0.05, nested), "image side, px = 65");
}
