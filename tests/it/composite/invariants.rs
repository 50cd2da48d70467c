//! What the composite filter must do whatever the kernel.

use super::scenes::{B, EMPTY, SIZE, Scene, optics};
use crate::common::{pixels, relative_l2};
use narrowbeam::filter::{Backend, Filter, Optics, hidden_share};
use narrowbeam::geometry::Field;
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::relief::Occluder;
use narrowbeam::spread::Model;

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.map(f64::abs).fold(0.0, f64::max)
}

fn minus(a: Vec<f64>, b: Vec<f64>) -> Vec<f64> {
    a.into_iter().zip(b).map(|(a, b)| a - b).collect()
}

/// The scene's hidden share.
fn hidden(scene: &Scene, optics: &Optics) -> Vec<f64> {
    pixels(&hidden_share(&scene.target(Filter::Composite), optics, Backend::Cpu).unwrap()).collect()
}

#[test]
fn where_nothing_covers_and_nothing_slopes_it_is_eq29() {
    let phase = Gaussian::new(B).unwrap();
    // A step of less than 5 % of the path is left to eq. 29.
    let scenes = [
        ("plane", Scene::new(SIZE, 0.02, |_, _| 2.5)),
        ("low step", Scene::new(SIZE, 0.02, |x, _| if x < 14 { 2.5 } else { 2.6 })),
    ];
    for (name, scene) in scenes {
        assert!(scene.relief.is_flat(), "{name}");
        for model in Model::ALL {
            let optics = optics(model, &phase);
            let [composite, eq29] = [Filter::Composite, Filter::Eq29].map(|f| scene.fast(f, &optics));
            assert_eq!(composite, eq29, "{name}, {model}");
        }
    }
}

#[test]
fn a_tilted_plane_hides_nothing_and_adds_the_slope_term_alone() {
    let phase = Gaussian::new(B).unwrap();
    let scene = Scene::all(1.0).swap_remove(4).1;
    assert!(scene.relief.occluders.is_empty());
    println!("model                slope term   error   (relative L2 of the image)");
    for model in Model::ALL {
        let optics = optics(model, &phase);
        assert!(hidden(&scene, &optics).iter().all(|&share| share == 0.0));
        let image = scene.definition(Filter::Eq29, &optics);
        let whole = image.iter().map(|v| v * v).sum::<f64>().sqrt();
        let length = |v: &[f64]| v.iter().map(|v| v * v).sum::<f64>().sqrt() / whole;
        let [fast, definition] = [Scene::fast, Scene::definition]
            .map(|by| minus(by(&scene, Filter::Composite, &optics), by(&scene, Filter::Eq29, &optics)));
        let (term, error) = (length(&definition), length(&minus(fast, definition)));
        println!("{:19}  {term:10.1e}   {error:.1e}", model.name());
        // The slices' 1e-4, twice.
        assert!(error < 2e-4, "{model}: {error}");
        assert!(if model.spreads() { term > 10.0 * error } else { term == 0.0 }, "{model}: {term}");
    }
}

#[test]
fn an_occluder_that_covers_nothing_changes_nothing() {
    let phase = Gaussian::new(B).unwrap();
    let pitch = 0.05;
    for (name, scene) in
        [("flat", Scene::new(SIZE, pitch, |_, _| 2.5)), ("tilted", Scene::all(1.0).swap_remove(4).1)]
    {
        let mut occluded = scene.clone();
        let nothing = || vec![false; SIZE.0 * SIZE.1];
        occluded.relief.occluders = [0.5, 0.9]
            .map(|depth| Occluder { depth, z: depth, opaque: nothing(), hidden: Field::Uniform(0.0) })
            .to_vec();
        let mut specked = occluded.clone();
        specked.relief.occluders[1].opaque[8 * SIZE.0 + 12] = true;
        for model in Model::ALL {
            let optics = optics(model, &phase);
            let [open, speck, without] =
                [&occluded, &specked, &scene].map(|s| s.fast(Filter::Composite, &optics));
            let error = relative_l2(open, without.clone());
            println!("{name}, {model}: {error:.1e}");
            assert!(error < 1e-6, "{name}, {model}: {error}");
            assert!(relative_l2(speck, without) > 1e-3, "{name}, {model}: one opaque pixel must count");
        }
    }
}

