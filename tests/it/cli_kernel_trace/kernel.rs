//! The command `kernel`.

use crate::common::program::{refuses, succeeds};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

const MEDIUM: [&str; 6] = ["--sigma-s", "0.95", "--sigma-a", "0.05", "--b", "0.0049"];
const MODELS: [&str; 7] = [
    "beer-lambert",
    "single-scatter",
    "gaussian",
    "narrow-beam-printed",
    "narrow-beam",
    "small-angle",
    "wide-angle",
];

/// `kernel` with the usual medium at depth 2, writing to `k`, and `more`.
fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let fixed = ["kernel"].into_iter().chain(MEDIUM).chain(["--depth", "2", "--out", "k"]);
    fixed.chain(more.iter().copied()).collect()
}

/// Header and, by model in the order of the file, the rows of numbers; an empty cell is NaN.
fn table(path: &Path) -> (String, Vec<String>, BTreeMap<String, Vec<Vec<f64>>>) {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header = lines.next().unwrap().to_string();
    let (mut order, mut rows) = (Vec::<String>::new(), BTreeMap::<String, Vec<Vec<f64>>>::new());
    for line in lines {
        let mut cells = line.split(',');
        let name = cells.next().unwrap().to_string();
        let numbers = cells.map(|c| if c.is_empty() { f64::NAN } else { c.parse().unwrap() });
        rows.entry(name.clone()).or_default().push(numbers.collect());
        if order.last() != Some(&name) {
            order.push(name);
        }
    }
    (header, order, rows)
}

#[test]
fn all_models_are_tabulated_and_drawn() {
    let dir = tempfile::tempdir().unwrap();
    let said = succeeds(dir.path(), &with(&[]));
    for words in MODELS.iter().chain(&["direct light T", "exact", "as printed", "tau·4B"]) {
        assert!(said.contains(words), "{words} is not in: {said}");
    }
    let out = dir.path().join("k");
    for picture in ["kernel.png", "encircled_energy.png", "mtf.png"] {
        assert!(fs::read(out.join(picture)).unwrap().starts_with(b"\x89PNG"), "{picture}");
    }

    let (header, order, kernel) = table(&out.join("kernel.csv"));
    assert_eq!(header, "model,r,psf,encircled_energy");
    assert_eq!(order, MODELS);
    let (header, order, mtf) = table(&out.join("mtf.csv"));
    assert_eq!(header, "model,k,mtf");
    assert_eq!(order, MODELS);
    let kept = (-0.1_f64).exp();
    let direct = (-2.0_f64).exp();
    for name in MODELS {
        let within: Vec<f64> = kernel[name].iter().map(|row| row[2]).collect();
        assert!(within.windows(2).all(|pair| pair[0] <= pair[1] + 1e-9), "{name}");
        let arrives = match name {
            "beer-lambert" => direct,
            "single-scatter" => direct * 2.9,
            _ => kept,
        };
        if name == "wide-angle" {
            // Of the light .1 % is absorbed on the excess path z tau·4B/4; the table's own error is some .2 %.
            assert!((mtf[name][0][1] / (kept * 0.999) - 1.0).abs() < 0.004, "{}", mtf[name][0][1]);
            assert!((within.last().unwrap() - (mtf[name][0][1] - direct)).abs() < 1e-3);
            continue;
        }
        // M(0) is all light that arrives; the farthest radius holds all scattered light; printed in nine digits.
        assert_eq!(mtf[name][0][0], 0.0);
        assert!((mtf[name][0][1] - arrives).abs() < 1e-8, "{name}: {}", mtf[name][0][1]);
        assert!((within.last().unwrap() - (arrives - direct)).abs() < 1e-6, "{name}");
    }
    assert!(kernel["beer-lambert"].iter().all(|row| row[1] == 0.0 && row[2] == 0.0));
}

#[test]
fn the_tracer_stands_beside_the_models_with_its_errors() {
    let dir = tempfile::tempdir().unwrap();
    let said = succeeds(dir.path(), &with(&["--photons", "200000", "--model", "small-angle"]));
    assert!(said.contains("traced") && said.contains("worst encircled-energy error"), "{said}");
    let (header, order, kernel) = table(&dir.path().join("k/kernel.csv"));
    assert_eq!(header, "model,r,psf,encircled_energy,std_error,psf_std_error");
    assert_eq!(order, ["small-angle", "traced"]);
    let (header, _, mtf) = table(&dir.path().join("k/mtf.csv"));
    assert_eq!(header, "model,k,mtf,std_error");

    assert!(kernel["small-angle"].iter().all(|row| row[3].is_nan() && row[4].is_nan()));
    // Small-angle theory is right to .19 tau·4B = .007 here; measured are 4 standard errors more.
    let near = |traced: &[f64], model: &[f64], value: usize, error: usize| {
        let bound = 0.007 + 4.0 * traced[error];
        assert!((traced[value] - model[value]).abs() < bound, "{traced:?} {model:?}");
    };
    for (traced, model) in kernel["traced"].iter().zip(&kernel["small-angle"]) {
        assert_eq!(traced[0], model[0]);
        near(traced, model, 2, 3);
    }
    for (traced, model) in mtf["traced"].iter().zip(&mtf["small-angle"]) {
        assert_eq!(traced[0], model[0]);
        near(traced, model, 1, 2);
    }
    // In the middle of the kernel the density is measured to a few percent, and agrees.
    let (traced, model) = (&kernel["traced"][45], &kernel["small-angle"][45]);
    assert!(traced[4] < 0.03 * traced[1] && (traced[1] - model[1]).abs() < 4.0 * traced[4] + 0.02 * model[1]);
}

