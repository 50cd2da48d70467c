//! The bundled datasets, made by programs that know nothing of the spread models: what comes back of their media.

use crate::common::bundled::{dataset, fit};
use crate::common::estimates::{Compared, compare, compare_all, value_of};
use crate::common::report::fit_scenes;
use narrowbeam::filter::Filter;
use narrowbeam::fit::{SceneFit, Settings, WarningCode};
use narrowbeam::forward::Quantity;
use narrowbeam::medium::Medium;
use narrowbeam::phase::PhaseFunction;
use narrowbeam::scene::{FitOptions, ObservedScene, read_truth};
use narrowbeam::spread::Model;
use std::path::{Path, PathBuf};

/// Names and folders of the bundled datasets that small-angle theory describes, and whose camera did nothing else.
fn datasets() -> Vec<(String, PathBuf)> {
    let beyond = |name: &str| ["wide-", "hg-", "photo-"].iter().any(|prefix| name.starts_with(prefix));
    folders().into_iter().filter(|(name, _)| !beyond(name)).collect()
}

/// Names and folders of all bundled datasets.
fn folders() -> Vec<(String, PathBuf)> {
    let mut all: Vec<_> = std::fs::read_dir(dataset(""))
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().join("scene.toml").is_file())
        .map(|entry| (entry.file_name().into_string().unwrap(), entry.path()))
        .collect();
    all.sort();
    all
}

/// Sets of parted depths, observed by Mitsuba from whole shapes.
const STAGED: [&str; 3] = ["mitsuba-planes", "mitsuba-stage", "mitsuba-tilt"];

fn truth(folder: &Path) -> Medium {
    read_truth(&folder.join("truth.toml")).unwrap()[0]
}

/// The project's promise for data that small-angle theory describes (tau·4B ≤ .06): sigma_s within 3 %, sigma_a z
/// within .02, B within 5 %. The theory's own error, .19 tau·4B of the transfer function, leaves room for that. The
/// staged sets are held to more in sigma_s and sigma_a: that error, up to 3 % of sigma_a and B at their depths, and
/// little besides; on the stage, a few screens stand for all edges.
fn tolerance(name: &str, truth: Medium, z: f64, quantity: Quantity) -> f64 {
    let truth = value_of(truth, quantity);
    match (name, quantity) {
        ("mitsuba-planes" | "mitsuba-tilt", Quantity::SigmaS) => 0.01 * truth,
        ("mitsuba-planes" | "mitsuba-tilt", Quantity::SigmaA) => 0.03 * truth,
        ("mitsuba-stage", Quantity::SigmaS) => 0.02 * truth,
        ("mitsuba-stage", Quantity::SigmaA) => 0.05 * truth,
        ("mitsuba-stage", _) => 0.06 * truth,
        (_, Quantity::SigmaS) => 0.03 * truth,
        (_, Quantity::SigmaA) => 0.02 / z,
        _ => 0.05 * truth,
    }
}

/// Whether `fit` holds the `truth` of the dataset `name`.
fn is_within(name: &str, fit: &SceneFit, truth: Medium) -> bool {
    let (_, fit) = &fit.channels[0];
    let allowed = |quantity| tolerance(name, truth, fit.median_z, quantity);
    compare_all(fit, truth).iter().all(|found| found.error().abs() <= allowed(found.quantity))
}

/// A row for each parameter; beside the errors those of eq29, if it is not what was fitted with.
fn print_rows(name: &str, fit: &SceneFit, truth: Medium, eq29: Option<&SceneFit>) {
    let channel = &fit.channels[0].1;
    let tau_4b = 4.0 * truth.sigma_s() * truth.phase().parameter() * channel.median_z;
    for found in compare_all(channel, truth) {
        let (parameter, value, truth_here) = (found.name(), found.value(), found.truth);
        let p = &fit.report.parameters[parameter];
        let error = p.std_error.unwrap();
        let percent = |error: f64| format!("{:.2}", 100.0 * error / truth_here);
        let [low, high] = p.ci95.unwrap();
        let by_eq29 = eq29.map(|fit| compare(&fit.channels[0].1, truth, found.quantity).error());
        println!(
            "{name:16} {:9} {tau_4b:4.3} {:7.3} {parameter:8} {truth_here:9.5} {value:9.5} {error:9.1e} {:>8} {:>8} {:10.1} {:>5} {:>8}",
            fit.report.filter,
            channel.reduced_chi2,
            percent(p.model_error.unwrap()),
            percent(found.error()),
            found.error() / error,
            if (low..=high).contains(&truth_here) { "yes" } else { "no" },
            by_eq29.map_or("-".into(), percent)
        );
    }
}

