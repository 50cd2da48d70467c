//! Spread kernels: identities between psf, encircled energy and transfer function, and derivatives.

use libm::j0;
use narrowbeam::Error;
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Family, Gaussian, HenyeyGreenstein, PhaseFunction, b_of_spread_angle};
use narrowbeam::spread::{Model, SpreadKernel, second_moments};
use std::f64::consts::PI;

const MEDIA: [(f64, f64, f64, f64); 5] = [
    // sigma_s, sigma_a, B, z
    (0.1, 0.0, 0.003, 0.5),
    (0.95, 0.05, 0.0049, 2.0),
    (1.5, 0.3, 0.002, 3.0),
    (4.0, 0.1, 0.001, 2.0),
    (0.4, 1.0, 0.01, 1.0),
];

/// ∫_a^b f by Simpson's rule on `n` intervals, uniform in ln r.
fn log_simpson(a: f64, b: f64, n: usize, f: impl Fn(f64) -> f64) -> f64 {
    let h = (b / a).ln() / n as f64;
    (0..=n)
        .map(|i| {
            let r = a * (h * i as f64).exp();
            let weight = if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
            weight * r * f(r)
        })
        .sum::<f64>()
        * h
        / 3.0
}

fn for_each_kernel(mut check: impl FnMut(Model, &dyn SpreadKernel, (f64, f64, f64, f64))) {
    for (sigma_s, sigma_a, b, z) in MEDIA {
        let medium = Medium::gaussian(sigma_s, sigma_a, b).unwrap();
        for model in Model::ALL {
            check(model, &*model.kernel(&medium, z).unwrap(), (sigma_s, sigma_a, b, z));
        }
    }
}

#[test]
fn encircled_energy_is_the_integral_of_the_psf_and_tends_to_the_scattered_total() {
    for_each_kernel(|model, kernel, medium| {
        let w = medium.3 * medium.2.sqrt();
        let start = 1e-4 * w;
        for r in [0.3 * w, w, 3.0 * w] {
            let ring = log_simpson(start, r, 1000, |r| 2.0 * PI * r * kernel.psf(r));
            let want = kernel.encircled_energy(r) - kernel.encircled_energy(start);
            // Simpson's own error at this step, relative to the whole.
            assert!(
                (ring - want).abs() <= 2e-8 * kernel.scattered() + 1e-15,
                "{model} {medium:?} {r}: {ring} {want}"
            );
        }
        // Grazing light goes far beyond what small angles know of.
        let far = if model == Model::WideAngle { 1e4 } else { 60.0 };
        let all = kernel.encircled_energy(far * w);
        assert!((all - kernel.scattered()).abs() <= 1e-9 * kernel.scattered(), "{model} {medium:?}");
    });
}

#[test]
fn psf_and_transfer_function_are_a_transform_pair() {
    for_each_kernel(|model, kernel, medium| {
        let w = medium.3 * medium.2.sqrt();
        for k in [0.2 / w, 1.0 / w, 3.0 / w] {
            // Inside the start radius J0 = 1 - (k r)²/4, which changes the total by 1e-8 at most, and as much lies
            // beyond the end.
            let (start, end) = (1e-4 * w, kernel.support(1e-8).max(w));
            let outer = log_simpson(start, end, 5000, |r| 2.0 * PI * r * kernel.psf(r) * j0(k * r));
            let sum = outer + kernel.encircled_energy(start);
            let want = kernel.scattered_transfer(k).value;
            assert!((sum - want).abs() <= 1e-7 * kernel.scattered(), "{model} {medium:?} {k}: {sum} {want}");
        }
    });
}

