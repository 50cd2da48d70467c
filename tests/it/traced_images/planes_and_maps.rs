//! One plane or one depth map, against what is known exactly and against the radial tallies.

use super::setup::{Setup, assert_agree, assert_same_images, columns, mean};
use glam::{DVec3, Vec3};
use narrowbeam::geometry::{Camera, Field};
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Family, PhaseFunction};
use narrowbeam::trace::{
    Path, RadialConfig, Stream, TracedImage, free_path, log_spaced, trace_image, trace_radial,
};
use std::f64::consts::PI;

#[test]
fn a_uniform_plane_is_as_bright_as_all_light_of_the_radial_tally() {
    let setup = Setup { samples: 256, ..Setup::plane(24, 24, |_, _| 1.0) };
    let radial = RadialConfig {
        medium: setup.medium,
        depths: vec![1.0],
        edges: log_spaced(1e-3, 10.0, 10),
        paths: 1_000_000,
        seed: 2,
    };
    let profile = &trace_radial(&radial, &|_| ()).unwrap()[0];
    let light = profile.scattered();
    let truth = setup.medium.transmittance(1.0) + light.value;
    for border in [Border::Clamp, Border::Mirror] {
        let (value, error) = mean(&Setup { border, ..Setup::plane(24, 24, |_, _| 1.0) }.trace());
        let z = (value - truth) / error.hypot(light.std_error);
        assert!(z.abs() < 4.0, "{border:?}: {value} ± {error}, {truth}");
    }
    let (dark_border, _) = mean(&Setup { border: Border::Zero, ..setup }.trace());
    assert!(dark_border < truth - 0.05, "light from outside is missing: {dark_border}");
}

/// Light of a half plane that begins `x` away (behind us if negative), from the radial tally: a share
/// acos(x/r)/pi of the circle of radius r lies on it.
fn edge_spread(x: f64, edges: &[f64], rings: &[f64]) -> f64 {
    let share = |r: f64| (x / r).clamp(-1.0, 1.0).acos() / PI;
    let mut inner = 0.0_f64;
    let mut light = 0.0;
    for (&outer, ring) in edges.iter().zip(rings) {
        // Mean over the ring's area.
        let parts = (0..8)
            .map(|i| (inner.powi(2) + (outer.powi(2) - inner.powi(2)) * (f64::from(i) + 0.5) / 8.0).sqrt());
        light += ring * parts.map(share).sum::<f64>() / 8.0;
        inner = outer;
    }
    light
}

#[test]
fn the_image_of_an_edge_is_the_edge_spread_of_the_radial_tally() {
    let setup = Setup { samples: 400, ..Setup::plane(48, 32, |x, _| if x < 24 { 0.0 } else { 1.0 }) };
    let edges = log_spaced(1e-3, 10.0, 400);
    let medium = setup.medium;
    let radial = RadialConfig { medium, depths: vec![1.0], edges: edges.clone(), paths: 8_000_000, seed: 3 };
    let profile = &trace_radial(&radial, &|_| ()).unwrap()[0];
    let within: Vec<f64> = (0..edges.len()).map(|i| profile.encircled_energy(i).value).collect();
    let rings: Vec<f64> =
        (0..edges.len()).map(|i| within[i] - if i > 0 { within[i - 1] } else { 0.0 }).collect();
    let traced = columns(&setup.trace());
    let truth = |column: usize| {
        let direct = if column < 24 { 0.0 } else { medium.transmittance(1.0) };
        let positions = (0..16).map(|i| 0.02 * (24.0 - (column as f64 + (f64::from(i) + 0.5) / 16.0)));
        direct + positions.map(|x| edge_spread(x, &edges, &rings)).sum::<f64>() / 16.0
    };
    // The tally's own noise, at most a quarter of its paths' variance, is shared by all columns.
    let shared = 0.25 / 8e6;
    let compared: Vec<_> = traced
        .iter()
        .enumerate()
        .map(|(x, (value, variance))| (*value, variance + shared, truth(x)))
        .collect();
    assert_agree("edge", &compared);
    // The comparison can fail: a medium 6 % clearer is told apart.
    let clearer = Setup { medium: Medium::new(1.88, 0.1, *setup.medium.phase()).unwrap(), ..setup };
    let chi2: f64 = columns(&clearer.trace())
        .iter()
        .enumerate()
        .map(|(x, (value, variance))| (value - truth(x)).powi(2) / (variance + shared))
        .sum();
    assert!(chi2 > 48.0 + 10.0 * 96.0_f64.sqrt(), "{chi2}");
}

