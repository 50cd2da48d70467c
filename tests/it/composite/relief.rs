//! From depth maps to occluders.

use super::scenes::{EMPTY, SIZE, Scene, nested, optics};
use crate::common::{relative_l2, with_noise};
use narrowbeam::filter::Filter;
use narrowbeam::geometry::Field;
use narrowbeam::image::Image;
use narrowbeam::phase::Gaussian;
use narrowbeam::relief::Relief;
use narrowbeam::spread::Model;

fn opaque(scene: &Scene) -> Vec<Vec<bool>> {
    scene.relief.occluders.iter().map(|occluder| occluder.opaque.clone()).collect()
}

fn pixels_where(f: impl Fn(usize, usize) -> bool) -> Vec<bool> {
    (0..SIZE.0 * SIZE.1).map(|i| f(i % SIZE.0, i / SIZE.0)).collect()
}

#[test]
fn each_object_that_stands_before_another_is_a_occluder() {
    let scene = Scene::new(SIZE, 0.02, nested);
    let depths: Vec<f64> = scene.relief.occluders.iter().map(|s| s.depth).collect();
    assert_eq!(depths, [1.0, f64::from(2.2_f32)]);
    assert_eq!(opaque(&scene)[0], pixels_where(|x, y| nested(x, y) == 1.0));
    // Whatever is supposed behind the rod, all of the plate that is seen covers the plane.
    let plate = pixels_where(|x, y| nested(x, y) == 2.2);
    let covers = &opaque(&scene)[1];
    assert!(plate.contains(&true) && plate.iter().zip(covers).all(|(plate, covers)| !plate || *covers));
}

#[test]
fn an_object_before_nothing_covers_nothing_unless_a_layer_lies_behind() {
    let disc = |x: usize, y: usize| (x as f64 - 13.0).hypot(y as f64 - 9.0) < 6.0;
    let alone = Scene::new(SIZE, 0.02, |x, y| if disc(x, y) { 1.0 } else { EMPTY });
    assert!(alone.relief.occluders.is_empty());
    let before = alone.before(|_, _| 2.5);
    assert_eq!(opaque(&before), [pixels_where(disc)]);
}

#[test]
fn a_slope_however_steep_below_an_edge_is_no_occluder() {
    for slope in [0.1, 1.0, 3.9] {
        let scene = Scene::new(SIZE, 0.02, |x, _| 1.0 + 0.02 * slope * x as f64);
        assert!(scene.relief.occluders.is_empty(), "{slope}");
    }
}

#[test]
fn depth_noise_moves_no_edge_and_changes_the_image_little() {
    let phase = Gaussian::new(0.004).unwrap();
    let optics = optics(Model::SmallAngle, &phase);
    let clean = Scene::new(SIZE, 0.05, |x, _| if x < 14 { 1.0 } else { 2.5 });
    let near = vec![pixels_where(|x, _| x < 14)];
    assert_eq!(opaque(&clean), near);
    let image = clean.fast(Filter::Composite, &optics);
    for share in [0.005, 0.01] {
        for seed in 0..4 {
            let mut noisy = clean.clone();
            let Field::Map(depth) = &clean.geometry.depth else { unreachable!("the depth is a map") };
            let factor = with_noise(&Image::filled(SIZE.0, SIZE.1, 1.0), share, seed);
            let mut map = depth.clone();
            map.data.iter_mut().zip(factor.data).for_each(|(d, f)| *d *= f);
            noisy.geometry.depth = Field::Map(map);
            noisy.relief = Relief::new(&noisy.geometry);
            assert_eq!(opaque(&noisy), near, "noise {share}, seed {seed}");
            let error = relative_l2(noisy.fast(Filter::Composite, &optics), image.clone());
            // Direct light alone changes by sigma_t times the change of depth, the whole image by less.
            let bound = optics.medium.sigma_t() * 2.5 * share;
            println!(
                "noise {:.1} %: the image changes by {:.2} %, bound {:.2} %",
                100.0 * share,
                100.0 * error,
                100.0 * bound
            );
            assert!(error < bound && error > 0.05 * bound, "noise {share}, seed {seed}: {error}");
        }
    }
}