const HEADING: &str = "dataset          filter   tau·4B    chi² parameter    truth  estimate std error  model %  error % \
                       error/std  ci95   eq29 %";

#[test]
fn every_dataset_gives_its_medium_back() {
    let all = datasets();
    let mut failed = Vec::new();
    println!("{HEADING}");
    for (name, folder) in &all {
        let (fit_by, truth) = (|filter| fit(name, Model::SmallAngle, filter), truth(folder));
        let fit = fit_by(Filter::Auto);
        assert!(fit.report.is_complete(), "{name}: {:?}", fit.report.warnings);
        let beside = fit.report.filter == "composite";
        let eq29 = beside.then(|| fit_by(Filter::Eq29));
        print_rows(name, fit, truth, eq29);
        if !is_within(name, fit, truth) {
            failed.push(name);
        }
        if let Some(eq29) = eq29
            && STAGED.contains(&name.as_str())
        {
            assert!(!is_within(name, eq29, truth), "{name}: eq29 would do");
        }
    }
    assert!(failed.is_empty(), "not within their tolerances: {failed:?}");
    let made_by = |maker: &str| all.iter().filter(|(name, _)| name.starts_with(maker)).count();
    assert!(made_by("mitsuba-") >= 2 && made_by("traced-") >= 2);
}

#[test]
fn what_is_hidden_need_not_be_left_out_if_a_layer_shows_it() {
    let folder = dataset("mitsuba-planes");
    let scene = ObservedScene::read(&folder.join("layers.toml")).unwrap();
    let fit = fit_scenes(&[scene], &Settings::default(), Filter::Auto, &|| ()).unwrap();
    let (channel, truth) = (&fit.channels[0].1, truth(&folder));
    println!("{HEADING}");
    print_rows("planes, layers", &fit, truth, None);
    assert_eq!(channel.hidden_pixels, 0);
    assert!(is_within("mitsuba-planes", &fit, truth));
}

#[test]
fn the_tolerances_reject_the_medium_of_another_dataset() {
    let all = datasets();
    for (name, folder) in &all {
        let others = all.iter().filter(|(other, _)| other != name);
        for (_, other) in others {
            let (mine, theirs) = (truth(folder), truth(other));
            let apart = |quantity| (value_of(mine, quantity) - value_of(theirs, quantity)).abs();
            assert!(Quantity::MEDIUM.into_iter().any(|q| apart(q) > tolerance(name, mine, 1.0, q)));
        }
    }
}

#[test]
fn the_printed_kernel_gives_b_too_low_and_loses_sigma_s_in_thick_media() {
    // Fitted to the true transport the kernel with the second moment of eq. 21 puts B 26-57 % low, and in thick
    // media sigma_s runs away: its moment is up to three times too large, and its shape has too much weight near 0.
    // The staged sets span too many depths to be thin or thick.
    println!("dataset            tau    error of sigma_s, sigma_a, B in percent (narrow-beam-printed)");
    let printed = |name: &str| fit(name, Model::NarrowBeamPrinted, Filter::Eq29);
    for (name, folder) in datasets().into_iter().filter(|(name, _)| !STAGED.contains(&name.as_str())) {
        let (_, channel) = &printed(&name).channels[0];
        let truth = truth(&folder);
        let percent = |quantity| 100.0 * compare(channel, truth, quantity).relative_error();
        let [sigma_s, sigma_a, b] = Quantity::MEDIUM.map(percent);
        let tau = truth.tau(channel.median_z);
        println!("{name:18} {tau:4.2}   {sigma_s:8.1} {sigma_a:8.1} {b:8.1}");
        assert!(b < -26.0, "{name}: B {b} %");
        if tau < 2.0 {
            assert!(b > -57.0 && sigma_s.abs() < 15.0, "{name}: {sigma_s} {b}");
        }
    }
    let thick = printed("mitsuba-slope");
    assert!(thick.channels[0].1.parameters["sigma_s"].value() > 2.0 * 1.2);
    assert!(!thick.report.is_complete() || !thick.report.warnings.is_empty());
}

