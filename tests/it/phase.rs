//! The phase functions against their own definitions, by quadrature and by differences.

use gauss_quad::legendre::GaussLegendre;
use libm::j0;
use narrowbeam::phase::{Gaussian, HenyeyGreenstein, PhaseFunction};
use std::f64::consts::PI;

/// Integral from `a` to `b` over panels that double in size away from `a`, the first being `first` long: fit for
/// functions with a peak of that width at `a`.
fn integrate(a: f64, b: f64, first: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rule = GaussLegendre::new(40.try_into().unwrap());
    let (mut left, mut panel, mut sum) = (a, first, 0.0);
    while left < b {
        let right = b.min(left + panel);
        sum += rule.integrate(left, right, &f);
        (left, panel) = (right, 2.0 * panel);
    }
    sum
}

const WIDTHS: [f64; 7] = [1e-6, 1e-4, 1e-3, 0.01, 0.1, 0.3, 2.0];
const MEAN_COSINES: [f64; 6] = [0.05, 0.3, 0.7, 0.9, 0.98, 0.999];

/// All phase functions tested, each with the angle over which it varies.
fn all() -> Vec<(Box<dyn PhaseFunction>, f64)> {
    let gaussian = WIDTHS.map(|b| (Box::new(Gaussian::new(b).unwrap()) as Box<dyn PhaseFunction>, b.sqrt()));
    let henyey = MEAN_COSINES
        .map(|g| (Box::new(HenyeyGreenstein::new(g).unwrap()) as Box<dyn PhaseFunction>, 0.3 * (1.0 - g)));
    gaussian.into_iter().chain(henyey).collect()
}

#[test]
fn phase_functions_are_normalised_on_the_sphere() {
    for (phase, width) in all() {
        let over_sphere = |theta: f64| 2.0 * PI * theta.sin() * phase.pdf(theta.cos());
        let total = integrate(0.0, PI, width, over_sphere);
        assert!((total - 1.0).abs() < 1e-8, "{phase:?}: {total}");
    }
}

#[test]
fn the_mean_cosine_is_that_of_the_density_and_positive_forward() {
    for (phase, width) in all() {
        let mean = integrate(0.0, PI, width, |t: f64| 2.0 * PI * t.sin() * t.cos() * phase.pdf(t.cos()));
        assert!((mean - phase.mean_cosine()).abs() < 1e-8, "{phase:?}: {mean} {}", phase.mean_cosine());
        assert!(phase.mean_cosine() > 0.0, "{phase:?}");
    }
}

/// Arguments from far below to far above where the planar transform falls.
fn arguments(width: f64) -> impl Iterator<Item = f64> {
    [1e-4, 0.01, 0.05, 0.2, 1.0, 3.0, 10.0].into_iter().map(move |x| x / width)
}

#[test]
fn the_mean_planar_transform_is_the_mean_of_the_planar_transform() {
    for (phase, width) in all() {
        assert_eq!(phase.planar_transform(0.0), 1.0, "{phase:?}");
        assert_eq!(phase.mean_planar_transform(0.0), 1.0, "{phase:?}");
        for q in arguments(width) {
            let mean = integrate(0.0, q, q / 64.0, |t| phase.planar_transform(t)) / q;
            let f = phase.mean_planar_transform(q);
            assert!((mean - f).abs() < 1e-12, "{phase:?} at {q}: {mean} {f}");
        }
    }
}

