//! Fits the medium of one scene file and prints each parameter with its standard error:
//! `cargo run --release --example fit_one_image -- datasets/mitsuba-checker/scene.toml`

use narrowbeam::filter::Filter;
use narrowbeam::fit::{Settings, fit_scenes};
use narrowbeam::scene::ObservedScene;
use std::path::PathBuf;

fn main() -> anyhow::Result<()> {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        anyhow::bail!("usage: fit_one_image SCENE.toml");
    };
    let scene = ObservedScene::read(&path)?;
    let fit = fit_scenes(&[scene], &Settings::default(), Filter::Auto, &|| ())?.report;

    for (name, estimate) in &fit.parameters {
        let value = estimate.value.unwrap_or(f64::NAN);
        match estimate.std_error {
            Some(error) => println!("{name:8} {value:.6} ± {error:.6}"),
            None => println!("{name:8} {value:.6} ({:?})", estimate.status),
        }
    }
    for warning in &fit.warnings {
        eprintln!("warning ({}): {}", warning.code, warning.message);
    }
    Ok(())
}