fn disc(x: usize, y: usize, radius: f64) -> bool {
    (x as f64 - 12.0).hypot(y as f64 - 8.0) < radius
}

/// What may be missing of a light of 1: these scenes have two depths and mirrored borders, so that only f32 errs, and
/// the aliases' tables (1e-6).
const LIGHT: f64 = 2e-6;

#[test]
fn no_light_is_lost_where_a_layer_closes_the_gap() {
    let phase = Gaussian::new(0.004).unwrap();
    let bare = || Scene::new(SIZE, 0.05, |x, y| if disc(x, y, 6.0) { 1.0 } else { 2.5 }).white();
    let closed = bare().before(|x, y| if disc(x, y, 6.0) { 2.5 } else { EMPTY }).white();
    for model in Model::ALL {
        let optics = Optics { model, medium: Medium::new(1.2, 0.0, phase.into()).unwrap() };
        // All light of single scattering is T (1 + tau), not 1, and wide angles turn some back.
        if matches!(model, Model::BeerLambert | Model::SingleScatter | Model::WideAngle) {
            continue;
        }
        let worst = largest(closed.fast(Filter::Composite, &optics).iter().map(|v| v - 1.0));
        let dark = bare().fast(Filter::Composite, &optics);
        let share = hidden(&bare(), &optics);
        let most = share.iter().copied().fold(0.0, f64::max);
        let told = largest(dark.iter().zip(&share).map(|(v, share)| 1.0 - v - share));
        println!(
            "{:19} with the layer off by {worst:.1e}; without, dark by up to {most:.3}, told to {told:.1e}",
            model.name()
        );
        assert!(worst < LIGHT && told < LIGHT && most > 0.05, "{model}: {worst} {told} {most}");
    }
}

#[test]
fn no_light_is_gained_where_objects_stand_one_behind_another() {
    // All paths end on radiance 1 at most. An occluder far behind a small object would blur its shadow, not its light.
    let phase = Gaussian::new(0.004).unwrap();
    let optics = Optics { model: Model::SmallAngle, medium: Medium::new(1.2, 0.0, phase.into()).unwrap() };
    let plate = |x: usize, _: usize| x < 18;
    for depth in [2.0, 2.2, 2.4] {
        let front = |x: usize, y: usize| match (disc(x, y, 3.0), plate(x, y)) {
            (true, _) => 1.0,
            (_, true) => depth,
            _ => 3.5,
        };
        let bare = Scene::new(SIZE, 0.05, front).white();
        let plane =
            || Scene::new(SIZE, 0.05, front).before(|x, y| if front(x, y) < 3.5 { 3.5 } else { EMPTY });
        let behind_disc = |x: usize, y: usize| if disc(x, y, 3.0) { depth } else { EMPTY };
        let both = Scene::new(SIZE, 0.05, front)
            .before(behind_disc)
            .before(|x, y| if front(x, y) < 3.5 { 3.5 } else { EMPTY });
        for (name, scene) in [("bare", bare), ("plane", plane().white()), ("plate and plane", both.white())] {
            let light = scene.fast(Filter::Composite, &optics);
            let (low, high) = light.iter().fold((f64::MAX, 0.0_f64), |(l, h), &v| (l.min(v), h.max(v)));
            println!("plate at {depth}, {name}: light {low:.4} to {high:.4}");
            assert!(high < 1.0 + LIGHT, "plate at {depth}, {name}: {high}");
        }
    }
}

#[test]
fn direct_light_alone_comes_from_the_nearest_surface() {
    let phase = Gaussian::new(0.004).unwrap();
    let optics = Optics { model: Model::BeerLambert, medium: Medium::new(1.0, 0.2, phase.into()).unwrap() };
    let front = |x: usize, y: usize| match (disc(x, y, 3.0), x < 6) {
        (true, _) => 1.0,
        (_, true) => 2.0,
        _ => 3.5,
    };
    let scene =
        Scene::new(SIZE, 0.05, front).before(|x, y| if front(x, y) < 3.5 { 3.5 } else { EMPTY }).white();
    assert_eq!(scene.relief.occluders.len(), 2);
    for (i, light) in scene.fast(Filter::Composite, &optics).into_iter().enumerate() {
        let want = (-1.2 * front(i % SIZE.0, i / SIZE.0)).exp();
        assert!((light / want - 1.0).abs() < 1e-6, "pixel {i}: {light}, not {want}");
    }
}
