//! Objects of several layers: depth edges, what lies behind them, and empty pixels.

use super::setup::{Setup, assert_agree, columns};
use glam::{DVec3, Vec3};
use narrowbeam::geometry::{Camera, Field};
use narrowbeam::image::{Border, Image};
use narrowbeam::medium::Medium;
use narrowbeam::trace::{Path, Stream, free_path, trace_image};

const EMPTY: f32 = 0.0;

impl Setup {
    /// The setup with one more layer.
    fn before(mut self, depth: Image, radiance: Image) -> Self {
        self.geometry.behind.push(Field::Map(depth));
        self.behind.push(radiance);
        self
    }
}

/// Light from two half planes, the near one (x < 0) at z = 1 and the far one (x > 0) at z = 2.5, that reaches the
/// camera from (`x`, 0): a tracer with analytic layers. The far plane goes on behind the near one with the radiance
/// `hidden`. Returns mean and variance of the mean.
fn two_layers(x: [f64; 2], hidden: f64, medium: Medium, paths: u64) -> (f64, f64) {
    let key = Stream::key(77);
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..paths {
        let mut stream = Stream::new(key, i);
        let start = x[0] + (x[1] - x[0]) * stream.uniform_f64();
        let mut path = Path::new(Vec3::new(start as f32, 0.0, 0.0), Vec3::Z);
        let light = loop {
            let step = free_path(medium.sigma_s() as f32, &mut stream);
            let (p, d) = (path.position, path.direction);
            let crosses = |z: f32| (p.z < z) != (p.z + step * d.z < z);
            let x_at = |z: f32| p.x + (z - p.z) / d.z * d.x;
            let picked = |z: f32, radiance: f64| {
                let length = path.length + (z - p.z) / d.z;
                radiance * (-medium.sigma_a() * f64::from(length)).exp()
            };
            if crosses(1.0) && x_at(1.0) < 0.0 {
                break if d.z > 0.0 { picked(1.0, 1.0) } else { 0.0 };
            }
            if crosses(2.5) {
                break picked(2.5, if x_at(2.5) > 0.0 { 3.0 } else { hidden });
            }
            path.advance(step);
            if path.position.z < 0.0 {
                break 0.0;
            }
            path.scatter(medium.phase(), &mut stream);
        };
        sum += light;
        squares += light * light;
    }
    let n = paths as f64;
    (sum / n, (squares / n - (sum / n) * (sum / n)) / n)
}

/// A near half plane (left, radiance 1) at z = 1 and a far one (right, radiance 3) at z = 2.5.
fn half_planes(spread_angle_deg: f64) -> Setup {
    let (width, height) = (24, 8);
    let mut setup = Setup::plane(width, height, |x, _| if x < 12 { 1.0 } else { 3.0 });
    setup.geometry.camera = Camera::orthographic(0.05).unwrap();
    setup.geometry.depth = Field::Map(Image::from_fn(width, height, |x, _| if x < 12 { 1.0 } else { 2.5 }));
    let b = 0.25 * spread_angle_deg.to_radians().powi(2);
    setup.medium = Medium::gaussian(1.2, 0.05, b).unwrap();
    Setup { samples: 4000, ..setup }
}

#[test]
fn a_near_half_plane_hides_what_lies_behind_it_but_for_paths_around_its_edge() {
    for spread_angle_deg in [10.0, 30.0] {
        let bare = || half_planes(spread_angle_deg);
        let depth = Image::from_fn(24, 8, |x, _| if x < 12 { 2.5 } else { EMPTY });
        let backed = bare().before(depth, Image::filled(24, 8, 6.0));
        for (hidden, setup) in [(0.0, bare()), (6.0, backed)] {
            let traced = columns(&setup.trace());
            let compared: Vec<_> = (0..24)
                .step_by(2)
                .map(|x| {
                    let left = 0.05 * (x as f64 - 12.0);
                    let seen = [left, left + 0.05];
                    let (truth, noise) = two_layers(seen, hidden, setup.medium, 60_000);
                    (traced[x].0, traced[x].1 + noise, truth)
                })
                .collect();
            assert_agree(&format!("two half planes, {spread_angle_deg}°, hidden {hidden}"), &compared);
        }
    }
}

/// Distances along the rays to the plane through z = 2.5 on the axis, tilted by 22 degrees.
fn tilted(camera: Camera, size: (usize, usize)) -> Image {
    let normal = DVec3::new(0.4, 0.1, 1.0);
    Image::from_fn(size.0, size.1, |x, y| {
        let (start, d) = camera.ray(x as f64 + 0.5, y as f64 + 0.5, size);
        ((2.5 - normal.dot(start)) / normal.dot(d)) as f32
    })
}

