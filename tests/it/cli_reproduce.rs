//! `narrowbeam reproduce`: files, refusals, and the numbers behind the paper's figures. One quick run serves all tests;
//! docs/paper/ holds the numbers of a full one.

use crate::common::program::{refuses, succeeds};
use narrowbeam::lab::compare::RmsError;
use narrowbeam::lab::paper::{Effort, Experiment, figure_5, figure_8};
use narrowbeam::medium::Medium;
use narrowbeam::trace::Estimate;
use std::fs;
use std::path::Path;
use std::sync::LazyLock;

/// Standard errors of a normal number beyond which one of 420 falls with a chance of 1 %: 420 erfc(4.2/√2) = .01.
const NORMAL: f64 = 4.2;

const MODELS: [&str; 6] =
    ["single-scatter", "gaussian", "narrow-beam-printed", "narrow-beam", "small-angle", "wide-angle"];

/// The folder of a quick run, and what it said.
static QUICK: LazyLock<(tempfile::TempDir, String)> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    let said = succeeds(dir.path(), &["reproduce", "--quick", "--out", "deep/paper"]);
    (dir, said)
});

fn quick(file: &str) -> String {
    fs::read_to_string(QUICK.0.path().join("deep/paper").join(file)).unwrap()
}

fn documented(file: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/paper").join(file)).unwrap()
}

/// One line of a table of errors.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    model: String,
    /// Albedo, spread angle (degrees), z, rings.
    place: [f64; 4],
    error: Estimate,
}

fn rows(text: &str) -> Vec<Row> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("model,albedo,spread_angle_deg,z,rings,rms_error,std_error,noise"));
    let row = |line: &str| {
        let (model, numbers) = line.split_once(',').unwrap();
        let n: Vec<f64> = numbers.split(',').map(|cell| cell.parse().unwrap()).collect();
        let error = Estimate { value: n[4], std_error: n[5] };
        Row { model: model.into(), place: [n[0], n[1], n[2], n[3]], error }
    };
    lines.map(row).collect()
}

/// Whether two errors are the same to the noise of both, and to half a unit of their last digit each.
fn agree(a: Estimate, b: Estimate) -> bool {
    (a.value - b.value).abs() <= NORMAL * a.std_error.hypot(b.std_error) + 1e-5
}

/// The error of `model` at `angle` and `z` over all 300 rings, in figure 5.
fn figure_5_error(rows: &[Row], model: &str, angle: f64, z: f64) -> Estimate {
    let here = |row: &&Row| row.model == model && row.place == [0.95, angle, z, 300.0];
    rows.iter().find(here).unwrap_or_else(|| panic!("{model}, {angle}°, {z}")).error
}

fn angles() -> impl Iterator<Item = f64> {
    (1..=12).map(|i| 5.0 * f64::from(i))
}

