//! The bundled datasets, made by programs that know nothing of the spread models: what comes back of their media.

use crate::common::bundled::{dataset, fit};
use narrowbeam::filter::Filter;
use narrowbeam::fit::scenes::{SceneFit, fit_scenes};
use narrowbeam::fit::{NAMES, Settings};
use narrowbeam::scene::{FitOptions, Purpose, Scene, read_truth};
use narrowbeam::spread::Model;
use std::path::{Path, PathBuf};

/// Names and folders of the bundled datasets that small-angle theory describes.
fn datasets() -> Vec<(String, PathBuf)> {
    let beyond = |name: &str| ["wide-", "hg-"].iter().any(|prefix| name.starts_with(prefix));
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

fn truth(folder: &Path) -> [f64; 3] {
    let [sigma_s, sigma_a, b] = read_truth(&folder.join("truth.toml")).unwrap()[0].values();
    [sigma_s, sigma_a, b]
}

/// The project's promise for data that small-angle theory describes (tau·4B ≤ .06): sigma_s within 3 %, sigma_a z
/// within .02, B within 5 %. The theory's own error, .19 tau·4B of the transfer function, leaves room for that. The
/// staged sets are held to more in sigma_s and sigma_a: that error, up to 3 % of sigma_a and B at their depths, and
/// little besides; on the stage, a few screens stand for all edges.
fn tolerance(name: &str, truth: [f64; 3], z: f64) -> [f64; 3] {
    match name {
        "mitsuba-planes" | "mitsuba-tilt" => [0.01 * truth[0], 0.03 * truth[1], 0.05 * truth[2]],
        "mitsuba-stage" => [0.02 * truth[0], 0.05 * truth[1], 0.06 * truth[2]],
        _ => [0.03 * truth[0], 0.02 / z, 0.05 * truth[2]],
    }
}

/// The errors of sigma_s, sigma_a and B.
fn errors(fit: &SceneFit, truth: [f64; 3]) -> [f64; 3] {
    let values = fit.channels[0].1.parameters.values();
    std::array::from_fn(|i| values[i] - truth[i])
}

fn is_within(errors: [f64; 3], allowed: [f64; 3]) -> bool {
    (0..3).all(|i| errors[i].abs() <= allowed[i])
}

/// A row for each parameter; beside the errors those of eq29, if it is not what was fitted with.
fn print_rows(name: &str, fit: &SceneFit, truth: [f64; 3], eq29: Option<[f64; 3]>) {
    let (channel, errors) = (&fit.channels[0].1, errors(fit, truth));
    let tau_4b = 4.0 * truth[0] * truth[2] * channel.median_z;
    for (i, parameter) in NAMES.into_iter().enumerate() {
        let p = &fit.report.parameters[parameter];
        let (value, error) = (p["value"].as_f64().unwrap(), p["std_error"].as_f64().unwrap());
        let percent = |error: f64| format!("{:.2}", 100.0 * error / truth[i]);
        let [low, high] = [0, 1].map(|end| p["ci95"][end].as_f64().unwrap());
        println!(
            "{name:16} {:9} {tau_4b:4.3} {:7.3} {parameter:8} {:9.5} {value:9.5} {error:9.1e} {:>8} {:>8} {:10.1} {:>5} {:>8}",
            fit.report.filter,
            channel.reduced_chi2,
            truth[i],
            percent(p["model_error"].as_f64().unwrap()),
            percent(errors[i]),
            errors[i] / error,
            if (low..=high).contains(&truth[i]) { "yes" } else { "no" },
            eq29.map_or("-".into(), |e| percent(e[i]))
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
        let allowed = tolerance(name, truth, fit.channels[0].1.median_z);
        let beside = fit.report.filter == "composite";
        let eq29 = beside.then(|| errors(fit_by(Filter::Eq29), truth));
        print_rows(name, fit, truth, eq29);
        if !is_within(errors(fit, truth), allowed) {
            failed.push(name);
        }
        if let Some(eq29) = eq29
            && STAGED.contains(&name.as_str())
        {
            assert!(!is_within(eq29, allowed), "{name}: eq29 would do");
        }
    }
    assert!(failed.is_empty(), "not within their tolerances: {failed:?}");
    let made_by = |maker: &str| all.iter().filter(|(name, _)| name.starts_with(maker)).count();
    assert!(made_by("mitsuba-") >= 2 && made_by("traced-") >= 2);
}

#[test]
fn what_is_hidden_need_not_be_left_out_if_a_layer_shows_it() {
    let folder = dataset("mitsuba-planes");
    let scene = Scene::read(&folder.join("layers.toml"), Purpose::Fit).unwrap();
    let fit = fit_scenes(&[scene], &Settings::default(), Filter::Auto).unwrap();
    let (channel, truth) = (&fit.channels[0].1, truth(&folder));
    println!("{HEADING}");
    print_rows("planes, layers", &fit, truth, None);
    assert_eq!(channel.hidden_pixels, 0);
    assert!(is_within(errors(&fit, truth), tolerance("mitsuba-planes", truth, channel.median_z)));
}

#[test]
fn the_tolerances_reject_the_medium_of_another_dataset() {
    let all = datasets();
    for (name, folder) in &all {
        let others = all.iter().filter(|(other, _)| other != name);
        for (_, other) in others {
            let (mine, theirs) = (truth(folder), truth(other));
            let allowed = tolerance(name, mine, 1.0);
            assert!((0..3).any(|i| (mine[i] - theirs[i]).abs() > allowed[i]));
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
        let (truth, value) = (truth(&folder), channel.parameters.values());
        let error: Vec<f64> = (0..3).map(|i| 100.0 * (value[i] / truth[i] - 1.0)).collect();
        let tau = truth[0] * channel.median_z;
        println!("{name:18} {tau:4.2}   {:8.1} {:8.1} {:8.1}", error[0], error[1], error[2]);
        assert!(error[2] < -26.0, "{name}: B {} %", error[2]);
        if tau < 2.0 {
            assert!(error[2] > -57.0 && error[0].abs() < 15.0, "{name}: {error:?}");
        }
    }
    let thick = printed("mitsuba-slope");
    assert!(thick.channels[0].1.parameters.values()[0] > 2.0 * 1.2);
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
        assert!(small.report.warnings.iter().any(|w| w.code == "outside_validity"), "{name}");
        let (mine, theirs) = (errors(wide, truth), errors(small, truth));
        let parameters = &wide.channels[0].1.parameters;
        let scale = [truth[0], truth[1], parameters.family().slope(truth[2]).abs()];
        let mut worst: f64 = 0.0;
        for (i, parameter) in parameters.names().into_iter().enumerate() {
            let p = &wide.report.parameters[parameter];
            let [value, std_error, model_error] =
                ["value", "std_error", "model_error"].map(|key| p[key].as_f64().unwrap());
            println!(
                "{name:16} {:6.3} {parameter:8} {:9.5} {value:9.5} {std_error:9.1e} {model_error:9.1e} {:8.2} {:8.1}",
                wide.report.derived["validity"].as_f64().unwrap(),
                truth[i],
                100.0 * mine[i] / scale[i],
                100.0 * theirs[i] / scale[i],
            );
            let allowed = (0.02 * scale[i]).max(3.0 * std_error);
            outside += usize::from(mine[i].abs() > allowed);
            worst = worst.max(theirs[i].abs() / scale[i]);
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
        let mut scene = Scene::read(&folder.join("scene.toml"), Purpose::Fit).unwrap();
        scene.fit[0] = FitOptions::default();
        let settings = Settings { model: Model::WideAngle, ..Settings::default() };
        let fit = fit_scenes(&[scene], &settings, Filter::Auto).unwrap();
        let (values, truth) = (fit.channels[0].1.parameters.values(), truth(&folder));
        let codes: Vec<&str> = fit.report.warnings.iter().map(|w| w.code).collect();
        println!(
            "{name} as a Gaussian: sigma_s {:+.1} %, sigma_a {:+.1} %, reduced chi² {:.3}, structure {:.1}, {codes:?}",
            100.0 * (values[0] / truth[0] - 1.0),
            100.0 * (values[1] / truth[1] - 1.0),
            fit.channels[0].1.reduced_chi2,
            fit.channels[0].1.structure
        );
        assert!((values[0] / truth[0] - 1.0).abs() > 0.05, "{name}: a Gaussian would do");
        assert!(codes.contains(&"structure") || codes.contains(&"misfit"), "{name}: {codes:?}");
    }
}