#[test]
fn derivatives_in_the_shape_are_differences() {
    let check = |name: &str, q: f64, shape: f64, scale: f64, derivative: f64, f: &dyn Fn(f64) -> f64| {
        let step = 1e-4 * scale;
        let difference = (f(shape + step) - f(shape - step)) / (2.0 * step);
        // The central difference is off by step² times a third derivative, and by rounding over the step.
        let tolerance = 1e-6 * derivative.abs() + 1e-8 * f(shape) / scale + 1e-15 / step;
        assert!((difference - derivative).abs() < tolerance, "{name} at {q}: {difference} {derivative}");
    };
    let both = |phase: &dyn PhaseFunction, q: f64, shape: f64, scale: f64, of: &dyn Fn(f64) -> [f64; 2]| {
        check("F", q, shape, scale, phase.mean_planar_transform_derivative(q), &|shape| of(shape)[0]);
        check("Phat", q, shape, scale, phase.planar_transform_derivative(q), &|shape| of(shape)[1]);
    };
    for b in WIDTHS {
        for q in arguments(b.sqrt()) {
            let of = |b: f64| {
                let phase = Gaussian::new(b).unwrap();
                [phase.mean_planar_transform(q), phase.planar_transform(q)]
            };
            both(&Gaussian::new(b).unwrap(), q, b, b, &of);
        }
    }
    for g in MEAN_COSINES {
        for q in arguments(1.0 - g) {
            let of = |g: f64| {
                let phase = HenyeyGreenstein::new(g).unwrap();
                [phase.mean_planar_transform(q), phase.planar_transform(q)]
            };
            both(&HenyeyGreenstein::new(g).unwrap(), q, g, g.min(1.0 - g), &of);
        }
    }
}

#[test]
fn the_single_scatter_psf_integrates_to_its_encircled_energy() {
    let z = 1.7;
    for (phase, width) in all() {
        for r in [0.03, 0.3, 1.0, 4.0, 30.0].map(|x| x * width * z) {
            let ring = |r: f64| 2.0 * PI * r * phase.single_scatter_psf(r, z);
            let within = integrate(0.0, r, 0.1 * width * z, ring);
            let encircled = phase.single_scatter_encircled(r, z);
            assert!((within - encircled).abs() < 1e-8, "{phase:?} at {r}: {within} {encircled}");
        }
        // The tail of Henyey-Greenstein falls like 1/r.
        let far = phase.single_scatter_encircled(1e6 * z, z);
        assert!(far > 1.0 - 1e-5 && far < 1.0 + 1e-12, "{phase:?}: {far}");
    }
}

#[test]
fn the_single_scatter_psf_of_the_gaussian_is_the_transform_of_its_mean_planar_transform() {
    let (z, b) = (1.7, 0.01_f64);
    let (phase, width) = (Gaussian::new(b).unwrap(), z * b.sqrt());
    for k in [0.1, 1.0, 3.0, 10.0].map(|x| x / width) {
        let step = 0.25 / k;
        let panels = (20.0 * width / step).ceil() as usize;
        let ring = |r: f64| 2.0 * PI * r * phase.single_scatter_psf(r, z) * j0(k * r);
        let transform: f64 =
            (0..panels).map(|i| integrate(i as f64 * step, (i + 1) as f64 * step, step, ring)).sum();
        let f = phase.mean_planar_transform(k * z);
        assert!((transform - f).abs() < 1e-8, "at {k}: {transform} {f}");
    }
}

#[test]
fn the_planar_second_moment_is_that_of_the_planar_transform() {
    for b in WIDTHS {
        let phase = Gaussian::new(b).unwrap();
        // Phat = 1 - <s²> q²/4 + ...
        let q = 1e-3 / b.sqrt();
        let moment = (1.0 - phase.planar_transform(q)) * 4.0 / (q * q);
        assert!((moment / phase.planar_second_moment().unwrap() - 1.0).abs() < 1e-6, "{b}");
    }
    assert_eq!(HenyeyGreenstein::new(0.9).unwrap().planar_second_moment(), None);
}

#[test]
fn widths_and_mean_cosines_out_of_range_are_refused_by_name() {
    for b in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Gaussian::new(b).unwrap_err().to_string().starts_with("b = "));
    }
    for g in [0.0, 1.0, -0.5, f64::NAN] {
        assert!(HenyeyGreenstein::new(g).unwrap_err().to_string().starts_with("g = "));
    }
}
