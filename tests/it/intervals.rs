//! Intervals: by the covariance, by profile likelihood, by bootstrap, and what a forecast says of them beforehand.

use crate::common::estimates::{compare, status, std_error};
use crate::common::planes::PLANE;
use crate::common::report::fit_scenes;
use narrowbeam::filter::Filter;
use narrowbeam::fit::noise::with_noise;
use narrowbeam::fit::{
    Draws, Intervals, Plan, SceneFit, Settings, Status, Ways, bootstrap, forecast, profile,
};
use narrowbeam::forward::Quantity;
use narrowbeam::lab::study::Setting;
use narrowbeam::lab::study::calibration::{KnownNoise, cases};
use narrowbeam::medium::Medium;
use narrowbeam::scene::ObservedScene;
use narrowbeam::spread::Model;

fn scene(plane: &Setting, noise: f64) -> ObservedScene {
    plane.scene(with_noise(&plane.render(Model::SmallAngle).unwrap(), noise, 3), Some(noise)).unwrap()
}

fn fit(scene: &ObservedScene) -> SceneFit {
    fit_scenes(std::slice::from_ref(scene), &Settings::default(), Filter::Auto, &|| ()).unwrap()
}

/// Both kinds of interval of one fit: profile likelihood, and bootstrap by `draws` refits.
fn intervals(scene: &ObservedScene, fit: &mut SceneFit, draws: usize) -> [Intervals; 2] {
    let (settings, scenes) = (Settings::default(), std::slice::from_ref(scene));
    let (mut by_profile, mut by_bootstrap) = (Intervals::new(), Intervals::new());
    fit.add_intervals(Ways::Profile, scenes, Filter::Auto, |observations, channel, options| {
        by_profile = profile(observations, channel, options, &settings, &|| ())?;
        Ok(by_profile.clone())
    })
    .unwrap();
    let draws = Draws { count: draws, seed: 1 };
    fit.add_intervals(Ways::Bootstrap, scenes, Filter::Auto, |observations, channel, options| {
        by_bootstrap = bootstrap(observations, channel, options, &settings, draws, &|| ())?;
        Ok(by_bootstrap.clone())
    })
    .unwrap();
    [by_profile, by_bootstrap]
}

/// The interval of the parameter `name`; `None` if it has none.
fn interval_of(intervals: &Intervals, name: &str) -> Option<[Option<f64>; 2]> {
    intervals.iter().find(|(parameter, _)| parameter == name).unwrap().1
}

/// Ends of the interval of the parameter `name` away from the estimate, in standard errors.
fn in_standard_errors(fit: &SceneFit, name: &str, intervals: &Intervals) -> [f64; 2] {
    let (_, fit) = &fit.channels[0];
    let id = fit.parameters.find(name).unwrap();
    let (parameter, error) = (fit.parameters.get(id), fit.covariance.std_error(id).unwrap());
    let off = |end: f64| (parameter.coordinate_of(end) - parameter.coordinate()) / error;
    interval_of(intervals, name).unwrap().map(|end| off(end.unwrap()))
}

/// Names of the parameters of the medium.
const NAMES: [&str; 3] = ["sigma_s", "sigma_a", "b"];

#[test]
fn all_intervals_agree_where_the_data_are_good() {
    const DRAWS: usize = 400;
    let scene = scene(&PLANE, 0.002);
    let mut fit = fit(&scene);
    let [by_profile, by_bootstrap] = intervals(&scene, &mut fit, DRAWS);
    for name in NAMES {
        let p = in_standard_errors(&fit, name, &by_profile);
        let b = in_standard_errors(&fit, name, &by_bootstrap);
        println!("{name}: profile {:.3} {:.3}, bootstrap {:.3} {:.3}", p[0], p[1], b[0], b[1]);
        for (side, (p, b)) in [-1.0, 1.0].into_iter().zip(p.into_iter().zip(b)) {
            // A profile's end is found to 2 %; curvature beyond the second order adds some.
            assert!((p - side * 1.96).abs() < 0.1, "{name}");
            // The 2.5 % quantile of 400 normal numbers has a standard deviation of .134: four of them.
            assert!((b - side * 1.96).abs() < 0.54, "{name}");
        }
        let reported = &fit.report.parameters[name];
        assert_eq!(reported.profile95, Some(interval_of(&by_profile, name)));
        assert!(reported.bootstrap95.unwrap().unwrap()[1].is_some());
    }
}

#[test]
fn so_they_do_where_the_noise_is_uneven() {
    const DRAWS: usize = 400;
    let case = cases().unwrap().into_iter().find(|case| case.known == KnownNoise::Variance).unwrap();
    let scene = case.scenes(3).unwrap().remove(0);
    let mut fit = fit(&scene);
    let [by_profile, by_bootstrap] = intervals(&scene, &mut fit, DRAWS);
    for name in NAMES {
        let p = in_standard_errors(&fit, name, &by_profile);
        let b = in_standard_errors(&fit, name, &by_bootstrap);
        println!("{name}: profile {p:.3?}, bootstrap {b:.3?}");
        for side in [0, 1] {
            let normal = [-1.96, 1.96][side];
            // As above.
            assert!((p[side] - normal).abs() < 0.1 && (b[side] - normal).abs() < 0.54, "{name}");
        }
    }
}

