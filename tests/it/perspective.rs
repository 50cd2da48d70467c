//! Perspective views against the tracer, which follows paths in space and knows no pixels on planes.

use crate::common::bundled::dataset;
use crate::common::texture;
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Filter, Optics, Target};
use narrowbeam::geometry::{Camera, Field, Geometry};
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::b_of_spread_angle;
use narrowbeam::scene::{Scene, read_truth};
use narrowbeam::spread::Model;
use narrowbeam::trace::{ImageConfig, TracedImage, trace_image};

const SIZE: (usize, usize) = (64, 48);
/// The pixels whose kernels stay inside the image: where the border rule has no part.
const INNER: View = View { x: 16, y: 12, width: 32, height: 24 };

/// Something at the depth `planar(u, v)` along the axis, u and v being the tangents of the ray's angles.
fn seen(fov_x_deg: f64, planar: impl Fn(f64, f64) -> f64) -> Geometry {
    let (width, height) = SIZE;
    let camera = Camera::perspective(fov_x_deg).unwrap();
    let depth = Field::Map(Image::from_fn(width, height, |x, y| {
        let (_, ray) = camera.ray(x as f64 + 0.5, y as f64 + 0.5, SIZE);
        (planar(ray.x / ray.z, ray.y / ray.z) / ray.z) as f32
    }));
    Geometry { width, height, camera, depth, behind: Vec::new(), surface: Field::Uniform(0.0) }
}

fn wall(fov_x_deg: f64) -> Geometry {
    seen(fov_x_deg, |_, _| 2.0)
}

/// The plane Z + Y = 2: ground that falls away at 45 degrees.
fn ground(fov_x_deg: f64) -> Geometry {
    seen(fov_x_deg, |_, v| 2.0 / (1.0 + v))
}

struct Case {
    geometry: Geometry,
    radiance: Image,
    medium: Medium,
}

impl Case {
    fn new(geometry: Geometry, radiance: Image, sigma_a: f64) -> Self {
        let b = b_of_spread_angle(6.0_f64.to_radians());
        Self { geometry, radiance, medium: Medium::gaussian(0.8, sigma_a, b).unwrap() }
    }

    fn render(&self, filter: Filter) -> Image {
        let relief = filter.relief(&self.geometry);
        let target = Target {
            radiance: &self.radiance,
            behind: &[],
            geometry: &self.geometry,
            border: Border::Clamp,
            sampling: Sampling::Pixel,
            view: INNER,
            relief: relief.as_ref(),
        };
        let optics = Optics { model: Model::SmallAngle, medium: self.medium };
        CpuFilter::new(target, &optics, 1.0).unwrap().render(&optics).unwrap()
    }

    fn trace(&self, samples: u32) -> TracedImage {
        let config = ImageConfig {
            geometry: &self.geometry,
            radiance: &self.radiance,
            behind: &[],
            border: Border::Clamp,
            view: INNER,
            medium: self.medium,
            samples,
            seed: 5,
        };
        trace_image(&config, &|_| ()).unwrap()
    }
}

/// Mean squared difference over the tracer's noise, and in percent of the mean what is left of it without the noise.
fn compare(image: &Image, traced: &TracedImage) -> (f64, f64) {
    let (mut chi2, mut excess, mut level, mut count) = (0.0, 0.0, 0.0, 0.0);
    for i in 0..image.data.len() {
        let difference = f64::from(image.data[i] - traced.mean.data[i]);
        let variance = f64::from(traced.variance.data[i]);
        chi2 += difference * difference / variance;
        excess += difference * difference - variance;
        level += f64::from(traced.mean.data[i]);
        count += 1.0;
    }
    (chi2 / count, 100.0 * (excess / count).max(0.0).sqrt() / (level / count))
}

