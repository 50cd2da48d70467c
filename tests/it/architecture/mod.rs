//! The shape of the library: who may import whom, where foreign crates belong, how long files and functions get. ARCHITECTURE.md
//! draws the same picture.

mod made_up;
mod rules;
mod source;

use rules::{Rule, circles, forbidden, imports_within, long_files, long_functions, reached, strays, words};
use source::File;
use std::collections::BTreeSet;

/// What each layer may import, from the bottom up.
const LAYERS: &[Rule] = &[
    ("error", ""),
    ("memory", "error"),
    ("chebyshev", ""),
    ("quadrature", ""),
    ("image", ""),
    ("imaging", ""),
    ("phase", "error quadrature"),
    ("medium", "error phase"),
    ("geometry", "error image"),
    ("relief", "image geometry"),
    ("io", "error memory image"),
    ("gpu", "error"),
    ("plots", "error image io"),
    ("spread", "error chebyshev quadrature phase medium"),
    ("trace", "error memory chebyshev image phase medium geometry"),
    ("illumination", "error quadrature image phase medium geometry relief"),
    ("scene", "error image imaging phase medium geometry io illumination"),
    ("filter", "error memory chebyshev quadrature image imaging phase medium geometry relief gpu spread"),
    ("synthesis", "error image medium spread illumination scene filter"),
    ("forward", "error memory quadrature image imaging phase medium geometry relief spread trace filter"),
    ("fit", "error image imaging phase medium geometry relief spread scene filter forward"),
    (
        "lab",
        "error quadrature image imaging phase medium geometry relief io spread trace illumination scene filter synthesis forward fit",
    ),
    (
        "cli",
        "error memory image phase medium geometry io gpu plots spread trace scene filter synthesis forward fit lab",
    ),
    ("main", "cli"),
];

/// What a layer must not even reach by way of others. The tracer is the independent witness.
const NEVER: &[Rule] = &[
    ("trace", "spread filter forward fit lab cli"),
    ("scene", "spread filter forward fit cli"),
    ("forward", "scene fit lab cli"),
    ("fit", "plots lab cli"),
    ("lab", "plots cli"),
];

/// The same for the rooms of `fit`, as data go: what is given, the optimum, what is known there, the report, and what chooses
/// models and measurements.
const ROOMS: &[Rule] = &[
    ("settings", ""),
    ("parameters", ""),
    ("observation", ""),
    ("optimise", "settings parameters observation"),
    ("inference", "parameters observation optimise"),
    ("channel", "settings observation optimise inference"),
    ("interval", "settings parameters observation inference channel"),
    ("report", "settings parameters inference channel"),
    ("slips", "report"),
    ("scenes", "settings parameters observation inference channel interval report slips"),
    ("select", "settings parameters observation optimise inference report scenes"),
    ("design", "settings parameters observation inference report scenes select"),
];

/// Foreign crates, and where alone they are mentioned.
const CRATES: &[Rule] = &[
    ("argmin", "src/fit/optimise/solver.rs"),
    ("anyhow", "src/cli/"),
    ("clap", "src/cli/"),
    ("indicatif", "src/cli/"),
    ("serde_json", "src/cli/"),
    ("sha2", "src/cli/results/"),
    ("rustix", "src/cli/console.rs src/cli/results/"),
    ("signal_hook", "src/cli/signals.rs"),
    ("plotters", "src/plots/"),
    ("zune_hdr", "src/io/picture/"),
    ("zune_jpeg", "src/io/picture/"),
    ("wgpu", "src/gpu/ src/filter/gpu/"),
];

/// The streams of the program, and where alone they are written to, or asked whether they are terminals. `print!` and its like
/// are lints.
const STREAMS: &[Rule] =
    &[("stdout", "src/cli/console.rs"), ("stderr", "src/cli/console.rs src/cli/progress.rs")];

/// Lines that a file, the façade of `fit` and a function of `fit` have at most.
const MOST_LINES: usize = 300;
const MOST_FACADE_LINES: usize = 59;
const MOST_FUNCTION_LINES: usize = 60;

fn fit() -> Vec<String> {
    vec!["fit".into()]
}

/// The modules right below `parent`.
fn children(files: &[File], parent: &[String]) -> BTreeSet<String> {
    let below = files.iter().filter(|f| f.module.starts_with(parent));
    below.filter_map(|f| f.module.get(parent.len()).cloned()).collect()
}

/// What is wrong with imports between the children of `parent`.
fn complaints(files: &[File], parent: &[String], rules: &[Rule]) -> Vec<String> {
    forbidden(&imports_within(files, parent), &children(files, parent), rules)
}

fn none() -> Vec<String> {
    Vec::new()
}

#[test]
fn layers_import_only_what_lies_below() {
    let files = File::all();
    assert_eq!(complaints(&files, &[], LAYERS), none());
    assert_eq!(reached(&imports_within(&files, &[]), NEVER), none());
}

#[test]
fn rooms_of_fit_import_only_earlier_ones() {
    assert_eq!(complaints(&File::all(), &fit(), ROOMS), none());
}

#[test]
fn rules_name_existing_modules_in_order() {
    let files = File::all();
    for (parent, rules) in [(vec![], LAYERS), (fit(), ROOMS)] {
        let graph = imports_within(&files, &parent);
        for (i, (name, allowed)) in rules.iter().enumerate() {
            let above = |other: &str| rules[..i].iter().any(|(name, _)| *name == other);
            assert!(children(&files, &parent).contains(*name), "{name} does not exist");
            for other in words(allowed) {
                assert!(above(other), "{name} may import {other}, which does not stand above it");
                let used = graph.get(*name).is_some_and(|imports| imports.contains_key(other));
                assert!(used, "{name} may import {other}, but does not");
            }
        }
    }
}

#[test]
fn no_module_has_a_circle_of_imports() {
    assert_eq!(circles(&File::all()), none());
}

#[test]
fn crates_stay_where_they_belong() {
    let files = File::all();
    let rules = [CRATES, STREAMS].concat();
    assert_eq!(strays(&files, &rules), none());
    for (word, homes) in rules {
        let used = |home: &str| files.iter().any(|f| f.path.starts_with(home) && f.mentions(word));
        assert!(words(homes).all(used), "{word} is not mentioned where it belongs");
    }
}

#[test]
fn files_and_functions_are_short() {
    let files = File::all();
    assert_eq!(long_files(&files, "src/", MOST_LINES), none());
    assert_eq!(long_files(&files, "src/fit/mod.rs", MOST_FACADE_LINES), none());
    assert_eq!(long_functions(&files, "src/fit/", MOST_FUNCTION_LINES), none());
}