#[test]
fn a_wrong_psf_is_not_a_transform_pair() {
    let phase = Gaussian::new(0.0049).unwrap();
    let medium = Medium::new(0.95, 0.05, phase.into()).unwrap();
    let kernel = Model::SmallAngle.kernel(&medium, 2.0).unwrap();
    let other = Model::NarrowBeam.kernel(&medium, 2.0).unwrap();
    let k = 1.0 / kernel.width();
    let start = 1e-4 * kernel.width();
    let sum = log_simpson(start, 15.0 * kernel.width(), 3000, |r| 2.0 * PI * r * other.psf(r) * j0(k * r));
    assert!((sum - kernel.scattered_transfer(k).value).abs() > 1e-3);
}

#[test]
fn transfer_function_derivatives_match_central_differences() {
    for (sigma_s, sigma_a, b, z) in MEDIA {
        let at = |p: [f64; 3], model: Model, k: f64| {
            let phase = Gaussian::new(p[2]).unwrap();
            model.kernel(&Medium::new(p[0], p[1], phase.into()).unwrap(), z).unwrap().mtf(k)
        };
        // sigma_a is moved off its bound so that the difference can be central.
        let p = [sigma_s, sigma_a + 0.01, b];
        for model in Model::ALL {
            for x in [0.0, 0.03, 0.5, 2.0, 20.0] {
                let k = x / (z * b.sqrt());
                let analytic = at(p, model, k).gradient;
                for i in 0..3 {
                    let h = 1e-4 * p[i];
                    let (mut up, mut down) = (p, p);
                    up[i] += h;
                    down[i] -= h;
                    let difference = (at(up, model, k).value - at(down, model, k).value) / (2.0 * h);
                    // Third derivatives are of order value / p³: relative step squared, plus rounding of M / h.
                    let bound = 1e-7 * (z + 1.0 / p[i]);
                    assert!(
                        (analytic[i] - difference).abs() <= bound,
                        "{model} parameter {i} at {p:?}, x {x}: {} {difference}",
                        analytic[i]
                    );
                }
            }
        }
    }
}

#[test]
fn small_angle_has_the_exact_second_moment() {
    for (sigma_s, sigma_a, b, z) in MEDIA {
        let medium = Medium::gaussian(sigma_s, sigma_a, b).unwrap();
        let kernel = Model::SmallAngle.kernel(&medium, z).unwrap();
        // M(k) = M(0) - R k²/4 + O(k⁴).
        let k = 1e-3 / (z * b.sqrt());
        let moment = 4.0 * (kernel.mtf(0.0).value - kernel.mtf(k).value) / (k * k);
        let exact = second_moments(&medium, z).unwrap().exact;
        assert!((moment / exact - 1.0).abs() < 1e-4, "{moment} {exact}");
        let formula = 4.0 / 3.0 * sigma_s * b * z.powi(3) * (-sigma_a * z).exp();
        assert!((exact / formula - 1.0).abs() < 1e-12);
    }
}

#[test]
fn models_of_small_angles_but_single_scatter_keep_the_scattered_total() {
    for_each_kernel(|model, kernel, (sigma_s, sigma_a, _, z)| {
        if model == Model::WideAngle {
            return;
        }
        let phi = (-sigma_a * z).exp() * (1.0 - (-sigma_s * z).exp());
        let want = match model {
            Model::BeerLambert => 0.0,
            Model::SingleScatter => sigma_s * z * (-(sigma_s + sigma_a) * z).exp(),
            _ => phi,
        };
        assert!((kernel.scattered() - want).abs() < 1e-14, "{model}");
    });
}

#[test]
fn all_models_agree_with_small_angle_where_little_is_scattered() {
    let medium = Medium::gaussian(1e-3, 0.2, 0.005).unwrap();
    let truth = Model::SmallAngle.kernel(&medium, 1.0).unwrap();
    for model in [Model::SingleScatter, Model::NarrowBeam, Model::NarrowBeamPrinted] {
        let kernel = model.kernel(&medium, 1.0).unwrap();
        for x in [0.1, 1.0, 5.0] {
            let k = x / truth.width();
            let (a, b) = (kernel.scattered_transfer(k).value, truth.scattered_transfer(k).value);
            // The next order is tau relative to the first.
            assert!((a - b).abs() < 2e-3 * b, "{model} {x}: {a} {b}");
        }
    }
}

