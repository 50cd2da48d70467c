//! A tilted plane against exact small-angle paths, which know nothing of transforms.

use super::scenes::Scene;
use narrowbeam::filter::{Filter, Optics};
use narrowbeam::image::{Border, Image};
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;
use narrowbeam::trace::Stream;
use rayon::prelude::*;

const WIDTH: usize = 200;
const HEIGHT: usize = 64;
const PITCH: f64 = 0.02;
/// Columns compared: far from the image's border, beyond which there is nothing.
const SEEN: std::ops::Range<usize> = 80..120;

/// Depth at which paths that run along the plane for ever are given up.
const LOST: f64 = 40.0;

/// Stripes of two periods, the same on all rows.
fn stripes(x: usize) -> f64 {
    0.2 + if (x / 6).is_multiple_of(2) { 0.6 } else { 0.0 } + 0.2 * (0.4 * x as f64).sin()
}

fn plane(slope: f64, x: f64) -> f64 {
    1.8 + slope * PITCH * (x - 0.5 * WIDTH as f64)
}

/// Light of the column `x` and the variance of that estimate: paths whose slope changes by small amounts at random
/// depths, until they meet the plane; lengths are counted along z.
fn traced(x: usize, slope: f64, optics: &Optics, b: f64, paths: u64) -> (f64, f64) {
    let (sigma_s, sigma_a) = (optics.medium.sigma_s(), optics.medium.sigma_a());
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..paths {
        let mut stream = Stream::new(Stream::key(3), x as u64 * paths + i);
        let start = x as f64 + stream.uniform_f64();
        let (mut at, mut z, mut turn) = (start * PITCH, 0.0, 0.0);
        let direct = plane(slope, start);
        let once = -(-sigma_s * direct).exp_m1();
        let mut scattered = false;
        let light = loop {
            // The first scattering comes before the plane for sure.
            let share = if scattered { 1.0 } else { once };
            let step = -(-share * stream.uniform_f64()).ln_1p() / sigma_s;
            let to_plane = (plane(slope, at / PITCH) - z) / (1.0 - turn * slope);
            if scattered && (0.0..step).contains(&to_plane) {
                let pixel = ((at + turn * to_plane) / PITCH) as usize;
                let shown = pixel < WIDTH;
                break if shown { stripes(pixel) * (-sigma_a * (z + to_plane)).exp() } else { 0.0 };
            }
            at += turn * step;
            z += step;
            scattered = true;
            if z > LOST {
                break 0.0;
            }
            let radius = (-2.0 * stream.uniform_f64().max(f64::MIN_POSITIVE).ln()).sqrt();
            turn += (2.0 * b).sqrt() * radius * (std::f64::consts::TAU * stream.uniform_f64()).cos();
        };
        sum += once * light;
        squares += (once * light).powi(2);
    }
    let n = paths as f64;
    let direct = optics.medium.transmittance(plane(slope, x as f64 + 0.5)) * stripes(x);
    (direct + sum / n, (squares / n - (sum / n).powi(2)) / n)
}

/// Root mean square of how far `image` is off `truth`, less the noise of `truth`, in % of the mean.
fn off(image: &[f64], truth: &[(f64, f64)]) -> f64 {
    let n = truth.len() as f64;
    let mean = truth.iter().map(|t| t.0).sum::<f64>() / n;
    let square: f64 = image.iter().zip(truth).map(|(v, (t, variance))| (v - t).powi(2) - variance).sum();
    100.0 * (square / n).max(0.0).sqrt() / mean
}

#[test]
fn on_a_tilted_plane_the_composite_filter_follows_the_paths_and_eq29_does_not() {
    let slope = 40.0_f64.to_radians().tan();
    let b = 0.25 * 10.0_f64.to_radians().powi(2);
    let phase = Gaussian::new(b).unwrap();
    let optics = Optics { model: Model::SmallAngle, medium: Medium::new(1.0, 0.1, phase.into()).unwrap() };
    let mut scene = Scene::new((WIDTH, HEIGHT), PITCH, |x, _| plane(slope, x as f64 + 0.5));
    scene.radiance = Image::from_fn(WIDTH, HEIGHT, |x, _| stripes(x) as f32);
    scene.border = Border::Mirror;
    let truth: Vec<_> = SEEN.into_par_iter().map(|x| traced(x, slope, &optics, b, 500_000)).collect();
    let [composite, eq29] = [Filter::Composite, Filter::Eq29].map(|filter| {
        let image = scene.fast(filter, &optics);
        let row = &image[HEIGHT / 2 * WIDTH..][..WIDTH];
        off(&row[SEEN], &truth)
    });
    println!("off, % of the mean: composite {composite:.3}, eq29 {eq29:.3}");
    // The noise taken off leaves .05 %.
    assert!(composite < 0.2 && eq29 > 1.0, "{composite} {eq29}");
}
