//! `narrowbeam forecast`: the predicted errors of a planned measurement.

use super::backend::Chosen;
use super::console::{self, warn};
use super::options::{MediumOptions, RenderOptions, positive, say_slips};
use super::progress::Progress;
use super::record::tell_inputs;
use super::{UNDETERMINED, aligned};
use crate::fit::{Plan, Settings, forecast};
use crate::geometry::path_lengths;
use crate::scene::Scene;
use anyhow::Result;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scene files with the expected medium; several share that of the first
    #[arg(required = true, value_name = "SCENE.toml")]
    scenes: Vec<PathBuf>,
    #[command(flatten)]
    rendering: RenderOptions,
    #[command(flatten)]
    medium: MediumOptions,
    /// Standard deviation of a pixel's noise, in units of the object's radiance
    #[arg(long, value_name = "X", value_parser = positive)]
    noise: f64,
    /// The gain of the images will not be known
    #[arg(long)]
    free_gain: bool,
    /// The veil over the images will not be known
    #[arg(long)]
    free_veil: bool,
    /// Print the report as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    let scenes = arguments.scenes.iter().map(|path| Scene::read(path)).collect::<crate::Result<Vec<_>>>()?;
    scenes.iter().for_each(|scene| tell_inputs(&scene.files));
    let media = scenes[0].media(arguments.medium.values())?;
    say_slips(&scenes[0], &media);
    let chosen = Chosen::new(arguments.rendering.backend, &scenes, [1, 2])?;
    let geometries: Vec<_> = scenes.iter().map(|scene| (&scene.geometry, &scene.object[0].image)).collect();
    let progress = Progress::uncounted("predicting errors");
    let settings = Settings {
        model: arguments.rendering.model.for_media(&media, path_lengths(&geometries)),
        backend: chosen.backend(),
        ..Settings::default()
    };
    let plan =
        Plan { noise: arguments.noise, free_gain: arguments.free_gain, free_veil: arguments.free_veil };
    let fit = forecast(&scenes, &media, &plan, &settings, arguments.rendering.filter)?;
    drop(progress);
    let report = &fit.report;
    // The images are noiseless: their chi² means nothing.
    let remarks = report.remarks().into_iter().filter(|line| !line.starts_with("chi²"));
    let text = remarks.fold(aligned(&report.table("1/length")), |text, line| text + &line + "\n");
    console::answer(arguments.json, report, &text)?;
    for warning in &report.warnings {
        warn(&format!("warning ({}): {}", warning.code, warning.message));
    }
    Ok(if report.is_complete() { ExitCode::SUCCESS } else { ExitCode::from(UNDETERMINED) })
}
