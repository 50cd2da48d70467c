//! The tracer and `wide-angle` against a published slab: optical thickness 2, albedo 0.9, Henyey-Greenstein's phase function of g 0.75,
//! no refraction, normal incidence (van de Hulst 1980, as quoted by Wang, Jacques and Zheng 1995, table 1).

use glam::Vec3;
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::HenyeyGreenstein;
use narrowbeam::spread::Model;
use narrowbeam::trace::{Estimate, ImageConfig, Path, Stream, free_path, trace_image};

/// Light that leaves at the far side, scattered or not, and light that comes back.
const TRANSMITTED: f64 = 0.66096;
const REFLECTED: f64 = 0.09739;
/// Standard errors within which a sample must be right.
const AGREES: f64 = 4.0;
/// Thickness, sigma_s and sigma_a.
const SLAB: [f64; 3] = [2.0, 0.9, 0.1];

fn phase() -> HenyeyGreenstein {
    HenyeyGreenstein::new(0.75).unwrap()
}

/// Mean of weights with its standard error.
fn estimate(sum: f64, squares: f64, n: f64) -> Estimate {
    let value = sum / n;
    Estimate { value, std_error: ((squares / n - value * value) / n).sqrt() }
}

/// Light that leaves on either side of a slab of this anisotropy, by the tracer's own paths.
fn walked(phase: &HenyeyGreenstein) -> [Estimate; 2] {
    let [z, sigma_s, sigma_a] = SLAB.map(|v| v as f32);
    let paths = 1_000_000;
    let mut sums = [[0.0; 2]; 2];
    for number in 0..paths {
        let mut stream = Stream::new(Stream::key(1), number);
        let mut path = Path::new(Vec3::ZERO, Vec3::Z);
        let side = loop {
            let step = free_path(sigma_s, &mut stream);
            let end = path.position.z + step * path.direction.z;
            if !(0.0..z).contains(&end) {
                let (side, to) = if end >= z { (0, z) } else { (1, 0.0) };
                path.advance((to - path.position.z) / path.direction.z);
                break side;
            }
            path.advance(step);
            path.scatter(phase, &mut stream);
        };
        let weight = f64::from((-sigma_a * path.length).exp());
        sums[side] = [sums[side][0] + weight, sums[side][1] + weight * weight];
    }
    sums.map(|[sum, squares]| estimate(sum, squares, paths as f64))
}

#[test]
fn paths_leave_a_slab_as_published() {
    let [transmitted, reflected] = walked(&phase());
    println!("transmitted {transmitted:?}, reflected {reflected:?}");
    assert!(transmitted.z_score(TRANSMITTED).abs() < AGREES, "{transmitted:?}");
    assert!(reflected.z_score(REFLECTED).abs() < AGREES, "{reflected:?}");
    let [transmitted, reflected] = walked(&HenyeyGreenstein::new(0.74).unwrap());
    assert!(
        transmitted.z_score(TRANSMITTED) < -AGREES && reflected.z_score(REFLECTED) > AGREES,
        "{reflected:?}"
    );
}

#[test]
fn a_uniform_object_is_seen_through_it_as_published() {
    let [z, sigma_s, sigma_a] = SLAB;
    let side = 16;
    let geometry = Geometry::planar(side, side, 0.1, z).unwrap();
    let medium = Medium::new(sigma_s, sigma_a, phase()).unwrap();
    let traced = trace_image(
        &ImageConfig {
            geometry: &geometry,
            radiance: &Image::filled(side, side, 1.0),
            behind: &[],
            border: Border::Clamp,
            view: View::whole(side, side),
            medium,
            samples: 8192,
            seed: 1,
        },
        &|_| (),
    )
    .unwrap();
    let n = (side * side) as f64;
    let mean = traced.mean.mean();
    let squares: f64 = traced.mean.data.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum();
    let seen = Estimate { value: mean, std_error: (squares / (n - 1.0) / n).sqrt() };
    println!("traced {seen:?}");
    assert!(seen.z_score(TRANSMITTED).abs() < AGREES, "{seen:?}");
    // The stated error of the table's scattered total is 0.3 %.
    let medium = Medium::new(sigma_s, sigma_a, phase().into()).unwrap();
    let all = Model::WideAngle.kernel(&medium, z).unwrap().mtf(0.0).value;
    println!("wide-angle {all:.5}");
    assert!((all - TRANSMITTED).abs() < 0.003 * (TRANSMITTED - medium.transmittance(z)), "{all}");
    let small = Model::SmallAngle.kernel(&medium, z).unwrap().mtf(0.0).value;
    assert!((small - TRANSMITTED).abs() > 0.05, "small angles lose no light: {small}");
}