#[test]
fn models_of_the_gaussian_phase_function_refuse_henyey_greenstein_by_name() {
    let phase = HenyeyGreenstein::new(0.95).unwrap();
    let medium = Medium::new(1.0, 0.0, phase.into()).unwrap();
    for model in [Model::Gaussian, Model::NarrowBeam, Model::NarrowBeamPrinted] {
        let error = model.kernel(&medium, 1.0).err().expect("refused");
        assert!(matches!(error, Error::NoSecondMoment { .. }));
        let message = error.to_string();
        assert!(message.contains(model.name()) && message.contains("Henyey-Greenstein"), "{message}");
    }
    for model in [Model::SingleScatter, Model::SmallAngle] {
        let kernel = model.kernel(&medium, 1.0).unwrap();
        let w = phase.planar_width();
        let ring = log_simpson(1e-5 * w, w, 800, |r| 2.0 * PI * r * kernel.psf(r));
        let want = kernel.encircled_energy(w) - kernel.encircled_energy(1e-5 * w);
        assert!((ring - want).abs() < 1e-7, "{model}: {ring} {want}");
    }
}

#[test]
fn models_are_found_by_name_and_others_refused() {
    for model in Model::ALL {
        assert_eq!(model.name().parse::<Model>().unwrap(), model);
    }
    assert!("wide".parse::<Model>().unwrap_err().to_string().contains("small-angle"));
}

#[test]
fn an_opaque_medium_gives_finite_numbers() {
    let phase = Gaussian::new(0.004).unwrap();
    let medium = Medium::new(900.0, 0.0, phase.into()).unwrap();
    for model in Model::ALL.into_iter().filter(|&m| m != Model::WideAngle) {
        let kernel = model.kernel(&medium, 1.0).unwrap();
        for k in [0.0, 1.0, 1e3] {
            let m = kernel.mtf(k);
            assert!(m.value.is_finite() && m.gradient.iter().all(|g| g.is_finite()), "{model} {k}: {m:?}");
        }
    }
}

#[test]
fn wide_angle_refuses_what_its_table_does_not_hold() {
    let refusal = |sigma_s: f64, sigma_a: f64, b: f64| {
        let phase = Gaussian::new(b).unwrap();
        let kernel = Model::WideAngle.kernel(&Medium::new(sigma_s, sigma_a, phase.into()).unwrap(), 1.0);
        kernel.err().map(|e| e.to_string()).unwrap_or_default()
    };
    let range = Model::WideAngle.range(Family::Gaussian).unwrap();
    let (tau, absorption, b) = (range.tau, range.absorption, range.phase[1]);
    assert_eq!(refusal(tau, absorption, b), "");
    assert!(refusal(1.01 * tau, 0.0, b).contains("sigma_s z"));
    assert!(refusal(tau, 1.01 * absorption, b).contains("sigma_a z"));
    assert!(refusal(tau, 0.0, 1.03 * b).contains("spread angle"));
    let hg = |g: f64| {
        let phase = HenyeyGreenstein::new(g).unwrap();
        Model::WideAngle
            .kernel(&Medium::new(1.0, 0.0, phase.into()).unwrap(), 1.0)
            .err()
            .map(|e| e.to_string())
    };
    let widest = Model::WideAngle.range(Family::HenyeyGreenstein).unwrap().phase[0];
    assert_eq!((hg(widest), hg(0.9999)), (None, None));
    assert!(hg(0.99 * widest).unwrap().starts_with("g = "));
}

