//! Henyey-Greenstein's phase function on the command line and in reports.

use super::workshop::{SCENE, Workshop};
use narrowbeam::io::exr::ExrFile;
use serde_json::Value;

/// The usual scene with g in place of b, fitted as such.
fn scene() -> String {
    SCENE.replace("b = 0.004", "g = 0.95") + "[fit]\nphase = \"hg\"\n"
}

#[test]
fn a_fit_with_hg_reports_g_in_place_of_b() {
    let shop = Workshop::new();
    shop.observe(&scene());
    let run = shop.run("fit scene.toml --model small-angle --out result");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stdout.contains("sigma_s_reduced") && !run.stdout.contains("rad²"), "{}", run.stdout);
    let report: Value =
        serde_json::from_str(&std::fs::read_to_string(shop.file("result/fit.json")).unwrap()).unwrap();
    assert_eq!(report["phase"], "hg");
    let g = &report["parameters"]["g"];
    assert_eq!((g["status"].as_str(), report["parameters"].get("b")), (Some("free"), None));
    assert!((g["value"].as_f64().unwrap() - 0.95).abs() < 1e-3 && g["model_error"].is_f64());
    assert!(run.stderr.contains("warning (outside_validity): tau·2(1-g) = 0.16"), "{}", run.stderr);

    // The image is one of small-angle theory, which no longer holds at this medium: wide angles contradict it.
    let run = shop.run("fit scene.toml --out auto");
    assert_eq!(run.code, 3, "{}", run.stderr);
    assert!(run.stdout.contains("small-angle") && run.stdout.contains("Henyey-Greenstein"), "{}", run.stdout);
    let run = shop.run("fit scene.toml --model narrow-beam --out other");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("narrow-beam") && run.stderr.contains("Henyey-Greenstein"), "{}", run.stderr);
    assert!(!shop.file("other").exists());
}

#[test]
fn renders_and_traces_take_g_on_the_command_line() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE);
    let image = |name: &str| ExrFile::read(&shop.file(name)).unwrap().radiance().unwrap().remove(0).image;
    for command in ["render scene.toml --model small-angle", "trace scene.toml --samples 64"] {
        for (option, name) in [("", "gaussian.exr"), ("--g 0.98", "hg.exr")] {
            let run = shop.run(&format!("{command} {option} --output {name}"));
            assert_eq!(run.code, 0, "{}", run.stderr);
        }
        let apart = |a: &str, b: &str| -> f64 {
            let (a, b) = (image(a), image(b));
            let squares = a.data.iter().zip(&b.data).map(|(x, y)| f64::from(x - y).powi(2));
            (squares.sum::<f64>() / a.data.len() as f64).sqrt()
        };
        assert!(apart("gaussian.exr", "hg.exr") > 0.01);
        if command.starts_with("trace") {
            // The trace of g .98 is the render of g .98, within its noise and 2 % of the light for wide angles.
            let run = shop.run("render scene.toml --model small-angle --g 0.98 --output small.exr");
            assert_eq!(run.code, 0, "{}", run.stderr);
            assert!(apart("small.exr", "hg.exr") < 0.5 * apart("small.exr", "gaussian.exr"));
        }
    }
    let run = shop.run("forecast scene.toml --g 0.98 --noise 0.01 --json");
    assert!(run.stdout.contains("\"g\": {"), "{}{}", run.stdout, run.stderr);
}

#[test]
fn a_wrong_g_is_refused_by_name() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE);
    for (options, words) in [
        ("--g 1.5", ["--g = 1.5", "between 0 and 1"]),
        ("--g 0.9 --b 0.1", ["--g", "--b"]),
        ("--g 0.9 --spread-angle-deg 8", ["--g", "--spread-angle-deg"]),
    ] {
        let run = shop.run(&format!("render scene.toml {options} --output out.exr"));
        assert_eq!(run.code, 2, "{options}");
        assert!(words.iter().all(|w| run.stderr.contains(w)), "{}", run.stderr);
        assert!(!shop.file("out.exr").exists());
    }
    let run = shop.run("kernel --sigma-s 1 --sigma-a 0 --g 1.5 --depth 1 --out k");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("--g = 1.5"), "{}", run.stderr);
}

#[test]
fn kernels_of_hg_leave_out_the_models_that_have_none() {
    let shop = Workshop::new();
    let run = shop.run("kernel --sigma-s 1 --sigma-a 0.1 --g 0.95 --depth 1 --photons 20000 --out k");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("narrow-beam is left out"), "{}", run.stderr);
    for words in ["Henyey-Greenstein, g 0.95", "tau·2(1-g) 0.1000", "small-angle", "infinite"] {
        assert!(run.stdout.contains(words), "{words}: {}", run.stdout);
    }
    let run = shop.run("kernel --sigma-s 1 --sigma-a 0.1 --g 0.95 --depth 1 --model gaussian --out other");
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("gaussian") && run.stderr.contains("Henyey-Greenstein"), "{}", run.stderr);
}
