//! `forecast`, `calibrate`, and the intervals that `fit` adds.

use super::workshop::{SCENE, Workshop};
use serde_json::Value;

#[test]
fn a_forecast_needs_no_observation_and_says_what_will_be_known() {
    let shop = Workshop::new();
    shop.write("scene.toml", &SCENE.replace("[observation]\nimage = \"observed.exr\"\n", ""));
    let run = shop.run("forecast scene.toml --noise 0.01 --json");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(report["parameters"]["sigma_s"]["status"], "free");
    let error = |report: &Value| report["parameters"]["sigma_s"]["std_error"].as_f64().unwrap();
    // Twice the noise, twice the error.
    let twice: Value =
        serde_json::from_str(&shop.run("forecast scene.toml --noise 0.02 --json").stdout).unwrap();
    assert!((error(&twice) / error(&report) - 2.0).abs() < 1e-3);
    assert!(run.stderr.contains("correlations"), "{}", run.stderr);

    let free = shop.run("forecast scene.toml --noise 0.01 --free-gain");
    assert_eq!(free.code, 3);
    assert!(free.stderr.contains("undetermined") && free.stderr.contains("gain"), "{}", free.stderr);
}

#[test]
fn a_forecast_without_a_medium_or_with_no_noise_is_refused() {
    let shop = Workshop::new();
    let head = SCENE.split("[medium]").next().unwrap();
    shop.write("scene.toml", head);
    let run = shop.run("forecast scene.toml --noise 0.01");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("sigma_s"), "{}", run.stderr);
    shop.write("scene.toml", SCENE);
    let run = shop.run("forecast scene.toml --noise 0");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("--noise"), "{}", run.stderr);
}

#[test]
fn a_fit_adds_intervals_by_profile_and_bootstrap() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    let run = shop.run("fit scene.toml --model small-angle --profile --bootstrap 40 --seed 3 --out result");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("profile likelihood") && run.stdout.contains("bootstrap"), "{}", run.stdout);
    let read = |folder: &str| -> Value {
        serde_json::from_str(&std::fs::read_to_string(shop.file(folder).join("fit.json")).unwrap()).unwrap()
    };
    let report = read("result");
    for name in ["sigma_s", "sigma_a", "b"] {
        let p = &report["parameters"][name];
        let value = p["value"].as_f64().unwrap();
        for key in ["profile95", "bootstrap95"] {
            let [low, high] = [0, 1].map(|i| p[key][i].as_f64().unwrap());
            assert!(low <= value && value <= high && low < high, "{name} {key}: {low} {value} {high}");
        }
    }
    // The same seed draws the same noise.
    shop.run("fit scene.toml --model small-angle --bootstrap 40 --seed 3 --out again");
    assert_eq!(read("again")["parameters"]["b"]["bootstrap95"], report["parameters"]["b"]["bootstrap95"]);
}

#[test]
fn a_fit_says_what_is_determined_and_what_would_free_the_rest() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    shop.write("scene.toml", &SCENE.replace("[medium]", "gain = \"free\"\n[medium]"));
    let run = shop.run("fit scene.toml --model small-angle --json");
    assert_eq!(run.code, 3, "{}", run.stderr);
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(report["determined"][0]["combination"], "gain·exp(-sigma_a z)");
    let freeing = report["advice"].as_array().unwrap().iter().filter(|a| a["frees"] == true);
    let freeing: Vec<&str> = freeing.map(|a| a["measurement"].as_str().unwrap()).collect();
    assert!(freeing.contains(&"a known gain"), "{freeing:?}");
    assert!(run.stderr.contains("determined: gain·exp(-sigma_a z) = "), "{}", run.stderr);
    assert!(run.stderr.contains("advice: a known gain would determine all"), "{}", run.stderr);
}

#[test]
fn a_calibration_tabulates_what_it_found() {
    let shop = Workshop::new();
    let run = shop.run("calibrate --draws 2 --json --out made");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let csv = std::fs::read_to_string(shop.file("made").join("calibration.csv")).unwrap();
    assert!(csv.lines().count() > 18 && csv.starts_with("setting,model,parameter,draws,inside"), "{csv}");
    let columns = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().all(|line| line.split(',').count() == columns));
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let found = found.as_array().unwrap();
    assert!(found.len() + 1 == csv.lines().count() && found.iter().all(|row| row["draws"] == 2));
    assert_eq!(shop.run("calibrate --draws 1 --out made").code, 2);
}
