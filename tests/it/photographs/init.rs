//! `narrowbeam init`: from two pictures to a fit in two commands.

use super::made::{jpeg_with_exif, png};
use crate::common::program::{narrowbeam, refuses, succeeds};
use std::path::Path;

const SIDE: u32 = 64;

/// Squares and shades, blurred over five pixels and dimmed if `turbid`.
fn code(x: u32, y: u32, turbid: bool) -> u16 {
    let sharp = |x: i64, y: i64| {
        let shade = 6000.0 * (0.3 * x as f64 + 0.17 * y as f64).sin();
        let noise = ((x * 7919 + y * 104_729 + i64::from(turbid) * 31).rem_euclid(1009)) as f64 * 0.3;
        (if (x.div_euclid(9) + y.div_euclid(7)) % 2 == 0 { 15_000.0 } else { 40_000.0 }) + shade + noise
    };
    let (x, y) = (i64::from(x), i64::from(y));
    if !turbid {
        return sharp(x, y) as u16;
    }
    let around = (-4..5).flat_map(|v| (-4..5).map(move |u| (u, v)));
    let blurred = around.map(|(u, v)| sharp(x + u, y + v)).sum::<f64>() / 81.0;
    (0.45 * sharp(x, y) + 0.35 * blurred) as u16
}

fn photographs(dir: &Path) {
    for (name, turbid) in [("clear.png", false), ("turbid.png", true)] {
        let codes: Vec<u16> = (0..SIDE * SIDE).map(|i| code(i % SIDE, i / SIDE, turbid)).collect();
        std::fs::write(dir.join(name), png(SIDE, SIDE, 1, &codes, &[])).unwrap();
    }
}

const INIT: [&str; 10] = [
    "init",
    "pond",
    "--clear",
    "clear.png",
    "--turbid",
    "turbid.png",
    "--depth",
    "1.5",
    "--view-width",
    "0.64",
];

#[test]
fn two_photographs_are_fitted_in_two_commands() {
    let dir = tempfile::tempdir().unwrap();
    photographs(dir.path());
    let text = succeeds(dir.path(), &[&INIT[..], &["--transfer", "linear"]].concat());
    for word in
        ["contrast", "shifted by", "noise", "no larger than the turbid one", "sigma_s", "narrowbeam fit"]
    {
        assert!(text.contains(word), "{word} is not in: {text}");
    }
    let scene = std::fs::read_to_string(dir.path().join("pond/scene.toml")).unwrap();
    assert!(
        scene.contains("radiance = \"../clear.png\"") && scene.contains("pixel_pitch = 0.01 "),
        "{scene}"
    );
    let fit = narrowbeam(dir.path(), &["fit", "pond/scene.toml", "--out", "result"]);
    // Gain and veil are free: sigma_a remains open.
    assert_eq!(fit.status.code(), Some(3), "{}", String::from_utf8_lossy(&fit.stderr));
    refuses(
        dir.path(),
        &[&INIT[..], &["--transfer", "linear"]].concat(),
        &["pond/scene.toml", "is there already"],
    );
    assert_eq!(std::fs::read_to_string(dir.path().join("pond/scene.toml")).unwrap(), scene);
}

#[test]
fn what_is_wrong_is_refused_and_leaves_nothing() {
    let dir = tempfile::tempdir().unwrap();
    photographs(dir.path());
    refuses(dir.path(), &INIT, &["--transfer is missing", "srgb"]);
    let transfer = |name| [&INIT[..], &["--transfer", name]].concat();
    refuses(dir.path(), &transfer("log"), &["log"]);
    refuses(dir.path(), &transfer("none.csv"), &["none.csv"]);
    let two_sizes = [&transfer("srgb")[..], &["--fov", "40"]].concat();
    refuses(dir.path(), &two_sizes, &["--view-width", "--fov"]);
    std::fs::write(dir.path().join("turbid.png"), jpeg_with_exif(80, 80, |x, y| (x * y) as u8, 1)).unwrap();
    refuses(dir.path(), &transfer("srgb"), &["turbid.png", "80x80", "at most the object image's 64x64 px"]);
    assert!(!dir.path().join("pond").exists());
}

#[test]
fn other_ways_to_state_the_size_are_taken() {
    for (option, value, line) in
        [("--pixel-pitch", "0.02", "pixel_pitch = 0.02 "), ("--fov", "30", "fov_x_deg = 30.0 ")]
    {
        let dir = tempfile::tempdir().unwrap();
        photographs(dir.path());
        let arguments = [&INIT[..8], &[option, value, "--transfer", "2.2"]].concat();
        succeeds(dir.path(), &arguments);
        let scene = std::fs::read_to_string(dir.path().join("pond/scene.toml")).unwrap();
        assert!(scene.contains(line) && scene.contains("transfer = 2.2 "), "{scene}");
    }
}
