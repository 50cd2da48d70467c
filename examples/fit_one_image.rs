//! Fits the medium of one scene file and prints each parameter with its standard error:
//! `cargo run --release --example fit_one_image -- datasets/mitsuba-checker/scene.toml`

use narrowbeam::filter::Filter;
use narrowbeam::fit::scenes::fit_scenes;
use narrowbeam::fit::{NAMES, Settings, Status};
use narrowbeam::scene::ObservedScene;
use std::path::PathBuf;

fn main() -> anyhow::Result<()> {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        anyhow::bail!("usage: fit_one_image SCENE.toml");
    };
    let scene = ObservedScene::read(&path)?;
    let fit = fit_scenes(&[scene], &Settings::default(), Filter::Auto)?;

    for (channel, result) in &fit.channels {
        let values = result.parameters.values();
        for (i, name) in NAMES.iter().enumerate() {
            // Errors of sigma_s and B are those of their logarithms.
            let scale = if i == 1 { 1.0 } else { values[i] };
            match (result.uncertainty.status(i), result.uncertainty.std_error(i)) {
                (Status::Free, Some(error)) => {
                    println!("{channel} {name:8} {:.6} ± {:.6}", values[i], scale * error);
                }
                (status, _) => println!("{channel} {name:8} {:.6} ({status:?})", values[i]),
            }
        }
    }
    for warning in &fit.report.warnings {
        eprintln!("warning ({}): {}", warning.code, warning.message);
    }
    Ok(())
}