#[test]
fn a_profile_ends_at_bounds_and_leaves_open_what_is_open() {
    // No absorption: the interval of sigma_a ends at 0.
    let clear = Setting { medium: Medium::gaussian(0.7, 0.0, 0.004).unwrap(), ..*PLANE };
    let scene_of_clear = scene(&clear, 0.01);
    let mut fitted = fit(&scene_of_clear);
    let [by_profile, _] = intervals(&scene_of_clear, &mut fitted, 2);
    let [low, high] = interval_of(&by_profile, "sigma_a").unwrap();
    assert_eq!(low, Some(0.0));
    assert!(high.unwrap() > 0.0);
    // Next to no scattering: neither sigma_s nor B has a lower end, and the fit says that they are undetermined.
    let thin = Setting { medium: Medium::gaussian(0.002, 0.15, 0.004).unwrap(), ..*PLANE };
    let scene_of_thin = scene(&thin, 0.02);
    let mut fitted = fit(&scene_of_thin);
    assert_eq!(status(&fitted.channels[0].1, Quantity::Phase), Status::Undetermined);
    let [by_profile, _] = intervals(&scene_of_thin, &mut fitted, 2);
    println!("{by_profile:?}");
    assert!(interval_of(&by_profile, "b").unwrap().contains(&None));
}

#[test]
fn a_fixed_parameter_has_no_interval() {
    let mut scene = scene(&PLANE, 0.005);
    scene.scene.fit[0].sigma_a.fixed = Some(0.15);
    let mut fitted = fit(&scene);
    let both = intervals(&scene, &mut fitted, 20);
    for of in both {
        let has_one = |name| interval_of(&of, name).is_some();
        assert!(has_one("sigma_s") && !has_one("sigma_a") && has_one("b"));
    }
}

#[test]
fn a_forecast_has_the_errors_that_fits_will_have() {
    let noise = 0.005;
    let settings = Settings::default();
    let plan = Plan { noise, free_gain: false, free_veil: false };
    let planned = scene(&PLANE, noise);
    let ahead =
        forecast(std::slice::from_ref(&planned.scene), &[PLANE.medium], &plan, &settings, Filter::Auto)
            .unwrap();
    let found = fit(&planned);
    for quantity in Quantity::MEDIUM {
        let error = |fit: &SceneFit| std_error(&fit.channels[0].1, quantity);
        let ratio = error(&ahead) / error(&found);
        // They differ as the estimates do: by a few of their relative errors.
        assert!((ratio - 1.0).abs() < 0.05, "{quantity:?}: {ratio}");
    }
    // At one depth a free gain leaves absorption open: known before anyone measures.
    let free = Plan { free_gain: true, ..plan };
    let ahead =
        forecast(std::slice::from_ref(&planned.scene), &[PLANE.medium], &free, &settings, Filter::Auto)
            .unwrap();
    assert_eq!(status(&ahead.channels[0].1, Quantity::SigmaA), Status::Undetermined);
}

/// Standard deviations of a binomial or chi² number that one of the many below may be off.
const NORMAL: f64 = 4.0;

#[test]
fn error_bars_hold_the_truth_as_often_as_they_say() {
    const DRAWS: usize = 150;
    for case in cases().unwrap() {
        for found in case.run(DRAWS, 5, &|| ()).unwrap() {
            let (share, n) = (found.share(), DRAWS as f64);
            println!("{:35} {:8} {share:.3} rms {:.3}", case.name, found.parameter, found.rms);
            // 2000 draws say 93 to 97 % and 10 % (docs/calibration.md); here the noise of fewer draws comes on top.
            assert!((share - 0.95).abs() < 0.02 + NORMAL * (0.95 * 0.05 / n).sqrt(), "{}", case.name);
            assert!((found.rms - 1.0).abs() < 0.1 + NORMAL / (2.0 * n).sqrt(), "{}", case.name);
        }
    }
}

#[test]
fn noise_that_is_stated_too_small_widens_the_error_bars_and_smaller_ones_are_noticed() {
    let case = cases().unwrap().remove(0);
    let draws = 150;
    let fits: Vec<_> = (0..draws as u64)
        .map(|seed| {
            let plane = &case.planes[0];
            let image = with_noise(&plane.render(case.model).unwrap(), case.noise, seed);
            fit(&plane.scene(image, Some(0.5 * case.noise)).unwrap())
        })
        .collect();
    let share = |scale: f64| {
        let inside = fits.iter().filter(|fit| {
            let sigma_s = compare(&fit.channels[0].1, case.planes[0].medium, Quantity::SigmaS);
            sigma_s.off().abs() < 1.96 * scale * sigma_s.std_error.unwrap()
        });
        inside.count() as f64 / draws as f64
    };
    // Half the noise would leave 67 of 100 intervals that hold the truth; the residual shows the rest.
    let allowed = 0.02 + NORMAL * (0.95f64 * 0.05 / draws as f64).sqrt();
    println!("{} of the intervals hold the truth, {} of those of half the width", share(1.0), share(0.5));
    assert!((share(1.0) - 0.95).abs() < allowed);
    assert!((share(0.5) - 0.95).abs() > allowed);
}