#[test]
fn wide_angle_is_small_angle_theory_where_angles_are_small() {
    // Below the table's first nodes, at them, and where tau 4B makes .1 % of difference; .5 % is the table's own bound
    // (tests/wide_angle.rs).
    for (tau, degrees) in [(2.0, 0.1), (1e-7, 0.5), (4.0, 1.0), (0.5, 3.0)] {
        let phase = Gaussian::new(b_of_spread_angle(f64::to_radians(degrees))).unwrap();
        let medium = Medium::new(tau, 0.3, phase.into()).unwrap();
        let [wide, small] = [Model::WideAngle, Model::SmallAngle].map(|m| m.kernel(&medium, 1.0).unwrap());
        for x in [0.0, 0.1, 0.5, 1.0, 3.0, 10.0] {
            let k = x / phase.b().sqrt();
            let (a, b) = (wide.scattered_transfer(k).value, small.scattered_transfer(k).value);
            assert!((a - b).abs() < 5e-3 * small.scattered(), "{tau} {degrees} {x}: {a} {b}");
        }
    }
}

#[test]
fn the_mean_slope_is_the_gradient_of_the_joint_characteristic_function() {
    // ln of it is -sigma_t z + sigma_s ∫_0^z Phat(|k u + q|) du, here for q along k, by the trapezium rule.
    let z = 1.5;
    let gaussian = Family::Gaussian.phase(0.006).unwrap();
    let hg = Family::HenyeyGreenstein.phase(0.93).unwrap();
    for phase in [gaussian, hg] {
        let medium = Medium::new(1.1, 0.2, phase).unwrap();
        let kernel = Model::SmallAngle.kernel(&medium, z).unwrap();
        for k in [0.3, 2.0, 9.0, 40.0] {
            let joint = |q: f64| {
                let panels = 200_000;
                let at =
                    |i: i32| phase.planar_transform((k * z * f64::from(i) / f64::from(panels) + q).abs());
                let inner: f64 = (1..panels).map(at).sum();
                let integral = z / f64::from(panels) * (inner + 0.5 * (at(0) + at(panels)));
                (medium.sigma_s() * integral - medium.sigma_t() * z).exp()
            };
            // One-sided from 0 on, where Henyey-Greenstein's transform has no kink.
            let step = 1e-4;
            let slope = (-joint(2.0 * step) + 4.0 * joint(step) - 3.0 * joint(0.0)) / (2.0 * step);
            let found = kernel.mean_slope(k, 0.0).value;
            assert!(
                (found - k * slope).abs() < 1e-4 * found.abs(),
                "{phase:?} at {k}: {found} {}",
                k * slope
            );
            // With nearness, the offset's share is taken off: E[r exp(ik·r)] = -i grad M.
            let step = 1e-4 * k;
            let change = (kernel.mtf(k + step).value - kernel.mtf(k - step).value) / (2.0 * step);
            let near = kernel.mean_slope(k, 0.7).value;
            let want = found - 0.7 / z * k * change;
            assert!((near - want).abs() < 1e-6 * found.abs(), "{phase:?} at {k}: {near} {want}");
        }
    }
}

#[test]
fn derivatives_of_the_mean_slope_match_central_differences() {
    let (sigma_s, sigma_a, b, z) = (1.1, 0.2, 0.006, 1.5);
    for model in Model::ALL {
        for k in [0.3, 2.0, 9.0, 40.0] {
            let at = |p: [f64; 3]| {
                let phase = Gaussian::new(p[2]).unwrap();
                model.kernel(&Medium::new(p[0], p[1], phase.into()).unwrap(), z).unwrap().mean_slope(k, 0.4)
            };
            let p = [sigma_s, sigma_a, b];
            for i in 0..3 {
                let step = 1e-4 * p[i];
                let shifted = |d: f64| {
                    let mut q = p;
                    q[i] += d;
                    at(q).value
                };
                let difference = (shifted(step) - shifted(-step)) / (2.0 * step);
                let off = (at(p).gradient[i] - difference).abs() * p[i];
                assert!(off <= 1e-6 * (1.0 + at(p).value.abs()), "{model}, {k}, {i}: {off}");
            }
        }
    }
}
