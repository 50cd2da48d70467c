//! Results have the same bits for any number of threads.

use super::workshop::{SCENE, SIDE, Workshop, striped};
use serde_json::Value;

/// Runs `command` in a new folder with so many threads, and returns what `kept` finds there.
fn with<T>(
    threads: &str,
    scene: &dyn Fn(&Workshop) -> String,
    command: &str,
    kept: impl Fn(&Workshop) -> T,
) -> T {
    let shop = Workshop::new();
    shop.observe(&scene(&shop));
    let status = shop.command(command).env("RAYON_NUM_THREADS", threads).status().unwrap();
    assert!(matches!(status.code(), Some(0 | 3)), "{command}: {status}");
    kept(&shop)
}

/// Asserts that what `kept` finds is the same for one, two and 64 threads.
fn same<T: PartialEq>(
    scene: &dyn Fn(&Workshop) -> String,
    command: &str,
    kept: impl Fn(&Workshop) -> T,
) -> T {
    let one = with("1", scene, command, &kept);
    for threads in ["2", "64"] {
        assert!(with(threads, scene, command, &kept) == one, "{command}: {threads} threads");
    }
    one
}

fn plane(_: &Workshop) -> String {
    SCENE.into()
}

fn stripes(shop: &Workshop) -> String {
    striped(shop, SIDE / 2)
}

#[test]
fn renders_and_traced_images_have_the_same_bits() {
    let image = |shop: &Workshop| shop.bytes("out.exr");
    for scene in [&plane as &dyn Fn(&Workshop) -> String, &stripes] {
        let first = same(scene, "trace scene.toml --samples 8 --output out.exr", image);
        let other = with("2", scene, "trace scene.toml --samples 8 --seed 2 --output out.exr", image);
        assert!(first != other, "another seed has other bits");
        for model in ["small-angle", "wide-angle"] {
            same(scene, &format!("render scene.toml --model {model} --output out.exr"), image);
        }
    }
}

#[test]
fn more_threads_than_a_machine_can_have_are_not_started() {
    let image = |shop: &Workshop| shop.bytes("out.exr");
    let traced = |threads| with(threads, &plane, "trace scene.toml --samples 8 --output out.exr", image);
    let one = traced("1");
    assert!(["0", "1000000", "99999999999999999999", "many"].iter().all(|threads| traced(threads) == one));
}

#[test]
fn fits_have_the_same_bits() {
    let result = |shop: &Workshop| {
        let mut report: Value = serde_json::from_slice(&shop.bytes("result/fit.json")).unwrap();
        // What is of this run: the time, the folder, and pictures of both.
        for key in ["provenance", "files"] {
            report.as_object_mut().unwrap().remove(key).unwrap();
        }
        report["fit"].as_object_mut().unwrap().remove("seconds").unwrap();
        (report, shop.bytes("result/render.exr"), shop.bytes("result/residual.exr"))
    };
    for (scene, model) in [
        (&plane as &dyn Fn(&Workshop) -> String, "small-angle"),
        (&plane, "wide-angle"),
        (&plane, "traced --paths 20000"),
        (&stripes, "small-angle"),
    ] {
        same(scene, &format!("fit scene.toml --model {model} --out result"), result);
    }
}