/// Where pixel (x, y) of an image of n x n pixels goes.
type Turn = fn(usize, usize, usize) -> (usize, usize);

#[test]
fn mirrored_and_turned_scenes_have_mirrored_and_turned_images() {
    let n = 16;
    let pattern = |x: usize, y: usize| ((x * 7 + y * 3 + x * y) % 11) as f32 / 10.0;
    let slope = |x: usize, y: usize| 0.9 + 0.3 * x as f32 / n as f32 + 0.1 * y as f32 / n as f32;
    let scene = |seed, turn: Turn| {
        let mut setup = Setup::plane(n, n, |x, y| {
            let (x, y) = turn(x, y, n);
            pattern(x, y)
        });
        setup.geometry.depth = Field::Map(Image::from_fn(n, n, |x, y| {
            let (x, y) = turn(x, y, n);
            slope(x, y)
        }));
        Setup { seed, samples: 200, ..setup }.trace()
    };
    let straight = scene(1, |x, y, _| (x, y));
    let turns: [(&str, Turn); 2] = [("mirror", |x, y, n| (n - 1 - x, y)), ("turn", |x, y, n| (y, n - 1 - x))];
    for (name, turn) in turns {
        let turned = scene(2, turn);
        let back = |image: &Image| {
            let mut out = image.clone();
            for (i, v) in image.data.iter().enumerate() {
                let (x, y) = turn(i % n, i / n, n);
                out.data[y * n + x] = *v;
            }
            out
        };
        let back =
            TracedImage { mean: back(&turned.mean), variance: back(&turned.variance), paths: turned.paths };
        assert_same_images(name, &straight, &back);
    }
}

#[test]
fn a_depth_map_of_one_value_gives_the_image_of_the_plane() {
    let pattern = |x: usize, y: usize| ((x * 5 + y * 3) % 7) as f32;
    for border in [Border::Zero, Border::Clamp, Border::Mirror] {
        let plane = Setup { border, ..Setup::plane(16, 12, pattern) };
        let mut map = Setup { border, ..Setup::plane(16, 12, pattern) };
        map.geometry.depth = Field::Map(Image::filled(16, 12, 1.0));
        map.geometry.surface = Field::Map(Image::filled(16, 12, 0.0));
        let (plane, map) = (plane.trace(), map.trace());
        // The same streams: the same paths but for rounding, which may move a hit to the next pixel.
        let far = plane.mean.data.iter().zip(&map.mean.data).filter(|(a, b)| (*a - *b).abs() > 1e-5).count();
        assert!(far <= 2, "{border:?}: {far} pixels differ");
    }
}

#[test]
fn a_distant_perspective_camera_sees_what_parallel_rays_see() {
    let pattern = |x: usize, y: usize| ((x * 5 + y * 3) % 7) as f32;
    let parallel = Setup { samples: 400, ..Setup::plane(16, 16, pattern) };
    let distance = 200.0;
    let mut central = Setup { samples: 400, seed: 2, ..Setup::plane(16, 16, pattern) };
    let fov_x = 2.0 * (8.0 * 0.02 / (distance + 1.0_f64)).atan();
    central.geometry.camera = Camera::perspective(fov_x.to_degrees()).unwrap();
    central.geometry.depth = Field::Uniform(distance + 1.0);
    central.geometry.surface = Field::Uniform(distance);
    assert_same_images("distant camera", &parallel.trace(), &central.trace());
}

