//! From depth maps to screens.

use crate::scenes::{EMPTY, SIZE, Scene, nested};

fn opaque(scene: &Scene) -> Vec<Vec<bool>> {
    scene.relief.screens.iter().map(|screen| screen.opaque.clone()).collect()
}

fn pixels_where(f: impl Fn(usize, usize) -> bool) -> Vec<bool> {
    (0..SIZE.0 * SIZE.1).map(|i| f(i % SIZE.0, i / SIZE.0)).collect()
}

#[test]
fn each_object_that_stands_before_another_is_a_screen() {
    let scene = Scene::new(SIZE, 0.02, nested);
    let depths: Vec<f64> = scene.relief.screens.iter().map(|s| s.depth).collect();
    assert_eq!(depths, [1.0, f64::from(2.2_f32)]);
    assert_eq!(opaque(&scene)[0], pixels_where(|x, y| nested(x, y) == 1.0));
}

#[test]
fn an_object_before_nothing_covers_nothing_unless_a_layer_lies_behind() {
    let disc = |x: usize, y: usize| (x as f64 - 13.0).hypot(y as f64 - 9.0) < 6.0;
    let alone = Scene::new(SIZE, 0.02, |x, y| if disc(x, y) { 1.0 } else { EMPTY });
    assert!(alone.relief.screens.is_empty());
    let before = alone.before(|_, _| 2.5);
    assert_eq!(opaque(&before), [pixels_where(disc)]);
}

#[test]
fn a_slope_however_steep_below_an_edge_is_no_screen() {
    for slope in [0.1, 1.0, 3.9] {
        let scene = Scene::new(SIZE, 0.02, |x, _| 1.0 + 0.02 * slope * x as f64);
        assert!(scene.relief.screens.is_empty(), "{slope}");
    }
}
