//! The bundled datasets, made by programs that know nothing of the spread models: what comes back of their media.

mod common;

use narrowbeam::filter::Filter;
use narrowbeam::fit::Settings;
use narrowbeam::fit::scenes::{SceneFit, fit_scenes};
use narrowbeam::scene::{MediumValues, Purpose, Scene, read_truth};
use narrowbeam::spread::Model;
use std::path::{Path, PathBuf};

/// Names and folders of all bundled datasets.
fn datasets() -> Vec<(String, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets");
    let mut all: Vec<_> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().join("scene.toml").is_file())
        .map(|entry| (entry.file_name().into_string().unwrap(), entry.path()))
        .collect();
    all.sort();
    all
}

fn fit(folder: &Path, model: Model) -> SceneFit {
    let scene = Scene::read(&folder.join("scene.toml"), Purpose::Fit).unwrap();
    fit_scenes(&[scene], &Settings { model, ..Settings::default() }, Filter::Eq29).unwrap()
}

fn truth(folder: &Path) -> [f64; 3] {
    let MediumValues { sigma_s, sigma_a, b } = read_truth(&folder.join("truth.toml")).unwrap()[0];
    [sigma_s, sigma_a, b]
}

/// The project's promise for data that small-angle theory describes (tau·4B ≤ .06): sigma_s within 3 %, sigma_a z
/// within .02, B within 5 %. The theory's own error, .19 tau·4B of the transfer function, leaves room for that.
fn tolerance(truth: [f64; 3], z: f64) -> [f64; 3] {
    [0.03 * truth[0], 0.02 / z, 0.05 * truth[2]]
}

#[test]
fn every_dataset_gives_its_medium_back() {
    let all = datasets();
    println!(
        "dataset            parameter      truth   estimate  std error   error %   error/std   reduced chi²"
    );
    for (name, folder) in &all {
        let fit = fit(folder, Model::SmallAngle);
        let (_, channel) = &fit.channels[0];
        assert!(fit.report.is_complete(), "{name}: {:?}", fit.report.warnings);
        let truth = truth(folder);
        let allowed = tolerance(truth, channel.median_z);
        for (i, parameter) in ["sigma_s", "sigma_a", "b"].into_iter().enumerate() {
            let p = &fit.report.parameters[parameter];
            let (value, error) = (p["value"].as_f64().unwrap(), p["std_error"].as_f64().unwrap());
            let off = value - truth[i];
            println!(
                "{name:18} {parameter:10} {:9.5}  {value:9.5}  {error:9.2e}  {:8.2}   {:9.1}   {:12.3}",
                truth[i],
                100.0 * off / truth[i],
                off / error,
                channel.reduced_chi2
            );
            assert!(off.abs() <= allowed[i], "{name}: {parameter} = {value}, truth {}", truth[i]);
        }
    }
    let made_by = |maker: &str| all.iter().filter(|(name, _)| name.starts_with(maker)).count();
    assert!(made_by("mitsuba-") >= 2 && made_by("traced-") >= 2);
}

#[test]
fn the_tolerances_reject_the_medium_of_another_dataset() {
    let all = datasets();
    for (name, folder) in &all {
        let others = all.iter().filter(|(other, _)| other != name);
        for (_, other) in others {
            let (mine, theirs) = (truth(folder), truth(other));
            let allowed = tolerance(mine, 1.0);
            assert!((0..3).any(|i| (mine[i] - theirs[i]).abs() > allowed[i]));
        }
    }
}

#[test]
fn the_printed_kernel_gives_b_too_low_and_loses_sigma_s_in_thick_media() {
    // Fitted to the true transport the kernel with the second moment of eq. 21 puts B 26-57 % low, and in thick
    // media sigma_s runs away: its moment is up to three times too large, and its shape has too much weight near 0.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets");
    println!("dataset            tau    error of sigma_s, sigma_a, B in percent (narrow-beam-printed)");
    for (name, folder) in datasets() {
        let (_, channel) = &fit(&folder, Model::NarrowBeamPrinted).channels[0];
        let (truth, value) = (truth(&folder), channel.parameters.values());
        let error: Vec<f64> = (0..3).map(|i| 100.0 * (value[i] / truth[i] - 1.0)).collect();
        let tau = truth[0] * channel.median_z;
        println!("{name:18} {tau:4.2}   {:8.1} {:8.1} {:8.1}", error[0], error[1], error[2]);
        assert!(error[2] < -26.0, "{name}: B {} %", error[2]);
        if tau < 2.0 {
            assert!(error[2] > -57.0 && error[0].abs() < 15.0, "{name}: {error:?}");
        }
    }
    let thick = &fit(&root.join("mitsuba-slope"), Model::NarrowBeamPrinted);
    assert!(thick.channels[0].1.parameters.values()[0] > 2.0 * 1.2);
    assert!(!thick.report.is_complete() || !thick.report.warnings.is_empty());
}
