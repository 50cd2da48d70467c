//! The keys that name a phase function and give its shape.

use super::folder::{Folder, SCENE, and, with};
use narrowbeam::phase::{Family, PhaseFunction};
use narrowbeam::scene::{PartialMedium, read_truth};

const HG: Family = Family::HenyeyGreenstein;

#[test]
fn a_medium_has_the_phase_function_whose_parameter_it_gives() {
    let folder = Folder::new();
    let medium = |text: &str, overrides: PartialMedium| {
        let medium = folder.read(text).unwrap().media(overrides).unwrap()[0];
        (medium.phase().family(), medium.phase().parameter())
    };
    let nothing = PartialMedium::default();
    assert_eq!(medium(SCENE, nothing), (Family::Gaussian, 0.0049));
    assert_eq!(medium(&with("b = 0.0049", "g = 0.9"), nothing), (HG, 0.9));
    assert_eq!(medium(&with("b = 0.0049", "g = 0.9\nphase = \"hg\""), nothing), (HG, 0.9));
    assert_eq!(
        medium(&with("b = 0.0049", "b = 0.1\nphase = \"gaussian\""), nothing),
        (Family::Gaussian, 0.1)
    );
    // The command line's parameter comes with its own family.
    let g = PartialMedium { family: HG, phase_parameter: Some(0.8), ..nothing };
    assert_eq!(medium(SCENE, g), (HG, 0.8));
    let b = PartialMedium { phase_parameter: Some(0.1), ..nothing };
    assert_eq!(medium(&with("b = 0.0049", "phase = \"hg\""), b), (Family::Gaussian, 0.1));
}

#[test]
fn contradictions_in_the_medium_are_named() {
    let folder = Folder::new();
    folder.refuses(&and("g = 0.9"), &["scene.toml", "[medium] b and g are both given"]);
    folder.refuses(
        &with("b = 0.0049", "spread_angle_deg = 8\ng = 0.9"),
        &["[medium] spread_angle_deg and g are both given"],
    );
    folder.refuses(&and("phase = \"hg\""), &["[medium] b is given, but phase = \"hg\" has g"]);
    let gaussian = with("b = 0.0049", "g = 0.9\nphase = \"gaussian\"");
    folder.refuses(&gaussian, &["[medium] g is given, but phase = \"gaussian\" has b"]);
    folder.refuses(&and("phase = \"mie\""), &["scene.toml", "[medium] phase", "mie", "gaussian, hg"]);
    for g in ["0", "1", "-0.5", "nan"] {
        let text = with("b = 0.0049", &format!("g = {g}"));
        folder.refuses(&text, &["scene.toml", "[medium] g = ", "between 0 and 1"]);
    }
    let scene = folder.read(&with("b = 0.0049", "phase = \"hg\"")).unwrap();
    let message = scene.media(PartialMedium::default()).unwrap_err().to_string();
    assert!(message.contains("[medium] g is missing (or give --g)"), "{message}");
    let wrong = PartialMedium { family: HG, phase_parameter: Some(1.5), ..PartialMedium::default() };
    let message = scene.media(wrong).unwrap_err().to_string();
    assert!(message.contains("--g = 1.5") && message.contains("between 0 and 1"), "{message}");
}

#[test]
fn a_fit_names_its_own_phase_function() {
    let folder = Folder::new();
    let options = |text: &str| folder.observed(text).unwrap().scene.fit[0];
    // Whatever the [medium] says.
    let other = with("b = 0.0049", "g = 0.9\nphase = \"hg\"");
    assert_eq!((options(SCENE).family, options(&other).family), (Family::Gaussian, Family::Gaussian));
    let text = and("[fit]\nphase = \"hg\"\nstart = { g = 0.8 }\nbounds = { g = [0.5, 0.99] }");
    let read = options(&text);
    assert_eq!((read.family, read.phase.start, read.phase.bounds), (HG, Some(0.8), Some([0.5, 0.99])));
    assert_eq!(options(&and("[fit]\nphase = \"hg\"\nfixed = { g = 0.8 }")).phase.fixed, Some(0.8));
}

#[test]
fn options_of_another_phase_function_are_named() {
    let folder = Folder::new();
    for (table, value) in [("start", "0.9"), ("fixed", "0.9"), ("bounds", "[0.1, 0.9]")] {
        let key = format!("[fit] {table} g is given, but [fit] phase = \"gaussian\" has b");
        folder.refuses(&and(&format!("[fit]\n{table} = {{ g = {value} }}")), &["scene.toml", &key]);
    }
    folder.refuses(&and("[fit]\nphase = \"hg\"\nstart = { b = 0.1 }"), &["[fit] start b", "\"hg\" has g"]);
    folder.refuses(&and("[fit]\nphase = \"mie\""), &["scene.toml", "[fit] phase", "mie", "gaussian, hg"]);
    folder.refuses(&and("[fit]\nphase = 1"), &["fit.phase"]);
    let hg = |table: &str| and(&format!("[fit]\nphase = \"hg\"\n{table}"));
    folder.refuses(&hg("start = { g = 1 }"), &["[fit] start g = 1", "between 0 and 1"]);
    folder.refuses(&hg("fixed = { g = 0 }"), &["[fit] fixed g = 0"]);
    folder.refuses(&hg("bounds = { g = [0.5, 1.0] }"), &["[fit] bounds g = 1"]);
    folder.refuses(&hg("start = { g = 0.2 }\nbounds = { g = [0.5, 0.9] }"), &["[fit] start g = 0.2"]);
}

#[test]
fn the_truth_may_be_of_either_phase_function() {
    let folder = Folder::new();
    let path = folder.file("truth.toml");
    let truth = |text: &str| {
        std::fs::write(&path, text).unwrap();
        read_truth(&path)
    };
    let media = truth("[medium]\nsigma_s = 1\nsigma_a = 0\ng = [0.8, 0.85, 0.9]\n").unwrap();
    assert_eq!((media.len(), *media[2].phase()), (3, HG.phase(0.9).unwrap()));
    let message = truth("[medium]\nsigma_s = 1\nsigma_a = 0\n").unwrap_err().to_string();
    assert!(message.contains("truth.toml") && message.contains("[medium] b is missing"), "{message}");
}
