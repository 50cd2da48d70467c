//! Completions and manual pages: they know every command and every option.

use super::workshop::Workshop;

const COMMANDS: [&str; 13] = [
    "fit",
    "forecast",
    "render",
    "synthesize",
    "trace",
    "kernel",
    "reproduce",
    "calibrate",
    "stability",
    "chart",
    "table",
    "completions",
    "man",
];

#[test]
fn shells_and_manuals_know_the_commands_and_their_options() {
    let shop = Workshop::new();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = shop.run(&format!("completions {shell}"));
        assert!(run.code == 0 && run.stderr.is_empty());
        for word in COMMANDS.into_iter().chain(["hidden-share"]) {
            assert!(run.stdout.contains(word), "{shell} does not know {word}");
        }
    }
    assert_eq!(shop.run("completions cmd").code, 2);
    let all = shop.run("man").stdout;
    assert!(all.contains(".TH narrowbeam") && COMMANDS.iter().all(|name| all.contains(name)), "{all}");
    let fit = shop.run("man fit").stdout;
    let options = ["bootstrap", "traced\\-limit", "quiet"];
    assert!(fit.contains(".TH narrowbeam-fit") && options.iter().all(|o| fit.contains(o)), "{fit}");
    let run = shop.run("man melt");
    assert!(run.code == 2 && run.stderr.contains("melt"), "{}", run.stderr);
}
