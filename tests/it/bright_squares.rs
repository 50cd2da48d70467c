//! The wide-angle kernel against Mitsuba: a bright square on black, seen through seven media that Mitsuba traced
//! (`tests/witness/squares`; its README has the commands).
//!
//! The table must agree not only with the tracer that made it. An image of the square is the kernel, blurred by the
//! square and the pixel; its sum over the pixels within a radius is the encircled energy, blurred likewise.

use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Optics, Target};
use narrowbeam::image::Image;
use narrowbeam::io::exr::ExrFile;
use narrowbeam::medium::Medium;
use narrowbeam::phase::PhaseFunction;
use narrowbeam::scene::{Scene, read_truth};
use narrowbeam::spread::Model;
use std::path::{Path, PathBuf};

/// Worst error of the encircled energy, as a share of the scattered light: that of `tests/wide_angle.rs`.
const BOUND: f64 = 0.005;
/// Standard errors that the largest of 7 media's errors, at a handful of independent radii each, exceeds in one of a
/// hundred cases.
const NORMAL: f64 = 3.5;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/witness/squares")
}

/// Names of the media that Mitsuba traced.
fn names() -> Vec<String> {
    let files = std::fs::read_dir(folder()).unwrap().map(|f| f.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<String> = files.filter_map(|f| Some(f.strip_suffix(".truth.toml")?.into())).collect();
    names.sort();
    names
}

struct Square {
    scene: Scene,
    truth: Medium,
    observed: Image,
    variance: Image,
}

/// A share of the scattered light and its standard error.
#[derive(Debug, Clone, Copy)]
struct Error {
    share: f64,
    noise: f64,
    radius_px: f64,
}

impl Error {
    fn exceeds_the_bound(&self) -> bool {
        self.share - NORMAL * self.noise > BOUND
    }
}

impl Square {
    fn read(name: &str) -> Self {
        let file = ExrFile::read(&folder().join(format!("{name}.exr"))).unwrap();
        Self {
            scene: Scene::read(&folder().join(format!("{name}.scene.toml"))).unwrap(),
            truth: read_truth(&folder().join(format!("{name}.truth.toml"))).unwrap()[0],
            observed: file.radiance().unwrap().remove(0).image,
            variance: file.named("Y.variance").unwrap().image,
        }
    }

    /// The worst error of `model`'s encircled energy in a medium, over all radii that the image holds.
    fn worst(&self, model: Model, truth: Medium) -> Error {
        let optics = Optics { model, medium: truth };
        let (geometry, radiance) = (&self.scene.geometry, &self.scene.object[0].image);
        let target = Target::plain(radiance, geometry, self.scene.border, self.scene.view);
        let render = CpuFilter::new(target, &optics, 1.0).unwrap().render(&optics).unwrap();
        let kernel = optics.kernel(geometry.path_length(0, 0).unwrap()).unwrap();
        let scattered = kernel.scattered() * radiance.data.iter().map(|&v| f64::from(v)).sum::<f64>();

        // From the square's centre outwards, light and variance within each pixel's distance.
        let centre = 0.5 * (render.width as f64 - 1.0);
        let radius =
            |i: usize| ((i % render.width) as f64 - centre).hypot((i / render.width) as f64 - centre);
        let mut order: Vec<usize> = (0..render.data.len()).filter(|&i| radius(i) <= centre).collect();
        order.sort_by(|&i, &j| radius(i).total_cmp(&radius(j)));
        let (mut excess, mut variance) = (0.0, 0.0);
        let mut worst = Error { share: 0.0, noise: 0.0, radius_px: 0.0 };
        for ring in order.chunk_by(|&i, &j| radius(i) == radius(j)) {
            for &i in ring {
                excess += f64::from(render.data[i]) - f64::from(self.observed.data[i]);
                variance += f64::from(self.variance.data[i]);
            }
            let share = (excess / scattered).abs();
            if share > worst.share {
                worst = Error { share, noise: variance.sqrt() / scattered, radius_px: radius(ring[0]) };
            }
        }
        worst
    }
}

#[test]
fn encircled_energy_is_that_of_mitsuba() {
    println!(
        "| medium | tau | sigma_a z | angle | worst error % | noise % | at radius, px | small-angle % |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- |");
    let names = names();
    for name in &names {
        let square = Square::read(name);
        let wide = square.worst(Model::WideAngle, square.truth);
        let small = square.worst(Model::SmallAngle, square.truth);
        println!(
            "| `{name}` | {} | {} | {:.0}° | {:.2} | {:.2} | {:.1} | {:.1} |",
            square.truth.sigma_s(),
            square.truth.sigma_a(),
            (4.0 * square.truth.phase().parameter()).sqrt().to_degrees(),
            100.0 * wide.share,
            100.0 * wide.noise,
            wide.radius_px,
            100.0 * small.share,
        );
        assert!(!wide.exceeds_the_bound(), "{name}: {wide:?}");
        assert!(small.exceeds_the_bound(), "{name}: small-angle theory would do, {small:?}");
    }
    assert!(names.len() >= 6);
}

#[test]
fn another_medium_is_refused() {
    for name in names() {
        let square = Square::read(&name);
        let ([sigma_s, sigma_a, parameter], phase) = (square.truth.parameters(), *square.truth.phase());
        let others = [
            Medium::new(1.03 * sigma_s, sigma_a, phase).unwrap(),
            Medium::new(sigma_s, 1.03 * sigma_a + 0.02, phase).unwrap(),
            square.truth.with_phase(phase.family().phase(0.9 * parameter).unwrap()),
        ];
        for other in others {
            let worst = square.worst(Model::WideAngle, other);
            println!("{name}: {other:?}: {worst:?}");
            assert!(worst.exceeds_the_bound(), "{name} {other:?} {worst:?}");
        }
    }
}