#[test]
fn every_figure_is_written_as_pictures_and_tables() {
    let (dir, said) = &*QUICK;
    let out = dir.path().join("deep/paper");
    for figure in ["fig4", "fig5", "fig6"] {
        assert!(
            fs::read(out.join(figure).with_extension("png")).unwrap().starts_with(b"\x89PNG"),
            "{figure}"
        );
        let svg = quick(&format!("{figure}.svg"));
        assert!(svg.starts_with("<svg") && svg.contains("mean free path"), "{figure}");
        assert!(MODELS.iter().all(|model| svg.contains(model)), "{figure}");
        assert!(said.contains(&format!("{figure}.png")), "{said}");
    }
    assert!(MODELS.iter().all(|model| said.contains(model)), "{said}");
    assert!(fs::read(out.join("fig8.png")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(quick("fig8.svg").matches("data:image/png;base64,").count(), 9);
    assert_eq!(fs::read_dir(out).unwrap().count(), 13);
}

/// Model and channel, and clear, direct, scattered, veil, of a table of figure 8.
fn light(text: &str) -> Vec<(String, [f64; 4])> {
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("model,channel,clear,direct,scattered,veil,difference"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[..2].join(","), std::array::from_fn(|i| cells[i + 2].parse().unwrap()))
    };
    lines.map(row).collect()
}

/// Whether two tables of figure 8 agree to 1 %. What differs between a quick and a full run is which pixels an edge falls
/// on: the clear images, which no medium touches, differ by .4 %.
fn same_light(ours: &[(String, [f64; 4])], theirs: &[(String, [f64; 4])]) -> bool {
    let close = |a: f64, b: f64| (a - b).abs() < 0.01 * b;
    ours.len() == theirs.len()
        && ours
            .iter()
            .zip(theirs)
            .all(|(a, b)| a.0 == b.0 && a.1.iter().zip(&b.1).all(|(x, y)| close(*x, *y)))
}

#[test]
fn the_light_of_figure_8_is_that_of_the_documentation_and_of_no_other_medium() {
    let (ours, theirs) = (light(&quick("fig8.csv")), light(&documented("fig8.csv")));
    assert_eq!(ours.len(), 2 * 3);
    assert!(same_light(&ours, &theirs), "{ours:?}");
    for (of, [clear, direct, scattered, veil]) in &ours {
        assert!(0.0 < *direct && direct < clear && *scattered > 0.0 && *veil > 0.0, "{of}");
    }
    let (scene, mut media) = figure_8::scene(figure_8::side(Effort::Quick)).unwrap();
    media.iter_mut().for_each(|m| *m = Medium::new(1.05 * m.sigma_s(), m.sigma_a(), *m.phase()).unwrap());
    let pictures = figure_8::pictures(&scene, &media).unwrap();
    let row = |l: figure_8::Light| {
        let [direct, scattered, veil] = l.parts;
        (format!("{},{}", l.model, l.channel), [l.clear, direct, scattered, veil])
    };
    let wrong: Vec<_> = figure_8::light(&pictures).into_iter().map(row).collect();
    assert!(!same_light(&wrong, &theirs));
}

#[test]
fn profiles_hold_the_light_that_the_kernels_scatter() {
    let header = format!("albedo,spread_angle_deg,z,r,traced,traced_std_error,{}", MODELS.join(","));
    for (file, lines) in [("fig4.csv", 3 * 15 * 30), ("fig6.csv", 2 * 3 * 300)] {
        let text = quick(file);
        assert_eq!(text.lines().next(), Some(header.as_str()));
        assert_eq!(text.lines().count(), 1 + lines, "{file}");
    }
    // Over 0 < r < 3 z the Gaussian of 30 degrees has all its light: exp(-sigma_a z)(1 - exp(-sigma_s z)).
    for (albedo, z) in [(0.7, 1.0), (0.7, 3.0), (0.99, 2.0)] {
        let text = quick("fig6.csv");
        let numbers = text.lines().skip(1).map(|line| line.split(',').map(|c| c.parse::<f64>().unwrap()));
        let rows: Vec<Vec<f64>> = numbers.map(Iterator::collect).collect();
        let here: Vec<_> = rows.iter().filter(|row| row[0] == albedo && row[2] == z).collect();
        let width = here[1][3] - here[0][3];
        let light: f64 = here.iter().map(|row| row[7] * width).sum();
        let expected = (-(1.0 - albedo) * z).exp() * (1.0 - (-albedo * z).exp());
        // Numbers are written in five digits.
        assert!((light / expected - 1.0).abs() < 1e-4, "{albedo} {z}: {light} {expected}");
    }
}

#[test]
fn errors_are_those_of_the_documentation() {
    for file in ["fig5.csv", "fig6_errors.csv"] {
        let (ours, theirs) = (rows(&quick(file)), rows(&documented(file)));
        assert_eq!(ours.len(), theirs.len(), "{file}");
        for (ours, theirs) in ours.iter().zip(&theirs) {
            assert_eq!((&ours.model, ours.place), (&theirs.model, theirs.place));
            assert!(agree(ours.error, theirs.error), "{file}: {ours:?}, documented {theirs:?}");
        }
    }
}

#[test]
fn a_wrong_kernel_and_a_wrong_medium_are_found_out() {
    let (ours, theirs) = (rows(&quick("fig5.csv")), rows(&documented("fig5.csv")));
    let [printed, exact] =
        ["narrow-beam-printed", "narrow-beam"].map(|m| figure_5_error(&theirs, m, 10.0, 2.0));
    assert!(!agree(figure_5_error(&ours, "narrow-beam", 10.0, 2.0), printed));
    assert!(!agree(figure_5_error(&ours, "narrow-beam-printed", 10.0, 2.0), exact));

    // Albedo off by 5 %, spread angle by 20 %: relative errors hardly depend on it, but those of small-angle theory do.
    let right = figure_5::experiments(Effort::Quick).remove(1);
    let thin = Experiment { albedo: 0.9, ..right.clone() };
    let wide = Experiment { spread_angle_deg: 12.0, ..right.clone() };
    let found_out = |experiment: &Experiment| {
        let rings = experiment.run(&|_| ()).unwrap();
        let errors = rings.iter().flat_map(|plane| plane.errors().unwrap().into_iter().map(|e| (plane.z, e)));
        let differs = |(z, (model, RmsError { error, .. })): (f64, (narrowbeam::spread::Model, RmsError))| {
            !agree(error, figure_5_error(&theirs, model.name(), 10.0, z))
        };
        errors.filter(|e| differs(*e)).count()
    };
    assert_eq!(found_out(&right), 0);
    assert!(found_out(&thin) > 5);
    assert!(found_out(&wide) > 1);
}

#[test]
fn what_the_documentation_says_of_the_papers_claims_is_so() {
    let rows = rows(&quick("fig5.csv"));
    let error = |model, angle, z| figure_5_error(&rows, model, angle, z);
    let below = |a: Estimate, b: Estimate| b.value - a.value > NORMAL * a.std_error.hypot(b.std_error);
    let limit = Estimate { value: 0.2, std_error: 0.0 };
    for angle in angles() {
        let printed = |z| error("narrow-beam-printed", angle, z);
        // "Under .2": at z = 1 from 15 to 40 degrees (at 5 and 10 it is .2), nowhere at z = 2 and 3.
        if (15.0..=40.0).contains(&angle) {
            assert!(below(printed(1.0), limit), "{angle}°");
        }
        for z in [2.0, 3.0] {
            assert!(below(limit, printed(z)), "{angle}°, {z}");
        }
        // The Gaussian is worse (at 5 degrees and z = 3 by next to nothing), and so is single scattering, but for wide
        // angles in thin media.
        for z in [1.0, 2.0, 3.0] {
            assert!(
                angle == 5.0 && z == 3.0 || below(printed(z), error("gaussian", angle, z)),
                "{angle}°, {z}"
            );
            let single = error("single-scatter", angle, z);
            let thin_and_wide = z == 1.0 && angle >= 50.0;
            assert!(thin_and_wide || below(printed(z), single), "{angle}°, {z}");
        }
    }
    assert!(below(error("single-scatter", 60.0, 1.0), error("narrow-beam-printed", 60.0, 1.0)));
    // At 5 degrees small-angle theory is right to a percent, and the others are off by eight times that and more.
    let documented = self::rows(&documented("fig5.csv"));
    for z in [1.0, 2.0, 3.0] {
        assert!(below(error("small-angle", 5.0, z), Estimate { value: 0.02, std_error: 0.0 }), "{z}");
        // The wide-angle model is right to a percent everywhere. Its table was traced apart from this; the quick run's noise
        // is allowed for, that of the documentation's needs no allowance.
        for angle in angles() {
            let bound = Estimate { value: 0.01, std_error: 0.0 };
            assert!(!below(bound, error("wide-angle", angle, z)), "{angle}°, {z}");
            assert!(figure_5_error(&documented, "wide-angle", angle, z).value < 0.01, "{angle}°, {z}");
            assert!(angle < 20.0 || below(bound, error("small-angle", angle, z)), "{angle}°, {z}");
        }
        for other in &MODELS[..4] {
            assert!(below(Estimate { value: 0.08, std_error: 0.0 }, error(other, 5.0, z)), "{other}, {z}");
        }
    }
}

#[test]
fn what_cannot_be_made_is_refused_before_anything_is_written() {
    let dir = tempfile::tempdir().unwrap();
    refuses(
        dir.path(),
        &["reproduce", "fig7", "--out", "p"],
        &["fig7", "fig4", "fig5", "fig6", "fig8", "all"],
    );
    refuses(dir.path(), &["reproduce", "fig5"], &["--out"]);
    refuses(dir.path(), &["reproduce", "--quick", "--photons", "5", "--out", "p"], &["--photons"]);
    fs::write(dir.path().join("p"), "a file").unwrap();
    refuses(dir.path(), &["reproduce", "fig5", "--out", "p"], &["p: cannot be written"]);
    assert_eq!(fs::read(dir.path().join("p")).unwrap(), b"a file");
    fs::create_dir_all(dir.path().join("q/fig5.svg")).unwrap();
    refuses(dir.path(), &["reproduce", "fig5", "--out", "q"], &["q/fig5.svg: cannot be written"]);
}