#[test]
fn a_bright_world_without_absorption_stays_as_bright() {
    // Whatever way light takes it ends on radiance 1. What composite errs by is of second order in slope and angle.
    println!("error in percent     eq29   composite");
    for (name, geometry, bounds) in [
        ("wall, 40 degrees", wall(40.0), [0.02, 0.02]),
        ("wall, 90 degrees", wall(90.0), [0.02, 0.02]),
        ("ground, 40 degrees", ground(40.0), [2.0, 0.05]),
        ("ground, 60 degrees", ground(60.0), [2.0, 0.05]),
    ] {
        let case = Case::new(geometry, Image::filled(SIZE.0, SIZE.1, 1.0), 0.0);
        let traced = case.trace(64);
        assert!(traced.mean.data.iter().all(|v| (v - 1.0).abs() < 1e-5), "{name}: the tracer loses light");
        let error = [Filter::Eq29, Filter::Composite].map(|filter| {
            let image = case.render(filter);
            100.0 * image.data.iter().map(|v| f64::from(v - 1.0).abs()).fold(0.0, f64::max)
        });
        println!("{name:18} {:7.3} {:9.3}", error[0], error[1]);
        assert!(error[0] < bounds[0] && error[1] < bounds[1], "{name}: {error:?}");
        if name.starts_with("ground") {
            assert!(error[0] > 5.0 * error[1], "{name}: {error:?}");
        }
    }
}

#[test]
fn textured_walls_and_grounds_look_as_traced() {
    // Round kernels in pixels err by a share of the obliquity squared: measured .2 % at 60 degrees of view, .5 % at 90.
    // The bounds leave room for four standard deviations of chi² (.05 each) and as much model error again.
    println!("scene                 eq29 chi2, error %   composite chi2, error %");
    for (name, geometry, most) in [
        ("wall, 40 degrees", wall(40.0), 1.2),
        ("wall, 60 degrees", wall(60.0), 1.4),
        ("wall, 90 degrees", wall(90.0), 3.0),
        ("ground, 40 degrees", ground(40.0), 1.2),
        ("ground, 60 degrees", ground(60.0), 1.4),
    ] {
        let case = Case::new(geometry, texture(SIZE.0, SIZE.1), 0.05);
        let traced = case.trace(4000);
        let [plain, composite] = [Filter::Eq29, Filter::Composite].map(|f| compare(&case.render(f), &traced));
        println!("{name:20} {:8.2} {:8.3} {:12.2} {:8.3}", plain.0, plain.1, composite.0, composite.1);
        assert!(composite.0 < most, "{name}: {composite:?}");
    }
}

#[test]
fn the_comparison_rejects_another_field_of_view() {
    let case = Case::new(wall(40.0), texture(SIZE.0, SIZE.1), 0.05);
    let traced = case.trace(3000);
    let other = Case { geometry: wall(44.0), ..Case::new(wall(40.0), texture(SIZE.0, SIZE.1), 0.05) };
    assert!(compare(&other.render(Filter::Eq29), &traced).0 > 2.0);
}

#[test]
fn the_stage_looks_as_traced() {
    let folder = dataset("mitsuba-stage");
    let scene = Scene::read(&folder.join("scene.toml")).unwrap();
    let medium = read_truth(&folder.join("truth.toml")).unwrap()[0];
    let radiance = &scene.object[0].image;
    let config = ImageConfig {
        geometry: &scene.geometry,
        radiance,
        behind: &[],
        border: scene.border,
        view: scene.view,
        medium,
        samples: 256,
        seed: 3,
    };
    let traced = trace_image(&config, &|_| ()).unwrap();
    let [plain, composite] = [Filter::Eq29, Filter::Composite].map(|filter| {
        let relief = filter.relief(&scene.geometry);
        let target = Target {
            radiance,
            behind: &[],
            geometry: &scene.geometry,
            border: scene.border,
            sampling: Sampling::Pixel,
            view: scene.view,
            relief: relief.as_ref(),
        };
        let optics = Optics { model: Model::SmallAngle, medium };
        let image = CpuFilter::new(target, &optics, 1.0).unwrap().render(&optics).unwrap();
        compare(&image, &traced)
    });
    println!("stage                {:8.2} {:8.3} {:12.2} {:8.3}", plain.0, plain.1, composite.0, composite.1);
    // Two occluders stand for all edges of the ball and the box: the bound is the error measured, and half as much again.
    assert!(composite.1 < 0.8 && plain.1 > 3.0 * composite.1, "{composite:?}, eq29 {plain:?}");
}