#[test]
fn a_clear_medium_shows_a_tilted_object_sharp() {
    let mut setup = Setup::plane(20, 10, |x, y| (x * 3 + y) as f32);
    setup.geometry.depth = Field::Map(Image::from_fn(20, 10, |x, _| 1.0 + 0.015 * x as f32));
    setup.medium = Medium::new(0.0, 0.0, *setup.medium.phase()).unwrap();
    let image = setup.trace();
    assert_eq!(image.mean, setup.radiance);
    assert!(image.variance.data.iter().all(|&v| v == 0.0));
}

#[test]
fn without_scattering_each_pixel_is_dimmed_by_its_own_path() {
    let (width, height) = (24, 16);
    for camera in [Camera::orthographic(0.05).unwrap(), Camera::perspective(50.0).unwrap()] {
        let mut setup = Setup::plane(width, height, |x, y| 1.0 + ((x + y) % 3) as f32);
        setup.geometry.camera = camera;
        setup.geometry.surface = Field::Uniform(0.5);
        // A plane through z = 2 on the axis, tilted: its distance along each ray.
        let normal = DVec3::new(0.3, 0.1, 1.0);
        setup.geometry.depth = Field::Map(Image::from_fn(width, height, |x, y| {
            let (start, d) = camera.ray(x as f64 + 0.5, y as f64 + 0.5, (width, height));
            ((2.0 - normal.dot(start)) / normal.dot(d)) as f32
        }));
        setup.medium = Medium::new(0.0, 0.7, *setup.medium.phase()).unwrap();
        let image = setup.trace();
        for y in 0..height {
            for x in 0..width {
                let z = setup.geometry.path_length(x, y).unwrap();
                let truth = (-0.7 * z).exp() * f64::from(setup.radiance.at(x, y));
                let (value, variance) = (f64::from(image.mean.at(x, y)), f64::from(image.variance.at(x, y)));
                // Within a pixel the path varies by some hundredths: a mean of exponentials, not its middle.
                assert!(
                    (value - truth).abs() < 4.0 * variance.sqrt() + 5e-4 * truth,
                    "{camera:?} ({x}, {y})"
                );
            }
        }
    }
}

#[test]
fn an_empty_pixel_gets_scattered_light_only() {
    let mut setup = Setup { samples: 256, ..Setup::plane(15, 15, |_, _| 1.0) };
    setup.geometry.depth = Field::Map(Image::from_fn(15, 15, |x, _| if x == 7 { 0.0 } else { 1.0 }));
    let columns = columns(&setup.trace());
    let (empty, beside) = (columns[7].0, columns[5].0);
    assert!(empty > 0.2 && empty < beside - 0.9 * setup.medium.transmittance(1.0), "{empty} {beside}");
    setup.medium = Medium::new(0.0, 0.0, *setup.medium.phase()).unwrap();
    assert_eq!(setup.trace().mean.at(7, 3), 0.0);
}

#[test]
fn a_tilted_plane_is_traced_as_a_plane() {
    // 40 degrees: the patches of a map against the plane itself, without absorption and with radiance 1.
    // The map ends 1.0 away from the pixels compared, where hardly a path gets.
    let (n, slope) = (100, 40.0_f64.to_radians().tan());
    let mut setup = Setup { samples: 600, ..Setup::plane(n, 20, |_, _| 1.0) };
    let z_at = |x: f64| 1.0 + slope * x;
    let centre = |x: usize| 0.02 * (x as f64 + 0.5 - 0.5 * n as f64);
    setup.geometry.depth = Field::Map(Image::from_fn(n, 20, |x, _| z_at(centre(x)) as f32));
    setup.medium = Medium::new(2.0, 0.5, *setup.medium.phase()).unwrap();
    setup.view = View { x: 48, y: 0, width: 4, height: 20 };
    let traced = columns(&setup.trace());
    let key = Stream::key(5);
    let compared: Vec<_> = (0..4)
        .map(|column| {
            let paths = 100_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for i in 0..paths {
                let mut stream = Stream::new(key, column * paths + i);
                let x = centre(48 + column as usize) + 0.02 * (stream.uniform_f64() - 0.5);
                let mut path = Path::new(Vec3::new(x as f32, 0.0, 0.0), Vec3::Z);
                let light = loop {
                    let step = free_path(2.0, &mut stream);
                    let (p, d) = (path.position.as_dvec3(), path.direction.as_dvec3());
                    // Distance to z = 1 + slope x.
                    let to_plane = (z_at(p.x) - p.z) / (d.z - slope * d.x);
                    if to_plane > 0.0 && to_plane < f64::from(step) {
                        break (-0.5 * (f64::from(path.length) + to_plane)).exp();
                    }
                    path.advance(step);
                    if path.position.z < 0.0 {
                        break 0.0;
                    }
                    path.scatter(setup.medium.phase(), &mut stream);
                };
                sum += light;
                squares += light * light;
            }
            let n = paths as f64;
            let (value, variance) = traced[column as usize];
            (value, variance + (squares / n - (sum / n).powi(2)) / n, sum / n)
        })
        .collect();
    assert_agree("tilted 40°", &compared);
}

