//! `narrowbeam render`: a scene through its medium by a spread model.

use super::backend::Chosen;
use super::console::warn;
use super::errors::Usage;
use super::options::{
    MediumOptions, RenderOptions, TracingOptions, exr_or_png, has_extension, output_image, say_slips,
};
use super::outputs;
use super::progress::Progress;
use super::record::{provenance, record_of, tell_inputs};
use crate::filter::{CUT, Filter, Target};
use crate::forward::Engine;
use crate::geometry::path_lengths;
use crate::image::{Channel, Image};
use crate::io::identity::same;
use crate::io::{exr, picture};
use crate::plots::{Figure, Panel, Shade};
use crate::scene::Scene;
use anyhow::Result;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    #[command(flatten)]
    rendering: RenderOptions,
    #[command(flatten)]
    tracing: TracingOptions,
    #[command(flatten)]
    medium: MediumOptions,
    /// Image to write, in the format that its name ends in: .exr, .tif, .pfm or .hdr (linear), or .png (an 8-bit picture)
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(output_image))]
    output: PathBuf,
    /// Also write the share of each pixel's light that may be hidden behind near surfaces, where no layer shows it: an
    /// EXR of the object's channels, or a PNG picture
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(exr_or_png))]
    hidden_share: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    arguments.tracing.check(&arguments.rendering)?;
    let scene = Scene::read(&arguments.scene)?;
    tell_inputs(&scene.files);
    let media = scene.media(arguments.medium.values())?;
    say_slips(&scene, &media);
    check_outputs(arguments, &scene.files)?;
    let chosen = Chosen::new(arguments.rendering.backend, [&scene], [1, 1])?;
    let progress = Progress::uncounted("rendering");
    let model = arguments
        .rendering
        .model
        .for_media(&media, path_lengths(&[(&scene.geometry, &scene.object[0].image)]));
    let engine = Engine { model, backend: chosen.backend(), tracing: arguments.tracing.tracing() };
    let relief = arguments.rendering.filter.relief(&scene.geometry);
    let mut cut = false;
    let (mut channels, mut shares) = (Vec::new(), Vec::new());
    for ((object, behind), &medium) in scene.object.iter().zip(&scene.behind).zip(&media) {
        let target = Target {
            radiance: &object.image,
            behind,
            geometry: &scene.geometry,
            border: scene.border,
            sampling: scene.sampling,
            view: scene.view,
            relief: relief.as_ref(),
        };
        let named = |image| Channel { name: object.name.clone(), image };
        let rendered = engine.render(target, medium)?;
        cut |= rendered.cut;
        channels.push(named(rendered.image));
        if arguments.hidden_share.is_some() {
            let nothing = || Image::filled(scene.view.width, scene.view.height, 0.0);
            shares.push(named(engine.hidden_share(target, &medium.into())?.unwrap_or_else(nothing)));
        }
    }
    drop(progress);
    let mut attributes = provenance();
    attributes.push(("model".into(), model.name().into()));
    attributes.push(("filter".into(), Filter::of(relief.as_ref()).name().into()));
    attributes.push(("backend".into(), chosen.describe()));
    attributes.extend(record_of(&media));
    picture::write(&arguments.output, &channels, &attributes)?;
    match &arguments.hidden_share {
        Some(path) if has_extension(path, "png") => draw_hidden_share(path, &scene, shares)?,
        Some(path) => exr::write_finite(path, &shares, &attributes)?,
        None => (),
    }
    if cut {
        warn(&format!("warning (kernel_cut): {CUT}"));
    }
    Ok(ExitCode::SUCCESS)
}

/// Refuses outputs that contradict other options or cannot be written.
fn check_outputs(arguments: &Arguments, inputs: &[PathBuf]) -> Result<()> {
    outputs::check(&arguments.output, inputs)?;
    if let Some(path) = &arguments.hidden_share {
        let refuse = |why| Err(Usage(format!("--hidden-share {}: {why}", path.display())));
        if arguments.rendering.filter == Filter::Eq29 {
            refuse(
                "--filter eq29 lets light pass through near surfaces, so no light is hidden; use composite or auto",
            )?;
        }
        if same(path, &arguments.output) {
            refuse("is --output too")?;
        }
        outputs::check(path, inputs)?;
    }
    Ok(())
}

/// Writes the picture of the share of hidden light with its colour bar.
fn draw_hidden_share(path: &Path, scene: &Scene, shares: Vec<Channel>) -> crate::Result<()> {
    let shade = Shade::from_zero(&shares);
    let title = if shares.len() == 1 { "" } else { ", mean of the channels" };
    let panel = Panel { title: format!("share of hidden light{title}"), channels: shares, shade };
    let figure = Figure {
        title: scene.path.display().to_string(),
        panels: vec![panel],
        columns: 1,
        table: Vec::new(),
        notes: Vec::new(),
    };
    figure.write_png(path)
}
