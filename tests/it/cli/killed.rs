//! Fits that are killed, or interrupted, at any moment.

use super::whole::is_whole;
use super::workshop::{SCENE, Workshop};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// How many fits of the tests are killed, and how many of the longer run.
const FEW: u32 = 20;
const MANY: u32 = 200;

/// What is in the folder beside results.
const INPUTS: [&str; 3] = ["object.exr", "observed.exr", "scene.toml"];

/// Kills so many fits, each at a moment of its own. What was there before stays, whole, until a new set is there, whole; a
/// folder with other things in it may hold a set that is not, and that can be told.
fn kills(count: u32) {
    let shop = Workshop::new();
    shop.observe(SCENE);
    let inputs = INPUTS.map(|name| shop.bytes(name));
    std::fs::create_dir(shop.file("mixed")).unwrap();
    shop.write("mixed/notes.txt", "mine");
    let fit = |folder: &str| format!("fit scene.toml --model small-angle --out {folder}");
    let timed = |_| {
        let start = Instant::now();
        assert!(shop.command(&fit("own")).status().unwrap().success());
        start.elapsed()
    };
    let whole = (0..3).map(timed).min().unwrap();
    assert!(shop.command(&fit("mixed")).status().unwrap().success() && is_whole(&shop.file("mixed")));
    let mut random = Xoshiro256PlusPlus::seed_from_u64(18);
    let (mut killed, mut not_whole) = (0, 0);
    for i in 0..count {
        let folder = ["own", "mixed"][i as usize % 2];
        let share = f64::from(random.next_u32()) / f64::from(u32::MAX);
        // Half of them near the end, where files are put in their places.
        let share = if i % 4 < 2 { share } else { 0.6 + share };
        let mut child = shop.command(&fit(folder)).spawn().unwrap();
        std::thread::sleep(whole.mul_f64(share));
        child.kill().unwrap();
        killed += u32::from(!child.wait().unwrap().success());
        assert!(is_whole(&shop.file("own")), "kill {i}");
        not_whole += u32::from(!is_whole(&shop.file("mixed")));
        assert_eq!(INPUTS.map(|name| shop.bytes(name)), inputs, "kill {i}");
        assert_eq!(shop.bytes("mixed/notes.txt"), b"mine");
    }
    println!(
        "{killed} of {count} fits were killed, a full one takes {whole:?}; {not_whole} times a set was not whole and said so"
    );
    assert!(killed >= count / 4, "{killed} of {count} were killed");
    // The next ones remove what the killed ones have left.
    for folder in ["own", "mixed"] {
        let run = shop.run(&fit(folder));
        assert_eq!(run.code, 0, "{}", run.stderr);
        assert!(is_whole(&shop.file(folder)));
    }
    assert_eq!((shop.names("own").len(), shop.names("mixed").len()), (8, 9));
    assert_eq!(shop.names("."), ["mixed", "object.exr", "observed.exr", "own", "scene.toml"]);
}

#[test]
fn a_killed_fit_loses_nothing() {
    kills(FEW);
}

/// `cargo test --release --test it killed:: -- --ignored --nocapture`
#[test]
#[ignore = "takes a minute"]
fn of_many_killed_fits_none_loses_anything() {
    kills(MANY);
}

/// Waits until `done`, and fails if that takes too long.
fn wait_until(what: &str, done: impl Fn() -> bool) {
    let start = Instant::now();
    while !done() {
        assert!(start.elapsed() < Duration::from_secs(60), "{what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([&format!("-{name}"), &id]).status().unwrap().success());
}

#[test]
fn a_signal_ends_a_command_at_once_and_leaves_nothing() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    let before = shop.names(".");
    let fit = "fit scene.toml --model traced --paths 67108864 --out deep/result";
    let kernel = "kernel --sigma-s 1 --sigma-a 0 --b 0.01 --depth 2 --photons 1000000000000 --out kernel";
    for (command, made) in [(fit, "deep"), (kernel, "kernel")] {
        for (name, code) in [("INT", 130), ("TERM", 143)] {
            let mut child = shop.command(command).spawn().unwrap();
            wait_until(command, || shop.file(made).exists());
            std::thread::sleep(Duration::from_millis(20));
            signal(&child, name);
            let start = Instant::now();
            assert_eq!(child.wait().unwrap().code(), Some(code), "{command}");
            assert!(start.elapsed() < Duration::from_secs(1), "{command}: {:?}", start.elapsed());
            assert_eq!(shop.names("."), before, "{command}");
        }
    }
}

#[test]
fn an_interrupted_fit_leaves_the_set_before_it() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    assert_eq!(shop.run("fit scene.toml --model small-angle --out result").code, 0);
    let report = shop.bytes("result/fit.json");
    let mut child =
        shop.command("fit scene.toml --model traced --paths 67108864 --out result").spawn().unwrap();
    wait_until("a part", || shop.names(".").iter().any(|name| name.ends_with(".part")));
    signal(&child, "INT");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(is_whole(&shop.file("result")) && shop.bytes("result/fit.json") == report);
    assert!(shop.names(".").iter().all(|name| !name.ends_with(".part")));
}