#[test]
fn images_are_the_same_for_any_number_of_threads() {
    let mut setup = Setup { samples: 32, ..Setup::plane(12, 9, |x, y| (x + y) as f32) };
    setup.geometry.depth = Field::Map(Image::from_fn(12, 9, |x, y| 1.0 + 0.01 * (x * y) as f32));
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| setup.trace())
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one.paths, 12 * 9 * 32);
    assert_ne!(one.mean, Setup { seed: 2, ..Setup::plane(12, 9, |x, y| (x + y) as f32) }.trace().mean);
}

#[test]
fn the_variance_image_tells_the_scatter_of_independent_runs() {
    let runs: Vec<TracedImage> = (0..40)
        .map(|seed| Setup { seed, samples: 16, ..Setup::plane(8, 8, |x, _| (x % 2) as f32) }.trace())
        .collect();
    let n = runs.len() as f64;
    let (mut seen, mut told) = (0.0, 0.0);
    for i in 0..64 {
        let values: Vec<f64> = runs.iter().map(|r| f64::from(r.mean.data[i])).collect();
        let mean = values.iter().sum::<f64>() / n;
        seen += values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        told += runs.iter().map(|r| f64::from(r.variance.data[i])).sum::<f64>() / n;
    }
    // 64 variances of 40 values each: 3 % noise.
    assert!((seen / told - 1.0).abs() < 0.12, "{seen} {told}");
}

#[test]
fn the_view_is_a_part_of_the_whole_image() {
    let whole = Setup { samples: 200, ..Setup::plane(16, 16, |x, y| ((x ^ y) & 1) as f32) };
    let view = View { x: 5, y: 3, width: 8, height: 6 };
    let part =
        Setup { view, seed: 9, samples: 200, ..Setup::plane(16, 16, |x, y| ((x ^ y) & 1) as f32) }.trace();
    let whole = whole.trace();
    let cut = TracedImage { mean: whole.mean.crop(view), variance: whole.variance.crop(view), paths: 0 };
    assert_same_images("view", &cut, &part);
}

#[test]
fn a_scene_that_makes_no_sense_is_refused_by_name() {
    let message = |setup: &Setup| trace_image(&setup.config(), &|_| ()).unwrap_err().to_string();
    let mut setup = Setup::plane(8, 8, |_, _| 1.0);
    setup.samples = 1;
    assert!(message(&setup).starts_with("samples = 1"));
    setup.samples = 2;
    setup.view = View { x: 4, y: 0, width: 5, height: 8 };
    assert!(message(&setup).contains("view"));
    setup.view = View::whole(setup.size().0, setup.size().1);
    setup.geometry.surface = Field::Uniform(1.5);
    assert!(message(&setup).contains("depth - surface"));
    setup.radiance = Image::filled(8, 7, 1.0);
    assert!(message(&setup).contains("radiance"));
    assert_eq!(setup.medium.phase().family(), Family::Gaussian);
}