#[test]
fn no_light_is_lost_where_layers_close_every_gap() {
    // Without absorption, with radiance 1 everywhere and no chance to turn back at 10 degrees, each path must end on
    // some layer, so that every pixel is 1; where a layer is missing, pixels on both sides of the edge are darker.
    let size = (32, 24);
    let disc = |x: usize, y: usize| (x as f64 - 13.0).hypot(y as f64 - 11.0) < 7.0;
    let one = Image::filled(size.0, size.1, 1.0);
    for camera in [Camera::orthographic(0.05).unwrap(), Camera::perspective(35.0).unwrap()] {
        let wall = tilted(camera, size);
        let pick = |f: &dyn Fn(usize, usize) -> f32| Image::from_fn(size.0, size.1, f);
        let disc_before_wall = pick(&|x, y| if disc(x, y) { 1.0 } else { wall.at(x, y) });
        let disc_alone = pick(&|x, y| if disc(x, y) { 1.0 } else { EMPTY });
        let hidden_wall = pick(&|x, y| if disc(x, y) { wall.at(x, y) } else { EMPTY });
        let scene = |depth: &Image| {
            let mut setup =
                Setup { samples: 100, border: Border::Mirror, ..Setup::plane(32, 24, |_, _| 1.0) };
            setup.geometry.camera = camera;
            setup.geometry.depth = Field::Map(depth.clone());
            setup.medium = Medium::new(1.2, 0.0, *setup.medium.phase()).unwrap();
            setup
        };
        for (name, front, behind) in [
            ("the wall repeated", &disc_before_wall, &wall),
            ("the hidden part alone", &disc_before_wall, &hidden_wall),
            ("seen through empty pixels", &disc_alone, &wall),
        ] {
            let image = scene(front).before(behind.clone(), one.clone()).trace().mean;
            let worst = image.data.iter().map(|v| (v - 1.0).abs()).fold(0.0, f32::max);
            println!("{camera:?}, {name}: worst {worst}");
            assert!(worst < 1e-6, "{camera:?}, {name}: {worst}");
        }
        let bare = scene(&disc_before_wall).trace().mean;
        let darkest = |inside: bool| {
            let side = (0..size.0).filter(|&x| disc(x, 11) == inside).map(|x| bare.at(x, 11));
            side.fold(1.0, f32::min)
        };
        println!(
            "{camera:?}, without layer: darkest {} on the disc, {} beside",
            darkest(true),
            darkest(false)
        );
        assert!(darkest(true) < 0.99 && darkest(false) < 0.95);
    }
}

#[test]
fn a_clear_medium_shows_the_first_layer_there_is() {
    let (width, height) = (12, 4);
    let third = |from: usize, to: usize, depth: f32| {
        Image::from_fn(width, height, |x, _| if (from..to).contains(&x) { depth } else { EMPTY })
    };
    let light = |base: usize| Image::from_fn(width, height, |x, y| (base + 3 * x + y) as f32);
    let mut setup = Setup::plane(width, height, |x, y| (100 + 3 * x + y) as f32);
    setup.geometry.depth = Field::Map(third(0, 3, 1.0));
    let mut setup = setup.before(third(0, 6, 1.0), light(200)).before(third(2, 9, 3.0), light(300));
    setup.medium = Medium::new(0.0, 0.0, *setup.medium.phase()).unwrap();
    let truth = Image::from_fn(width, height, |x, y| {
        let base = [100, 200, 300, 0][x / 3];
        if base == 0 { 0.0 } else { (base + 3 * x + y) as f32 }
    });
    assert_eq!(setup.trace().mean, truth);
}

#[test]
fn a_layer_in_which_there_is_nothing_changes_nothing() {
    let traced = half_planes(10.0).trace();
    let nothing = Image::filled(24, 8, f32::INFINITY);
    assert_eq!(half_planes(10.0).before(nothing, Image::filled(24, 8, 1.0)).trace(), traced);
}

#[test]
fn layers_that_make_no_sense_are_refused_by_name() {
    let layer = |depth: f32| half_planes(10.0).before(Image::filled(24, 8, depth), Image::filled(24, 8, 1.0));
    let refused = |setup: &Setup, words: &[&str]| {
        let message = trace_image(&setup.config(), &|_| ()).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{words:?} are not all in: {message}");
    };
    refused(&layer(1.5), &["[[object.layer]] 1: depth at pixel (12, 0) = 1.5"]);
    let mut setup = layer(3.0);
    setup.behind[0] = Image::filled(24, 7, 1.0);
    refused(&setup, &["radiance image", "the size of the object image"]);
    setup.behind.clear();
    refused(&setup, &["further layers = 0"]);
}
