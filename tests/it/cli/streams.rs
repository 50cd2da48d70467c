//! Streams that are closed, or full, change nothing.

use super::whole::is_whole;
use super::workshop::{SCENE, Workshop};

/// What may become of standard output and standard error.
const ENDS: [&str; 8] =
    [">&-", "2>&-", ">&- 2>&-", ">/dev/full", "2>/dev/full", ">/dev/full 2>&1", "| true", "2>&1 | true"];

/// How the program ended at the head of a pipe, or alone.
fn code(shop: &Workshop, command: &str, end: &str) -> String {
    let _ = std::fs::remove_file(shop.file("code"));
    shop.shell(&format!("{{ narrowbeam {command}; echo $? >code; }} {end}"));
    String::from_utf8(shop.bytes("code")).unwrap().trim().into()
}

#[test]
fn a_closed_or_full_stream_changes_no_exit_code_and_loses_no_result() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    shop.write("free.toml", &SCENE.replace("[medium]", "gain = \"free\"\n[medium]"));
    for end in ENDS {
        for (command, wanted) in [
            ("fit scene.toml --model small-angle --out result", "0"),
            ("fit scene.toml --model small-angle --json --verbose --out result", "0"),
            ("fit free.toml --model small-angle --out result", "3"),
            ("forecast scene.toml --noise 0.01 --json", "0"),
            ("trace scene.toml --samples 2 --output out.exr", "0"),
            ("fit none.toml", "2"),
            ("fit scene.toml --out", "2"),
            ("--help", "0"),
            ("fit --help", "0"),
            ("--version", "0"),
            ("completions bash", "0"),
            ("man", "0"),
        ] {
            let _ = std::fs::remove_dir_all(shop.file("result"));
            assert_eq!(code(&shop, command, end), wanted, "{command} {end}");
            assert!(!command.contains("--out result") || is_whole(&shop.file("result")), "{command} {end}");
        }
    }
}

#[test]
fn an_output_that_cannot_take_what_is_printed_is_told_of() {
    let shop = Workshop::new();
    shop.write("scene.toml", SCENE);
    let run = shop.shell("narrowbeam forecast scene.toml --noise 0.01 --json >/dev/full");
    assert_eq!(run.code, 0);
    assert!(run.stderr.contains("standard output: cannot be written"), "{}", run.stderr);
    let run = shop.shell("ln -s /dev/full full.exr; narrowbeam render scene.toml --output full.exr");
    assert_eq!(run.code, 1, "{}", run.stderr);
    assert!(run.stderr.contains("full.exr"), "{}", run.stderr);
}

#[test]
fn quiet_and_verbose_say_less_and_more() {
    let shop = Workshop::new();
    shop.observe(SCENE);
    let fit = "fit scene.toml --model small-angle --out result";
    let plain = shop.run(fit);
    let quiet = shop.run(&format!("{fit} --quiet"));
    let verbose = shop.run(&format!("--verbose {fit}"));
    assert_eq!([plain.code, quiet.code, verbose.code], [0; 3]);
    assert!(quiet.stdout.is_empty() && quiet.stderr.is_empty(), "{}{}", quiet.stdout, quiet.stderr);
    assert!(plain.stderr.is_empty() && verbose.stderr.contains("computing on cpu"), "{}", verbose.stderr);
    assert!(["scene.toml", "object.exr", "result"].iter().all(|word| verbose.stderr.contains(word)));
    let json = shop.run(&format!("{fit} --json --quiet"));
    assert!(json.stderr.is_empty() && json.stdout.starts_with('{'), "{}", json.stderr);
    assert_eq!(shop.run(&format!("{fit} --quiet --verbose")).code, 2);
}
