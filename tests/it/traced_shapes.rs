//! Whether the pixels of a depth map should have paths of their own, or one set of path shapes for all of them.
//!
//! A path's shape - its turns and free lengths - does not depend on the pixel that it starts at; only where it ends does. So one set
//! could be drawn once and followed from every pixel. It would save the drawing, and make the same errors everywhere.
//! Views of one pixel, traced with one seed, have the same random numbers, and so share their shapes.

use crate::common::{edge_and_slope, relative_l2};
use nalgebra::{Matrix3, Vector3};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, b_of_spread_angle};
use narrowbeam::trace::{BATCHES, Hits, ImageConfig};
use std::time::Instant;

/// Renders of each kind, and how many make what they are compared with.
const SEEDS: u64 = 8;
const MANY: u64 = 64;
/// Paths a pixel.
const SAMPLES: u32 = 64;

struct Setting {
    object: Image,
    geometry: Geometry,
    medium: Medium<Gaussian>,
}

impl Setting {
    fn view(&self) -> View {
        View::whole(self.object.width, self.object.height)
    }

    fn pixels(&self) -> usize {
        self.view().pixels()
    }

    fn hits(&self, view: View, seed: u64) -> Hits<Gaussian> {
        let config = ImageConfig {
            geometry: &self.geometry,
            radiance: &self.object,
            behind: &[],
            border: Border::Mirror,
            view,
            medium: self.medium,
            samples: SAMPLES,
            seed,
        };
        Hits::trace(&config, &|_| ()).unwrap()
    }

    /// Image and derivatives of a part of the view.
    fn render(&self, view: View, seed: u64) -> [Vec<f64>; 4] {
        let images = self.hits(view, seed).image(&self.medium, 0..BATCHES).unwrap();
        images.map(|image| image.data.iter().map(|&v| f64::from(v)).collect())
    }

    fn own(&self, seed: u64) -> [Vec<f64>; 4] {
        self.render(self.view(), seed)
    }

    fn shared(&self, seed: u64) -> Vec<f64> {
        let pixel =
            |i: usize| View { x: i % self.object.width, y: i / self.object.width, width: 1, height: 1 };
        (0..self.pixels()).map(|i| self.render(pixel(i), seed)[0][0]).collect()
    }

    /// Root mean square errors of ln sigma_s, sigma_a and ln B by the noise of paths of their own, and by that of shared ones.
    fn errors(&self) -> [[f64; 3]; 2] {
        let mut mean: [Vec<f64>; 4] = std::array::from_fn(|_| vec![0.0; self.pixels()]);
        for seed in 0..MANY {
            let one = self.own(1000 + seed);
            mean.iter_mut().zip(one).for_each(|(mean, one)| {
                mean.iter_mut().zip(one).for_each(|(m, v)| *m += v / MANY as f64);
            });
        }
        let scale = [self.medium.sigma_s(), 1.0, self.medium.phase().b()];
        let slopes = |i: usize| Vector3::from_fn(|c, _| mean[1 + c][i] * scale[c]);
        let matrix: Matrix3<f64> = (0..self.pixels()).map(|i| slopes(i) * slopes(i).transpose()).sum();
        let inverse = matrix.try_inverse().unwrap();
        let error = |render: &[f64]| -> Vector3<f64> {
            inverse * (0..self.pixels()).map(|i| slopes(i) * (render[i] - mean[0][i])).sum::<Vector3<f64>>()
        };
        let rms = |renders: &dyn Fn(u64) -> Vec<f64>| {
            let squares = (0..SEEDS).map(|seed| error(&renders(seed)).map(|e| e * e)).sum::<Vector3<f64>>();
            std::array::from_fn(|c| (squares[c] / SEEDS as f64).sqrt())
        };
        [rms(&|seed| self.own(seed)[0].clone()), rms(&|seed| self.shared(seed))]
    }
}

/// A slope and a plane behind it; tau and sigma_a z belong to their mean depth.
fn setting(side: usize, tau: f64, degrees: f64) -> Setting {
    let geometry = edge_and_slope(side);
    let z = geometry.path_lengths().into_iter().sum::<f64>() / geometry.path_lengths().len() as f64;
    let phase = Gaussian::new(b_of_spread_angle(degrees.to_radians())).unwrap();
    let object = Image::from_fn(side, side, |x, y| if (x / 5 + y / 7) % 2 == 0 { 0.9 } else { 0.2 });
    Setting { object, geometry, medium: Medium::new(tau / z, 0.2 / z, phase).unwrap() }
}

#[test]
fn one_seed_gives_pixels_one_set_of_shapes() {
    // Of a plane of one radiance every pixel then sees the same; with shapes of its own it does not.
    let mut setting = setting(32, 2.0, 20.0);
    setting.geometry = Geometry::planar(32, 32, 0.05, 1.0).unwrap();
    setting.object = Image::from_fn(32, 32, |_, _| 1.0);
    let spread = |values: &[f64]| relative_l2(values.iter().copied(), vec![values[0]; values.len()]);
    let (shared, own) = (spread(&setting.shared(1)), spread(&setting.own(1)[0]));
    println!("shared {shared:.1e}, own {own:.1e}");
    assert!(shared < 1e-6 && own > 1e-3, "{shared} {own}");
}

#[test]
#[ignore = "a study: prints docs/wide-angle.md's table of shared path shapes"]
fn own_shapes_beat_shared_ones() {
    for (side, tau, degrees) in
        [(32, 0.5, 10.0), (32, 2.0, 10.0), (64, 2.0, 10.0), (32, 2.0, 30.0), (32, 5.0, 30.0)]
    {
        let setting = setting(side, tau, degrees);
        let [own, shared] = setting.errors();
        let percent = |e: [f64; 3]| e.map(|e| format!("{:.2}", 100.0 * e)).join(", ");
        let ratio: [f64; 3] = std::array::from_fn(|c| shared[c] / own[c]);
        let shown = |r: [f64; 3]| r.map(|r| format!("{r:.1}")).join(", ");
        // At most drawing is saved: it takes as long as the same paths before a plane, which is met at once.
        let mut plane = self::setting(side, tau, degrees);
        plane.geometry = Geometry::planar(side, side, 0.05, tau / setting.medium.sigma_s()).unwrap();
        let least = |setting: &Setting| {
            let one = || {
                let clock = Instant::now();
                (0..4).for_each(|seed| drop(setting.hits(setting.view(), seed)));
                clock.elapsed().as_secs_f64()
            };
            (0..7).map(|_| one()).fold(f64::INFINITY, f64::min)
        };
        let drawing = least(&plane) / least(&setting);
        let at_equal_time = ratio.map(|r| r * (1.0 - drawing).sqrt());
        println!(
            "| {side}² | {tau} | {degrees}° | {} | {} | {} | {:.0} % | {} |",
            percent(own),
            percent(shared),
            shown(ratio),
            100.0 * drawing,
            shown(at_equal_time),
        );
        // Of sigma_a, which even few shapes know well, eight seeds do not always tell.
        assert!(at_equal_time[0] > 1.0 && at_equal_time[2] > 1.0, "sharing would win");
    }
}
