//! The plane-parallel veil and the light on objects against light traced without approximations.

use glam::DVec3;
use narrowbeam::illumination::{Bottom, PlaneParallel, Sun};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Gaussian, PhaseFunction};
use rand_core::Rng;
use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::SeedableRng};

const PATHS: usize = 100_000;

/// A scene of the test: sigma_s, sigma_a, B, the light's direction, depth of the black bottom; normal -z.
struct Slab {
    sigma_s: f64,
    sigma_a: f64,
    b: f64,
    light: DVec3,
    bottom: f64,
}

impl Slab {
    fn closed_form(&self, phase: Gaussian) -> PlaneParallel {
        let sun = Sun::new(self.light, DVec3::NEG_Z).unwrap();
        let medium = Medium::new(self.sigma_s, self.sigma_a, phase.into()).unwrap();
        PlaneParallel::new(sun, 1.0, Bottom::new(self.bottom, 0.0).unwrap(), medium).unwrap()
    }

    /// Radiance that comes to the camera from the whole slab along `ray`, by paths from the camera that look for the light
    /// at each scattering.
    fn traced_veil(&self, phase: &Gaussian, ray: DVec3) -> f64 {
        let light = self.light.normalize();
        let sigma_t = self.sigma_s + self.sigma_a;
        let mut veil = 0.0;
        self.walk(phase, ray, |at, back, weight| {
            veil += weight * phase.pdf(-back.dot(light)) * (-sigma_t * at.z / light.z).exp();
        });
        veil / PATHS as f64
    }

    /// Irradiance of the bottom, by paths from the light.
    fn traced_irradiance(&self, phase: &Gaussian) -> f64 {
        let light = self.light.normalize();
        let lost = self.walk(phase, self.light, |_, _, _| ());
        light.z * lost / PATHS as f64
    }

    /// Walks paths that set out along `start` from the surface, tells `scattered` place, direction and weight of each
    /// scattering, and returns the weight that reaches the bottom.
    fn walk(&self, phase: &Gaussian, start: DVec3, mut scattered: impl FnMut(DVec3, DVec3, f64)) -> f64 {
        let sigma_t = self.sigma_s + self.sigma_a;
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut uniform = || ((rng.next_u64() >> 40) as f64 * 0.5_f64.powi(24)) as f32;
        let mut arrived = 0.0;
        for _ in 0..PATHS {
            let (mut at, mut along, mut weight) = (DVec3::ZERO, start.normalize(), 1.0);
            loop {
                at += along * (-(1.0 - f64::from(uniform())).ln() / sigma_t);
                if at.z < 0.0 {
                    break;
                }
                if at.z > self.bottom {
                    arrived += weight;
                    break;
                }
                weight *= self.sigma_s / sigma_t;
                scattered(at, along, weight);
                let [sin, cos, cos_phi, sin_phi] = phase.sample(&mut uniform).map(f64::from);
                let (side, up) = along.any_orthonormal_pair();
                along = (cos * along + sin * (cos_phi * side + sin_phi * up)).normalize();
            }
        }
        arrived
    }
}

/// Media from thin to thick, narrow to broad: sigma_s, sigma_a, B, over a depth of 1.
const MEDIA: [[f64; 3]; 7] = [
    [0.5, 0.02, 0.034],
    [1.5, 0.02, 0.034],
    [3.0, 0.02, 0.034],
    [3.0, 0.02, 0.07],
    [3.0, 0.5, 0.07],
    [8.0, 0.1, 0.07],
    [1.0, 0.1, 1.0],
];

fn slabs() -> impl Iterator<Item = (Slab, Gaussian)> {
    MEDIA.into_iter().map(|[sigma_s, sigma_a, b]| {
        let light = DVec3::new(0.45, 0.2, 0.9);
        (Slab { sigma_s, sigma_a, b, light, bottom: 1.0 }, Gaussian::new(b).unwrap())
    })
}

fn label(slab: &Slab) -> String {
    format!("sigma_s {} sigma_a {} b {}", slab.sigma_s, slab.sigma_a, slab.b)
}

/// Whether a veil is as near to the traced one as two streams come: within half of it, or .02 % of the irradiance, which
/// is less than a thousandth of what a white wall sends out.
fn near(veil: f64, traced: f64) -> bool {
    (veil - traced).abs() < 0.5 * traced + 2e-4
}

#[test]
fn the_veil_is_within_its_stated_error_of_traced_light() {
    let ray = DVec3::new(0.0, -0.6, 0.8);
    for (slab, phase) in slabs() {
        let traced = slab.traced_veil(&phase, ray);
        let closed = slab.closed_form(phase).veil(ray, f64::INFINITY);
        println!(
            "{}: veil traced {traced:.5}, closed form {:+.1} %",
            label(&slab),
            100.0 * (closed / traced - 1.0)
        );
        assert!(near(closed, traced));
        // The comparison tells a medium three times as dense.
        let dense = Slab { sigma_s: 3.0 * slab.sigma_s, ..slab };
        let wrong = dense.closed_form(phase).veil(ray, f64::INFINITY);
        assert!(traced < 2e-4 || slab.sigma_s > 2.0 || !near(wrong, traced), "{}", label(&slab));
    }
}

#[test]
fn light_on_objects_is_within_its_stated_error_of_traced_light() {
    for (slab, phase) in slabs() {
        let traced = slab.traced_irradiance(&phase);
        let light = slab.light.normalize();
        let closed = slab.closed_form(phase).irradiance(1.0, DVec3::NEG_Z, light.z);
        println!(
            "{}: irradiance traced {traced:.4}, closed form {:+.2} %",
            label(&slab),
            100.0 * (closed / traced - 1.0)
        );
        // As measured; the noise of the tracing is .3 %.
        assert!((closed / traced - 1.0).abs() < 0.05);
    }
}
