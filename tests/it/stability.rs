//! The rule of no silent failure: what counts as one, and that a coarse map of where methods fail has none.

use crate::common::program::narrowbeam;
use narrowbeam::fit::WarningCode;
use narrowbeam::fit::noise::with_noise;
use narrowbeam::forward::Quantity;
use narrowbeam::lab::study::grid::plane;
use narrowbeam::lab::study::stability::{Found, Method, Outcome, OutcomeKind};
use narrowbeam::lab::study::trial::{Place, Tally, Trial};
use narrowbeam::lab::study::{Setting, Texture};
use narrowbeam::medium::Medium;
use narrowbeam::phase::b_of_spread_angle;
use narrowbeam::spread::Model;

/// What was found of parameters that are `error` off.
fn found(error: f64, std_error: f64, model_error: f64) -> Outcome {
    let found = |quantity| Found { quantity, error, std_error, model_error, held: false };
    let found = Quantity::MEDIUM.map(found).to_vec();
    Outcome { model: "small-angle".into(), found, ..Outcome::default() }
}

#[test]
fn an_error_that_nothing_stated_allows_is_a_silent_failure() {
    assert_eq!(found(0.039, 0.01, 0.0).kind(), OutcomeKind::Right);
    assert_eq!(found(-0.041, 0.01, 0.0).kind(), OutcomeKind::Silent);
    // The stated error of the model allows as much again, and no more.
    assert_eq!(found(0.059, 0.01, 0.02).kind(), OutcomeKind::Right);
    assert_eq!(found(0.061, 0.01, 0.02).kind(), OutcomeKind::Silent);
}

#[test]
fn what_is_said_is_not_silent() {
    let warned = Outcome { warnings: vec![WarningCode::Misfit], ..found(1.0, 0.01, 0.0) };
    assert_eq!(warned.kind(), OutcomeKind::Warned);
    let undetermined = Outcome { undetermined: true, ..Outcome::default() };
    assert_eq!(undetermined.kind(), OutcomeKind::Undetermined);
    let refused = Outcome { refused: Some("out of range".into()), ..Outcome::default() };
    assert_eq!(refused.kind(), OutcomeKind::Refused);
    // That one parameter is undetermined does not excuse another.
    let mut half = found(1.0, 0.01, 0.0);
    half.found.retain(|found| found.quantity != Quantity::Phase);
    half.undetermined = true;
    assert_eq!(half.kind(), OutcomeKind::Silent);
}

#[test]
fn a_tally_counts_silent_failures_and_needless_warnings() {
    let medium = Medium::gaussian(1.0, 0.1, b_of_spread_angle(0.1)).unwrap();
    let setting = Setting { texture: Texture::Checker, side: 8, pixel_pitch: 0.1, z: 1.0, medium };
    let trial = |sweep, outcome| Trial {
        place: Place::at(sweep, 0.0),
        setting,
        method: Method::of(Model::SmallAngle),
        outcome,
    };
    let warned = |warning| Outcome { warnings: vec![warning], ..found(0.01, 0.01, 0.0) };
    let trials = [
        trial("grid", found(0.01, 0.01, 0.0)),
        trial("grid", found(1.0, 0.01, 0.0)),
        trial("grid", warned(WarningCode::Structure)),
        // Outside of its validity, and where the world is not what the scene says, a warning is in its place.
        trial("grid", warned(WarningCode::OutsideValidity)),
        trial("saturated share", warned(WarningCode::Structure)),
    ];
    assert_eq!(Tally::of(&trials), Tally { fits: 5, silent: 1, right: 2, false_alarms: 1 });
}

#[test]
fn no_method_fails_silently_on_a_coarse_map() {
    let folder = tempfile::tempdir().unwrap();
    let output = narrowbeam(folder.path(), &["stability", "--quick", "--json", "--out", "made"]);
    let text = String::from_utf8(output.stderr).unwrap();
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{text}");
    assert_eq!(output.status.code(), Some(0));
    let csv = std::fs::read_to_string(folder.path().join("made/stability.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    let rows: Vec<Vec<&str>> = csv.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert!(rows.len() > 300 && rows.iter().all(|row| row.len() == columns));
    let kinds = |kind: OutcomeKind| rows.iter().filter(move |row| row[7] == kind.name());
    let silent: Vec<_> = kinds(OutcomeKind::Silent).collect();
    assert!(silent.is_empty(), "{silent:#?}");
    // Not because all is warned of.
    assert!(kinds(OutcomeKind::Right).count() > rows.len() / 10);
    let last = text.lines().last().unwrap();
    let numbers: Vec<f64> =
        last.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect();
    let [fits, false_alarms, right] = [numbers[1], numbers[2], numbers[3]];
    assert_eq!(fits as usize, rows.len());
    let [all, mine] = ["fits", "right"].map(|key| summary[key].as_f64().unwrap());
    assert_eq!((all, mine, &summary["silent"]), (fits, right, &0.into()));
    let counted = summary["methods"].as_array().unwrap().iter().map(|m| m["fits"].as_u64().unwrap());
    assert_eq!(counted.sum::<u64>() as usize, rows.len());
    assert!(false_alarms < 0.05 * right, "{last}");
    for picture in ["error", "verdict", "sweeps"] {
        for kind in ["png", "svg"] {
            assert!(folder.path().join(format!("made/stability_{picture}.{kind}")).is_file());
        }
    }
}

/// What the coarse map leaves out. Small-angle theory's simplex takes over a minute from here: the whole study has it.
#[test]
fn a_start_two_decades_too_wide_misleads_no_method_silently() {
    let simplex = Method::simplex(Model::WideAngle);
    for degrees in [6.0, 30.0] {
        let setting = plane(1.5, degrees, 32).unwrap();
        let clean = setting.render(Model::WideAngle).unwrap();
        let mut scene = setting.scene(with_noise(&clean, 0.005 * clean.mean(), 1), None).unwrap();
        let off = |quantity| if quantity == Quantity::SigmaA { 1.0 } else { 100.0 };
        let options = &mut scene.scene.fit[0];
        *options = options.started_at(|quantity| setting.truth(quantity) * off(quantity));
        for method in [Method::of(Model::SmallAngle), Method::of(Model::WideAngle), simplex] {
            let outcome = method.try_on(&scene, &setting, &Quantity::MEDIUM);
            println!("{degrees}°, {}: {:?}", method.name(), outcome.kind());
            assert_ne!(outcome.kind(), OutcomeKind::Silent, "{degrees}°, {}", method.name());
        }
    }
}