/// Holds the wide-angle fits of the sets whose names begin with `prefix` to the promise, and shows the errors of small-angle
/// theory beside theirs.
///
/// The promise is 2 % or three standard errors, whichever is larger; of g it is 2 % of 1 - g, to which the lobe's width is nearly
/// proportional.
fn give_back_to_wide_angle_alone(prefix: &str, least: usize) {
    println!(
        "dataset          validity parameter   truth  estimate std error model err.  error %  small-angle %"
    );
    let mut outside = 0;
    let sets: Vec<_> = folders().into_iter().filter(|(name, _)| name.starts_with(prefix)).collect();
    assert!(sets.len() >= least);
    for (name, folder) in &sets {
        let truth = truth(folder);
        let [wide, small] = [Model::WideAngle, Model::SmallAngle].map(|model| fit(name, model, Filter::Auto));
        assert!(
            wide.report.is_complete() && wide.report.warnings.is_empty(),
            "{name}: {:?}",
            wide.report.warnings
        );
        assert!(small.report.warnings.iter().any(|w| w.code == WarningCode::OutsideValidity), "{name}");
        let scale = |found: &Compared| match found.quantity {
            Quantity::Phase => found.slope_at_truth(),
            _ => found.truth,
        };
        let mut worst: f64 = 0.0;
        for mine in compare_all(&wide.channels[0].1, truth) {
            let theirs = compare(&small.channels[0].1, truth, mine.quantity);
            let (parameter, scale) = (mine.name(), scale(&mine));
            let p = &wide.report.parameters[parameter];
            let [value, std_error, model_error] = [p.value, p.std_error, p.model_error].map(Option::unwrap);
            println!(
                "{name:16} {:6.3} {parameter:8} {:9.5} {value:9.5} {std_error:9.1e} {model_error:9.1e} {:8.2} {:8.1}",
                wide.report.derived["validity"].value().unwrap(),
                mine.truth,
                100.0 * mine.error() / scale,
                100.0 * theirs.error() / scale,
            );
            let allowed = (0.02 * scale).max(3.0 * std_error);
            outside += usize::from(mine.error().abs() > allowed);
            worst = worst.max(theirs.error().abs() / scale);
        }
        assert!(worst > 0.05, "{name}: small-angle theory would do");
    }
    assert_eq!(outside, 0);
}

#[test]
fn wide_angles_give_their_medium_back_to_the_wide_angle_model_alone() {
    give_back_to_wide_angle_alone("wide-", 5);
}

#[test]
fn henyey_greenstein_gives_its_medium_back_to_the_wide_angle_model_alone() {
    give_back_to_wide_angle_alone("hg-", 1);
}

#[test]
fn henyey_greenstein_fitted_as_a_gaussian_is_off_and_warned_of() {
    for (name, folder) in folders().into_iter().filter(|(name, _)| name.starts_with("hg-")) {
        let mut scene = ObservedScene::read(&folder.join("scene.toml")).unwrap();
        scene.scene.fit[0] = FitOptions::default();
        let settings = Settings { model: Model::WideAngle, ..Settings::default() };
        let fit = fit_scenes(&[scene], &settings, Filter::Auto, &|| ()).unwrap();
        let (channel, truth) = (&fit.channels[0].1, truth(&folder));
        let error = |quantity| compare(channel, truth, quantity).relative_error();
        let [sigma_s, sigma_a] = [Quantity::SigmaS, Quantity::SigmaA].map(error);
        let codes: Vec<WarningCode> = fit.report.warnings.iter().map(|w| w.code).collect();
        println!(
            "{name} as a Gaussian: sigma_s {:+.1} %, sigma_a {:+.1} %, reduced chi² {:.3}, lack of fit {:.1}, {codes:?}",
            100.0 * sigma_s,
            100.0 * sigma_a,
            channel.reduced_chi2,
            channel.lack_of_fit
        );
        assert!(sigma_s.abs() > 0.05, "{name}: a Gaussian would do");
        let warns_of = |code| codes.contains(&code);
        assert!(warns_of(WarningCode::Structure) || warns_of(WarningCode::Misfit), "{name}: {codes:?}");
    }
}
