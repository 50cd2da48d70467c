//! Reports as other programs read them: as a typed [`Fit`], and by the schema `docs/fit.schema.json`.

use boon::{Compiler, SchemaIndex, Schemas};
use narrowbeam::Result as Fallible;
use narrowbeam::filter::Filter;
use narrowbeam::fit::{self, Fit, SceneFit, Settings};
use narrowbeam::scene::ObservedScene;
use schemars::generate::SchemaSettings;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The schema that the types have, as text.
pub fn schema() -> String {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    serde_json::to_string_pretty(&generator.into_root_schema_for::<Fit>()).unwrap() + "\n"
}

/// Where the schema is kept.
pub fn schema_path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/fit.schema.json")
}

/// What is wrong with a report by the schema that is kept.
pub fn conforms(report: &Value) -> Result<(), String> {
    thread_local! {
        static SCHEMA: (Schemas, SchemaIndex) = {
            let (mut schemas, mut compiler) = (Schemas::new(), Compiler::new());
            let text = std::fs::read_to_string(schema_path()).unwrap();
            compiler.add_resource("fit.json", serde_json::from_str(&text).unwrap()).unwrap();
            let index = compiler.compile("fit.json", &mut schemas).unwrap();
            (schemas, index)
        };
    }
    SCHEMA.with(|(schemas, index)| schemas.validate(report, *index).map_err(|error| format!("{error:#}")))
}

/// The report in `json`, which must conform to the schema and be the same after it was read as a [`Fit`] and written again.
pub fn read(json: &str) -> Fit {
    conforms(&serde_json::from_str(json).unwrap()).unwrap_or_else(|why| panic!("{why}\n{json}"));
    let fit: Fit = serde_json::from_str(json).unwrap_or_else(|why| panic!("{why}\n{json}"));
    assert_eq!(serde_json::to_string_pretty(&fit).unwrap(), json.trim_end());
    fit
}

/// Reads all reports that a run of the program with `arguments` in `dir` has made: on `stdout` and in its folder.
pub fn read_all(dir: &Path, arguments: &[&str], stdout: &str) {
    if arguments.contains(&"--json") {
        read(stdout);
    }
    if arguments[0] == "fit" {
        let out = arguments.iter().position(|a| *a == "--out").map_or("narrowbeam-fit", |i| arguments[i + 1]);
        read(&std::fs::read_to_string(dir.join(out).join("fit.json")).unwrap());
    }
}

/// [`fit::fit_scenes`], whose report must conform.
pub fn fit_scenes(
    scenes: &[ObservedScene],
    settings: &Settings,
    filter: Filter,
    progress: &dyn Fn(),
) -> Fallible<SceneFit> {
    fit::fit_scenes(scenes, settings, filter, progress).inspect(|fit| check(&fit.report))
}

/// [`fit::select`], whose report must conform.
pub fn select(
    scenes: &[ObservedScene],
    settings: &Settings,
    filter: Filter,
    tolerance: f64,
    progress: &dyn Fn(),
) -> Fallible<SceneFit> {
    fit::select(scenes, settings, filter, tolerance, progress).inspect(|fit| check(&fit.report))
}

fn check(fit: &Fit) {
    read(&serde_json::to_string_pretty(fit).unwrap());
}