#[test]
fn numbers_come_as_json_too() {
    let dir = tempfile::tempdir().unwrap();
    let said = succeeds(dir.path(), &with(&["--json", "--photons", "1000"]));
    let kernel: serde_json::Value = serde_json::from_str(&said).unwrap();
    let number = |key: &str| kernel.pointer(key).and_then(serde_json::Value::as_f64).expect(key);
    assert!((number("/tau") - 1.9).abs() < 1e-12 && (number("/direct") - (-2.0_f64).exp()).abs() < 1e-12);
    let models: Vec<&str> =
        kernel["models"].as_array().unwrap().iter().map(|m| m["model"].as_str().unwrap()).collect();
    assert_eq!(models, MODELS);
    // 1000 photons: five standard errors.
    let scattered = number("/models/5/scattered");
    let off = (number("/traced/scattered/value") - scattered).abs();
    assert!(off < 5.0 * number("/traced/scattered/std_error"), "{scattered} {off}");
}

#[test]
fn the_same_seed_gives_the_same_table() {
    let dir = tempfile::tempdir().unwrap();
    let run = |seed: &str| {
        succeeds(dir.path(), &with(&["--photons", "20000", "--model", "gaussian", "--seed", seed]));
        fs::read(dir.path().join("k/kernel.csv")).unwrap()
    };
    assert_eq!(run("1"), run("1"));
    assert_ne!(run("1"), run("2"));
}

#[test]
fn a_spread_angle_says_the_same_as_b_and_models_come_in_their_own_order_once() {
    let dir = tempfile::tempdir().unwrap();
    succeeds(dir.path(), &with(&["--model", "small-angle", "--model", "gaussian", "--model", "small-angle"]));
    let (_, order, by_b) = table(&dir.path().join("k/kernel.csv"));
    assert_eq!(order, ["gaussian", "small-angle"]);
    // sqrt(4 · .0049) = .14 rad.
    let degrees = 0.14_f64.to_degrees().to_string();
    let arguments = ["--spread-angle-deg", &degrees, "--depth", "2", "--out", "angle", "--model", "gaussian"];
    let all: Vec<_> = ["kernel"].into_iter().chain(MEDIUM[..4].iter().copied()).chain(arguments).collect();
    succeeds(dir.path(), &all);
    let (_, _, by_angle) = table(&dir.path().join("angle/kernel.csv"));
    for (a, b) in by_b["gaussian"].iter().zip(&by_angle["gaussian"]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-7 * b.abs()), "{a:?} {b:?}");
    }
}

#[test]
fn bad_values_are_refused_by_option_before_anything_is_written() {
    let dir = tempfile::tempdir().unwrap();
    let sound = with(&[]);
    let replaced = |option: &str, value: &'static str| {
        let at = sound.iter().position(|a| *a == option).unwrap() + 1;
        let mut arguments = sound.clone();
        arguments[at] = value;
        arguments
    };
    for (option, value) in [
        ("--sigma-s", "-0.1"),
        ("--sigma-a", "-0.1"),
        ("--sigma-a", "NaN"),
        ("--b", "0"),
        ("--b", "-0.1"),
        ("--depth", "0"),
        ("--depth", "-2"),
        ("--depth", "inf"),
        ("--depth", "deep"),
    ] {
        refuses(dir.path(), &replaced(option, value), &[option, value]);
    }
    for option in ["--sigma-s", "--sigma-a", "--b", "--depth", "--out"] {
        let at = sound.iter().position(|a| *a == option).unwrap();
        let without: Vec<_> = [&sound[..at], &sound[at + 2..]].concat();
        refuses(dir.path(), &without, &[option]);
    }
    refuses(dir.path(), &with(&["--photons", "-1"]), &["--photons"]);
    refuses(dir.path(), &with(&["--spread-angle-deg", "8"]), &["--b", "--spread-angle-deg"]);
    let mut angle = sound.clone();
    let at = angle.iter().position(|a| *a == "--b").unwrap();
    angle.splice(at..at + 2, ["--spread-angle-deg", "-8"]);
    refuses(dir.path(), &angle, &["--spread-angle-deg", "-8"]);
}

#[test]
fn unknown_models_and_media_beyond_the_table_are_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    refuses(dir.path(), &with(&["--model", "sharp"]), &["--model", "'sharp'", "small-angle"]);
    let mut thick = with(&["--model", "wide-angle"]);
    let at = thick.iter().position(|a| *a == "--sigma-s").unwrap();
    thick[at + 1] = "1000";
    refuses(dir.path(), &thick, &["sigma_s z", "wide-angle", "between 0 and 12"]);
    // Unasked, it is left out.
    let said = succeeds(dir.path(), &thick[..thick.len() - 2]);
    assert!(!said.contains("wide-angle") && said.contains("small-angle"), "{said}");
}

#[test]
fn a_directory_that_cannot_be_made_is_named() {
    let dir = tempfile::tempdir().unwrap();
    fs::write(dir.path().join("k"), "a file").unwrap();
    refuses(dir.path(), &with(&[]), &["k: cannot be written"]);
    assert_eq!(fs::read(dir.path().join("k")).unwrap(), b"a file");
}
