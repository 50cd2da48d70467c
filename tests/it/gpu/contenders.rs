//! The contenders of `benches/contenders` give the image that they are timed on.

use super::contenders::{Method, Scene, errors};
use super::gpu;
use narrowbeam::filter::Optics;
use narrowbeam::filter::gpu::GpuFilter;
use narrowbeam::phase::{Gaussian, PhaseFunction};

/// A slope whose kernel is so wide that the pyramid has levels.
fn scene() -> Scene {
    Scene::new(48, 4.0, true)
}

/// Each contender with its largest error over the grid in docs/contenders.md, rounded up.
const STATED: [(Method, f64); 4] = [
    (Method::Fft(None), 1e-4),
    (Method::Gather(1e-3), 3e-4),
    (Method::Gaussians(1.6), 6e-4),
    (Method::Pyramid(1.6), 6e-4),
];

#[test]
fn contenders_are_within_their_stated_errors_and_a_wrong_kernel_is_not() {
    let scene = scene();
    let right = scene.optics();
    let reference = scene.reference().unwrap();
    let [rounding, _] = errors(&reference, &scene.f64_image().unwrap());
    assert!(rounding < 1e-6, "the reference is {rounding:.1e} from the f64 implementation");
    let wider = Gaussian::new(1.02 * right.medium.phase().planar_width().powi(2)).unwrap();
    let wrong = Optics { medium: right.medium.with_phase(wider.into()), ..right };
    for (method, stated) in STATED {
        let of = |optics: &Optics| {
            let measured = method.measure(gpu(), &scene, optics, 1).unwrap();
            errors(&measured.image, &reference)
        };
        let ([l2, energy], [wrong_l2, _]) = (of(&right), of(&wrong));
        println!("{method}: {l2:.1e}, energy {energy:.1e}; B 2 % too large: {wrong_l2:.1e}");
        assert!(l2 < stated && energy.abs() < stated, "{method}: {l2:.1e}, energy {energy:.1e}");
        assert!(wrong_l2 > stated, "{method}: B 2 % too large makes {wrong_l2:.1e} only");
    }
}

#[test]
fn the_count_is_of_the_transforms_that_the_program_makes() {
    for scene in [scene(), Scene::new(48, 0.5, false)] {
        let filter = GpuFilter::new(gpu(), scene.target(), &scene.optics(), 1.0).unwrap();
        let (_, _, [side, _]) = filter.transforms();
        assert_eq!(scene.plan(), (filter.slice_count(), side));
        let work = Method::Fft(None).work(&scene)[1];
        assert!(work.flops > 5.0 * (side * side) as f64 && work.seconds() > 0.0);
    }
}
