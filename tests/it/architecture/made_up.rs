//! The rules reject made-up violations.

use super::rules::{Rule, circle, circles, imports_within, long_files, long_functions, reached, strays};
use super::source::File;
use super::{CRATES, LAYERS, MOST_LINES, NEVER, ROOMS, complaints, fit, none};

/// The complaints about a tree of these files.
fn about(files: &[(&str, &str)], parent: &[String], rules: &[Rule]) -> Vec<String> {
    let files: Vec<File> = files.iter().map(|(path, text)| File::new(path, text)).collect();
    complaints(&files, parent, rules)
}

#[test]
fn a_tracer_that_imports_kernels_filters_or_fits_is_rejected() {
    for banned in ["spread", "filter", "fit", "forward", "lab"] {
        let module = (format!("src/{banned}/mod.rs"), "");
        let ways = [
            format!("use crate::{banned}::Thing;"),
            format!("use crate::{{image::Image, {banned}::{{Thing, other::Thing as Another}}}};"),
            format!("fn f() -> f64 {{\n    crate::{banned}::thing()\n}}"),
            format!("use super::super::{banned};"),
            format!("mod tests {{\n    use super::super::super::{banned}::Thing;\n}}"),
            format!("const QUOTE: char = '\"';\nuse crate::{banned}::Thing;\nconst END: char = '\"';"),
        ];
        for way in &ways {
            let files = [("src/trace/path.rs", way.as_str()), (&module.0, module.1), ("src/image.rs", "")];
            let found = about(&files, &[], LAYERS);
            let expected = format!("src/trace/path.rs: trace must not import {banned}");
            assert!(found.contains(&expected), "{way}: {found:?}");
        }
        let harmless = [
            format!("// use crate::{banned}::Thing;"),
            format!("/* use crate::{banned}::Thing; */"),
            format!("const TEXT: &str = \"use crate::{banned}::Thing;\";"),
            format!("const TEXT: &str = r#\"\"use crate::{banned}::Thing;\"\"#;"),
            format!("fn f<'a>(x: &'a str) {{}} // 'crate::{banned}::Thing'"),
        ];
        for text in &harmless {
            let files = [("src/trace/path.rs", text.as_str()), (&module.0, module.1)];
            assert!(about(&files, &[], LAYERS).is_empty(), "{text}");
        }
    }
}

#[test]
fn imports_through_a_facade_count() {
    let facade = ("src/fit/mod.rs", "mod report;\nmod optimise;\npub use report::{Fit as Report, Other};");
    let files = |text| [facade, ("src/fit/report/mod.rs", ""), ("src/fit/optimise/solver.rs", text)];
    for text in ["use crate::fit::Report;", "use super::super::Other;", "use crate::fit::report::Fit;"] {
        let found = about(&files(text), &fit(), ROOMS);
        assert_eq!(found, ["src/fit/optimise/solver.rs: optimise must not import report"], "{text}");
    }
    let found = about(&files("use super::super::*;"), &fit(), ROOMS);
    assert_eq!(found, ["src/fit/optimise/solver.rs: optimise must not import *"]);
    let root = [("src/lib.rs", "pub use fit::Fit;"), ("src/trace/mod.rs", "use crate::Fit;"), facade];
    assert_eq!(about(&root, &[], LAYERS), ["src/trace/mod.rs: trace must not import fit"]);
}

#[test]
fn a_module_without_a_rule_is_rejected() {
    assert_eq!(about(&[("src/helpers.rs", "")], &[], LAYERS), ["no rule says what helpers may import"]);
}

#[test]
fn a_way_round_through_another_module_is_rejected() {
    let files = [
        File::new("src/trace/mod.rs", "use crate::geometry::Geometry;"),
        File::new("src/geometry/mod.rs", "use crate::relief::Relief;"),
        File::new("src/relief/mod.rs", "use crate::spread::Model;"),
        File::new("src/spread/mod.rs", ""),
    ];
    assert_eq!(reached(&imports_within(&files, &[]), NEVER), ["trace reaches spread"]);
}

#[test]
fn a_circle_is_rejected() {
    let files = |back| {
        [
            File::new("src/fit/mod.rs", "pub use report::Fit;"),
            File::new("src/fit/optimise/mod.rs", "use super::inference::Covariance;"),
            File::new("src/fit/inference/covariance.rs", "use crate::fit::Fit;"),
            File::new("src/fit/report/text.rs", back),
        ]
    };
    assert_eq!(circles(&files("use super::Fit;")), none());
    assert_eq!(
        circles(&files("use super::super::optimise::Method;")),
        ["in fit: inference → report → optimise → inference"]
    );
    let two = [File::new("src/a.rs", "use crate::b::B;"), File::new("src/b.rs", "use crate::a::A;")];
    assert_eq!(circle(&imports_within(&two, &[])).as_deref(), Some("a → b → a"));
}

#[test]
fn a_crate_out_of_place_is_rejected() {
    let files = [
        File::new("src/fit/optimise/search.rs", "use argmin::core::Error;"),
        File::new(
            "src/fit/settings.rs",
            "#[cfg_attr(feature = \"cli\", derive(clap::ValueEnum))]\nenum E {}",
        ),
        File::new("src/fit/report/mod.rs", "/// Not by `serde_json`.\nfn json() {}"),
        File::new("src/filter/gpu/fft.rs", "use wgpu::Buffer;"),
    ];
    let expected = ["src/fit/optimise/search.rs mentions argmin", "src/fit/settings.rs mentions clap"];
    assert_eq!(strays(&files, CRATES), expected);
}

#[test]
fn long_files_and_functions_are_rejected() {
    let body = |lines: usize| "        x();\n".repeat(lines);
    let text = format!(
        "impl A {{\n    pub(super) fn long<T>(\n        a: T,\n    ) {{\n{}    }}\n\n    fn short(&self) {{\n{}    }}\n}}\n\
         trait B {{\n    fn declared(&self);\n}}\n",
        body(57),
        body(58)
    );
    let files = [File::new("src/fit/a.rs", &text), File::new("src/b.rs", &"\n".repeat(301))];
    assert_eq!(files[0].functions(), [("long".into(), 61), ("short".into(), 60), ("declared".into(), 1)]);
    assert_eq!(long_functions(&files, "src/fit/", 60), ["src/fit/a.rs: long has 61 lines"]);
    assert_eq!(long_files(&files, "src/", MOST_LINES), ["src/b.rs has 301 lines"]);
}
