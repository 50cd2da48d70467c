//! No command destroys what it reads, or what it has not made.

use super::workshop::{SCENE, SIDE, Workshop, striped};
use narrowbeam::image::Image;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;

const SUN: &str = "[illumination]\ndirection = [0.3, 0.1, 1.0]\nirradiance = 3.0\n";

/// A scene that names many images, and links to them.
fn many() -> Workshop {
    let shop = Workshop::new();
    shop.observe(SCENE);
    for name in ["mask.exr", "veil.exr", "render.exr"] {
        shop.put(name, &[("Y", Image::filled(SIDE, SIDE, 0.1))]);
    }
    let keys = "mask = \"mask.exr\"\nveil = \"veil.exr\"\n[medium]";
    shop.write("scene.toml", &format!("{}{SUN}", SCENE.replace("[medium]", keys)));
    fs::create_dir(shop.file("sub")).unwrap();
    fs::hard_link(shop.file("object.exr"), shop.file("sub/hard.exr")).unwrap();
    symlink("../mask.exr", shop.file("sub/soft.exr")).unwrap();
    symlink("sub/soft.exr", shop.file("soft.exr")).unwrap();
    shop
}

fn contents(shop: &Workshop) -> BTreeMap<String, Vec<u8>> {
    shop.names(".")
        .into_iter()
        .filter(|n| shop.file(n).is_file())
        .map(|n| (n.clone(), shop.bytes(&n)))
        .collect()
}

/// Runs what must be refused for all of `words` and change nothing.
fn refused(shop: &Workshop, arguments: &str, words: &[&str]) {
    let before = contents(shop);
    let run = shop.run(arguments);
    assert_eq!(run.code, 2, "{arguments}: {}", run.stderr);
    assert!(words.iter().all(|word| run.stderr.contains(word)), "{arguments}: {words:?}: {}", run.stderr);
    assert!(run.stdout.is_empty() && contents(shop) == before, "{arguments}");
}

#[test]
fn an_output_that_is_an_input_is_refused_by_name() {
    let shop = many();
    for (output, input) in [
        ("scene.toml", "scene.toml"),
        ("object.exr", "object.exr"),
        ("observed.exr", "observed.exr"),
        ("veil.exr", "veil.exr"),
        ("sub/../mask.exr", "mask.exr"),
        ("sub/hard.exr", "object.exr"),
        ("soft.exr", "mask.exr"),
    ] {
        let also = [output, input];
        let words = if output.ends_with("exr") { [output, input, "input", "lost"] } else { [output; 4] };
        refused(&shop, &format!("render scene.toml --output {output}"), &words);
        refused(&shop, &format!("trace scene.toml --samples 2 --output {output}"), &also);
        if output.ends_with("exr") {
            refused(&shop, &format!("synthesize scene.toml --output {output}"), &also);
            refused(&shop, &format!("synthesize scene.toml --output new.exr --parts {output}"), &also);
            refused(&shop, &format!("render scene.toml --output new.exr --hidden-share {output}"), &also);
        }
    }
    let twice = "render scene.toml --output new.exr --hidden-share sub/../new.exr";
    refused(&shop, twice, &["sub/../new.exr", "--output"]);
    // What the scene does not name may be written over.
    assert_eq!(shop.run("render scene.toml --output render.exr").code, 0);
}

#[test]
fn a_link_that_leads_nowhere_is_no_output() {
    let shop = many();
    symlink("none", shop.file("dangling.exr")).unwrap();
    symlink("round.exr", shop.file("round.exr")).unwrap();
    symlink("none.exr", shop.file("none-yet.exr")).unwrap();
    for output in ["dangling.exr", "round.exr", "none-yet.exr"] {
        refused(&shop, &format!("render scene.toml --output {output}"), &[output, "leads nowhere"]);
        refused(&shop, &format!("fit scene.toml --out {output}"), &[output, "leads nowhere"]);
    }
    fs::create_dir(shop.file("result")).unwrap();
    symlink("none", shop.file("result/fit.png")).unwrap();
    refused(&shop, "fit scene.toml --out result", &["result/fit.png", "leads nowhere"]);
}

