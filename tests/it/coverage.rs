//! Forty fresh scenes by Mitsuba (`scripts/coverage_mitsuba.py`): the stated intervals hold the truth, and no fit fails silently.

use crate::common::report::select;
use narrowbeam::filter::Filter;
use narrowbeam::fit::{Estimate, Fit, Settings, Severity};
use narrowbeam::scene::{ObservedScene, read_truth};
use std::path::{Path, PathBuf};

/// Share of all stated 95 % intervals that must hold the truth.
const LEAST: f64 = 0.93;
/// Standard errors beyond which, with the stated errors of the model, an estimate is wrong.
const WRONG: f64 = 4.0;

/// One estimate and its truth.
struct Found {
    scene: String,
    name: String,
    truth: f64,
    estimate: Estimate,
    warned: bool,
}

impl Found {
    fn off(&self) -> f64 {
        (self.estimate.value.expect("a value") - self.truth).abs()
    }

    /// Whether the interval, `scale` times as wide, holds the truth; `None` if there is none.
    fn held(&self, scale: f64) -> Option<bool> {
        let value = self.estimate.value?;
        let [low, high] = self.estimate.ci95?.map(|end| value + scale * (end - value));
        Some((low..=high).contains(&self.truth))
    }

    fn is_silent_failure(&self) -> bool {
        let stated = WRONG * self.estimate.std_error.unwrap_or(f64::INFINITY);
        !self.warned && self.off() > stated + self.estimate.model_error.unwrap_or(0.0)
    }
}

fn folders() -> Vec<PathBuf> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/coverage");
    let mut folders: Vec<PathBuf> =
        std::fs::read_dir(data).unwrap().map(|entry| entry.unwrap().path()).collect();
    folders.sort();
    folders
}

fn fit(folder: &Path) -> Fit {
    let files = ["scene-2.0.toml", "scene-1.0.toml"].map(|name| folder.join(name));
    let scenes: Vec<ObservedScene> =
        files.iter().filter(|file| file.exists()).map(|file| ObservedScene::read(file).unwrap()).collect();
    select(&scenes, &Settings::default(), Filter::Auto, 0.01, &|| ()).unwrap().report
}

fn found(folder: &Path) -> Vec<Found> {
    let fit = fit(folder);
    let truth = read_truth(&folder.join("truth.toml")).unwrap().remove(0);
    let warned = fit.warnings.iter().any(|warning| warning.severity >= Severity::Caution);
    let scene = folder.file_name().unwrap().to_str().unwrap();
    let names = fit.parameters.keys().zip(truth.parameters());
    names
        .map(|(name, truth)| Found {
            scene: scene.into(),
            name: name.clone(),
            truth,
            estimate: fit.parameters[name].clone(),
            warned,
        })
        .collect()
}

#[test]
fn stated_intervals_hold_the_truth_and_no_fit_fails_silently() {
    let all: Vec<Found> = folders().iter().flat_map(|folder| found(folder)).collect();
    assert_eq!(all.len(), 120);
    for missed in all.iter().filter(|found| found.held(1.0) == Some(false)) {
        println!(
            "{} {}: {:?}, truth {}",
            missed.scene,
            missed.name,
            missed.estimate.ci95.unwrap(),
            missed.truth
        );
    }
    let share = |scale: f64| {
        let stated: Vec<bool> = all.iter().filter_map(|found| found.held(scale)).collect();
        stated.iter().filter(|held| **held).count() as f64 / stated.len() as f64
    };
    let stated = all.iter().filter(|found| found.estimate.ci95.is_some()).count();
    println!(
        "{:.1} % of {stated} intervals hold the truth; of half as wide ones {:.1} %",
        100.0 * share(1.0),
        100.0 * share(0.5)
    );
    assert!(stated > 90, "too few are stated at all: {stated}");
    assert!(share(1.0) >= LEAST, "{}", share(1.0));
    assert!(share(0.5) < LEAST, "intervals half as wide would pass");
    let silent: Vec<String> = all
        .iter()
        .filter(|f| f.estimate.ci95.is_some() && f.is_silent_failure())
        .map(|f| format!("{} {}", f.scene, f.name))
        .collect();
    assert!(silent.is_empty(), "{silent:?}");
}
