//! `--model auto` where the composite filter is the weak link: it goes on to traced paths, or says that it did not.

use crate::common::program::narrowbeam;
use crate::common::report::read;
use narrowbeam::fit::{Fit, Severity, Status};
use std::path::Path;

/// The fit of the ball with some options: exit code, report and what stderr says.
fn fit(options: &[&str]) -> (Option<i32>, Fit, String) {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/ball/scene.toml");
    let folder = tempfile::tempdir().unwrap();
    let mut arguments = vec!["fit", scene.to_str().unwrap(), "--out", "made"];
    arguments.extend(options);
    let output = narrowbeam(folder.path(), &arguments);
    let report = read(&std::fs::read_to_string(folder.path().join("made/fit.json")).unwrap());
    (output.status.code(), report, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn edges_that_decide_a_fit_are_left_to_traced_paths() {
    let (code, report, stderr) = fit(&[]);
    assert_eq!(code, Some(0), "{stderr}");
    assert!(stderr.contains("tracing paths instead") && stderr.contains("--traced-limit"), "{stderr}");
    assert_eq!(report.model, "traced");
    assert!(report.candidates.last().unwrap().taken);
    let truth =
        [("sigma_s", 0.5, 0.01), ("sigma_a", 0.05, 0.02), ("b", 9.0_f64.to_radians().powi(2) / 4.0, 0.02)];
    for (name, truth, bound) in truth {
        let off = report.parameters[name].value.unwrap() / truth - 1.0;
        println!("{name}: {:+.2} %", 100.0 * off);
        assert!(off.abs() < bound, "{name}: {off}");
    }
}

#[test]
fn a_fit_that_may_not_trace_does_not_pass_for_good() {
    let (code, report, stderr) = fit(&["--traced-limit", "0.001"]);
    assert_eq!(code, Some(3), "{stderr}");
    let left_out = report.candidates.last().unwrap();
    assert!(
        left_out.model == "traced" && left_out.shortcoming.as_ref().unwrap().contains("tracing takes about")
    );
    assert!(report.warnings.iter().any(|warning| warning.severity == Severity::Invalid));
    assert_eq!(report.parameters["sigma_s"].status, Status::Doubtful);
    let (_, never, _) = fit(&["--traced-limit", "0"]);
    assert!(never.candidates.iter().all(|candidate| candidate.model != "traced"));
}