#[test]
fn a_fit_spares_its_inputs_wherever_it_writes() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    fs::rename(shop.file("observed.exr"), shop.file("render.exr")).unwrap();
    shop.write("scene.toml", &SCENE.replace("observed.exr", "render.exr"));
    refused(&shop, "fit scene.toml --out .", &["render.exr", "input"]);
    shop.put("hidden_share.exr", &[("Y", Image::filled(SIDE, SIDE, 1.0))]);
    fs::rename(shop.file("render.exr"), shop.file("observed.exr")).unwrap();
    shop.write("scene.toml", &SCENE.replace("[medium]", "mask = \"hidden_share.exr\"\n[medium]"));
    refused(&shop, "fit scene.toml --out .", &["hidden_share.exr", "input"]);
    // It is no input now, but nothing that a fit has left either.
    shop.write("scene.toml", SCENE);
    refused(&shop, "fit scene.toml --out .", &["hidden_share.exr", "earlier fit"]);
}

#[test]
fn a_share_of_hidden_light_is_removed_only_as_a_fit_left_it() {
    let shop = Workshop::new();
    shop.observe(&striped(&shop, SIDE / 2));
    let fit = "fit scene.toml --model small-angle --out result";
    assert_eq!(shop.run(fit).code, 0);
    let share = shop.bytes("result/hidden_share.exr");
    shop.write("result/hidden_share.exr", "changed");
    let run = shop.run(&format!("{fit} --filter eq29"));
    assert!(run.code == 2 && run.stderr.contains("result/hidden_share.exr"), "{}", run.stderr);
    assert_eq!(shop.bytes("result/hidden_share.exr"), b"changed");
    fs::write(shop.file("result/hidden_share.exr"), share).unwrap();
    assert_eq!(shop.run(&format!("{fit} --filter eq29")).code, 3);
    assert!(!shop.file("result/hidden_share.exr").exists());
}

#[test]
fn what_an_earlier_fit_has_left_is_spared_while_it_is_an_input() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    shop.write("far.toml", &SCENE.replace("depth = 2.0", "depth = 3.0"));
    fs::copy(shop.file("observed.exr"), shop.file("far.exr")).unwrap();
    shop.run("render far.toml --model small-angle --output seen.exr");
    shop.write("far.toml", &SCENE.replace("depth = 2.0", "depth = 3.0").replace("observed.exr", "seen.exr"));
    assert_eq!(shop.run("fit scene.toml far.toml --model small-angle --out result").code, 0);
    shop.write("scene.toml", &SCENE.replace("observed.exr", "result/render-1.exr"));
    let before = shop.bytes("result/render-1.exr");
    let run = shop.run("fit scene.toml --model small-angle --out result");
    assert!(run.code == 2 && run.stderr.contains("result/render-1.exr"), "{}", run.stderr);
    assert_eq!(shop.bytes("result/render-1.exr"), before);
    assert_eq!(shop.run("fit scene.toml --model small-angle --out other").code, 0);
}

#[test]
fn a_chart_and_a_table_spare_what_they_read() {
    let shop = Workshop::new();
    shop.observe(&SCENE.replace("[medium]", "noise = 0.001\n[medium]"));
    fs::create_dir(shop.file("fits")).unwrap();
    for name in ["scene.toml", "object.exr", "observed.exr"] {
        fs::rename(shop.file(name), shop.file("fits").join(name)).unwrap();
    }
    shop.write("fits/truth.toml", "[medium]\nsigma_s = 0.8\nsigma_a = 0.1\nb = 0.004\n");
    shop.write("fits.csv", "seconds,cpu_seconds,sigma_s,sigma_a,b,loss\n1.5,3.0,0.4,0.2,0.008,0.1\n");
    refused(&shop, "chart fits --quick --peer . --out .", &["fits.csv", "input"]);
    shop.write("t.part", "precious");
    refused(&shop, "table --paths 1 --out t", &["t.part", "no part of a table"]);
}
