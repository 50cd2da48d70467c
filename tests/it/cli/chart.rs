//! `chart`: what it draws and tabulates, and what it refuses.

use super::workshop::{SCENE, Workshop};
use narrowbeam::spread::Model;

const TRUTH: &str = "[medium]\nsigma_s = 0.8\nsigma_a = 0.1\nb = 0.004\n";

/// A trajectory that ends 10 % off.
const TRAJECTORY: &str = "# command: made up\nseconds,cpu_seconds,sigma_s,sigma_a,b,loss
1.5,3.0,0.4,0.2,0.008,0.1\n3.0,6.0,0.8,0.11,0.004,0.01\n";

/// A folder `plane` with a traced observation and its truth, and the peer's way in `peer`.
fn plane() -> Workshop {
    let shop = Workshop::new();
    for folder in ["plane", "peer"] {
        std::fs::create_dir(shop.file(folder)).unwrap();
    }
    std::fs::rename(shop.file("object.exr"), shop.file("plane/object.exr")).unwrap();
    let scene = SCENE.split("[medium]").next().unwrap();
    shop.write("plane/scene.toml", scene);
    shop.write("plane/truth.toml", TRUTH);
    shop.write("peer/plane.csv", TRAJECTORY);
    let run = shop.run("trace plane/scene.toml --sigma-s 0.8 --sigma-a 0.1 --b 0.004 --samples 256 --output plane/observed.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    shop
}

/// The rows of a table by name of column.
fn rows(shop: &Workshop, name: &str) -> Vec<std::collections::HashMap<String, String>> {
    let text = std::fs::read_to_string(shop.file("made").join(name)).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').map(String::from).collect::<Vec<_>>());
    let head = lines.next().unwrap();
    lines
        .map(|cells| {
            assert_eq!(cells.len(), head.len(), "{name}: {cells:?}");
            head.iter().cloned().zip(cells).collect()
        })
        .collect()
}

#[test]
fn a_chart_has_every_model_on_every_backend_and_the_front_of_them() {
    let shop = plane();
    let run = shop.run("chart plane --peer peer --quick --json --out made");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("front"), "{}", run.stderr);
    let fronts: serde_json::Value = serde_json::from_str(&run.stdout).unwrap();
    let fronts = fronts.as_array().unwrap();
    assert!(fronts.iter().any(|p| p["task"] == "fit" && p["error"].as_f64().unwrap() < 0.1), "{fronts:?}");
    for name in ["renders", "fits"] {
        let picture = image::open(shop.file("made").join(format!("{name}.png"))).unwrap();
        assert!(picture.width() >= 500 && picture.height() > 430);
        let svg = std::fs::read_to_string(shop.file("made").join(format!("{name}.svg"))).unwrap();
        assert!(svg.contains("Pareto front") && svg.contains("%"));
    }
    let (renders, fits, peer) =
        (rows(&shop, "renders.csv"), rows(&shop, "fits.csv"), rows(&shop, "peer.csv"));
    let number =
        |row: &std::collections::HashMap<String, String>, key: &str| row[key].parse::<f64>().unwrap();
    for model in Model::ALL.map(Model::name) {
        // One adapter, be it a software one, is there wherever the tests run.
        for backend in ["cpu", "gpu"] {
            let ours = |row: &&std::collections::HashMap<String, String>| row["backend"] == backend;
            let render = renders.iter().filter(ours).find(|row| row["model"] == model).unwrap();
            assert!(render["why_not"].is_empty() && number(render, "seconds") > 0.0, "{render:?}");
            let fit = fits.iter().filter(ours).find(|row| row["method"] == model).unwrap();
            assert!(number(fit, "cpu_seconds") > 0.0);
            assert_eq!(fit["why_not"].is_empty(), model != "beer-lambert", "{fit:?}");
        }
    }
    let error = |model: &str| number(renders.iter().find(|row| row["model"] == model).unwrap(), "error");
    assert!(error("beer-lambert") > 10.0 * error("small-angle"), "direct light alone errs more");
    let auto = fits.iter().find(|row| row["method"] == "auto").unwrap();
    assert!(!auto["model"].is_empty() && number(auto, "error") < 0.1, "{auto:?}");
    for table in [&renders, &fits] {
        let front: Vec<(f64, f64)> = table
            .iter()
            .filter(|row| row["on_front"] == "true")
            .map(|row| (number(row, "seconds"), number(row, "error")))
            .collect();
        assert!(!front.is_empty() && front.len() < table.len());
    }
    // The trajectory's last line is off by .01 of .1.
    assert_eq!(peer.len(), 2);
    assert!((number(&peer[1], "error") - 0.1).abs() < 1e-6 && number(&peer[1], "cpu_seconds") == 6.0);
}

#[test]
fn what_cannot_be_charted_is_refused_by_name_and_nothing_is_written() {
    let shop = plane();
    let refused = |arguments: &str, words: &[&str]| {
        let run = shop.run(arguments);
        assert_eq!(run.code, 2, "{arguments}: {}", run.stderr);
        assert!(words.iter().all(|word| run.stderr.contains(word)), "{words:?}: {}", run.stderr);
        assert!(!shop.file("made").exists(), "{arguments} wrote something");
    };
    refused("chart nowhere --out made", &["nowhere/scene.toml"]);
    refused("chart plane --peer nowhere --out made", &["nowhere", "--peer"]);
    for (broken, words) in [
        ("seconds,sigma_s,sigma_a,b\n", ["plane.csv", "cpu_seconds"]),
        ("seconds,cpu_seconds,sigma_s,sigma_a,b\n1,1,much,1,1\n", ["line 2", "sigma_s"]),
    ] {
        shop.write("peer/plane.csv", broken);
        refused("chart plane --peer peer --out made", &words);
    }
    let scene = std::fs::read_to_string(shop.file("plane/scene.toml")).unwrap();
    let observed = "image = \"observed.exr\"\n";
    shop.write("plane/scene.toml", &scene.replace(observed, &format!("{observed}gain = \"free\"\n")));
    refused("chart plane --out made", &["plane/scene.toml", "gain"]);
    shop.write("plane/scene.toml", &scene);
    shop.write("plane/truth.toml", "[medium]\nsigma_s = 0.8\n");
    refused("chart plane --out made", &["plane/truth.toml", "sigma_a"]);
    std::fs::remove_file(shop.file("plane/truth.toml")).unwrap();
    refused("chart plane --out made", &["plane/truth.toml"]);
    // An image whose noise nobody states.
    shop.write("plane/truth.toml", TRUTH);
    std::fs::copy(shop.file("plane/object.exr"), shop.file("plane/observed.exr")).unwrap();
    refused("chart plane --out made", &["plane/scene.toml", "noise"]);
}
