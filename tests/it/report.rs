//! The report of a fit as a type and as a schema: `docs/fit.schema.json` is made from the types.

use crate::common::bundled::dataset;
use crate::common::program::succeeds;
use crate::common::report::{conforms, read, schema, schema_path};
use serde_json::{Value, json};

/// `NARROWBEAM_UPDATE=1 cargo test --release --test it report::` writes it.
#[test]
fn the_schema_that_is_kept_is_that_of_the_types() {
    if std::env::var_os("NARROWBEAM_UPDATE").is_some() {
        std::fs::write(schema_path(), schema()).unwrap();
    }
    let kept = std::fs::read_to_string(schema_path()).unwrap_or_default();
    assert!(kept == schema(), "docs/fit.schema.json is stale; NARROWBEAM_UPDATE=1 makes it again");
}

/// A report of the program.
fn report() -> Value {
    let folder = tempfile::tempdir().unwrap();
    let scene = dataset("mitsuba-checker/scene.toml");
    let scene = scene.to_str().unwrap();
    let json = succeeds(folder.path(), &["fit", scene, "--model", "small-angle", "--json"]);
    read(&json);
    serde_json::from_str(&json).unwrap()
}

#[test]
fn a_report_that_lacks_a_key_or_has_a_wrong_type_is_rejected() {
    let report = report();
    conforms(&report).unwrap();
    let keys = [
        "/version",
        "/fit/chi2",
        "/parameters/sigma_s/std_error",
        "/exposures/0/gain/value",
        "/backend/kind",
    ];
    for key in keys {
        let (parent, name) = key.rsplit_once('/').unwrap();
        let mut lacking = report.clone();
        lacking.pointer_mut(parent).unwrap().as_object_mut().unwrap().remove(name).unwrap();
        assert!(conforms(&lacking).unwrap_err().contains(name), "{key}");
    }
    let wrong = [
        ("/version", json!(1)),
        ("/fit/chi2", json!(null)),
        ("/fit/pixels", json!(-1)),
        ("/parameters/sigma_s/value", json!("0.8")),
        ("/parameters/sigma_s/status", json!("loose")),
        ("/parameters/sigma_s/ci95", json!([0.7])),
        ("/exposures/0/noise", json!([])),
        ("/derived/tau", json!(true)),
        ("/warnings", json!([{ "code": "unheard_of", "severity": "note", "message": "" }])),
        ("/warnings", json!([{ "code": "misfit", "severity": "fatal", "message": "" }])),
    ];
    for (key, value) in wrong {
        let mut off = report.clone();
        *off.pointer_mut(key).unwrap() = value;
        assert!(conforms(&off).is_err(), "{key}");
    }
    let mut warned = report.clone();
    warned["warnings"] = json!([{ "code": "misfit", "severity": "caution", "message": "" }]);
    conforms(&warned).unwrap();
}
