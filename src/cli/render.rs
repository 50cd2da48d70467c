//! `narrowbeam render`: a scene through its medium by a spread model.

use super::options::{Backend, MediumOptions, parse_backend, parse_model, provenance};
use super::progress::Progress;
use crate::filter::cpu::{CUT, CpuFilter};
use crate::filter::{Filter, Optics, Target};
use crate::image::Channel;
use crate::io::{atomic, exr};
use crate::medium::Medium;
use crate::phase::Gaussian;
use crate::scene::{Purpose, Scene};
use crate::spread::Model;
use anyhow::Result;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Spread model: beer-lambert, single-scatter, gaussian, narrow-beam-printed, narrow-beam, small-angle or auto
    #[arg(long, default_value = "auto", value_parser = parse_model)]
    model: Model,
    /// Filter for depth maps: eq29, composite, or auto: composite where the depth map has edges or slopes
    #[arg(long, default_value = "auto")]
    filter: Filter,
    /// Where to compute: cpu or auto
    #[arg(long, default_value = "auto", value_parser = parse_backend)]
    backend: Backend,
    #[command(flatten)]
    medium: MediumOptions,
    /// Image to write
    #[arg(long, value_name = "FILE.exr")]
    output: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    let scene = Scene::read(&arguments.scene, Purpose::Render)?;
    let media = scene.medium_values(arguments.medium.values())?;
    atomic::check_writable(&arguments.output)?;
    let progress = Progress::uncounted("rendering");
    let relief = arguments.filter.relief(&scene.geometry);
    let mut cut = false;
    let mut channels = Vec::new();
    for ((object, behind), values) in scene.object.iter().zip(&scene.behind).zip(&media) {
        let phase = Gaussian::new(values.b)?;
        let medium = Medium::new(values.sigma_s, values.sigma_a)?;
        let optics = Optics { model: arguments.model, medium, phase: &phase };
        let target = Target {
            radiance: &object.image,
            behind,
            geometry: &scene.geometry,
            border: scene.border,
            view: scene.view,
            relief: relief.as_ref(),
        };
        let filter = CpuFilter::new(target, &optics, 1.0)?;
        let image = filter.render(&optics)?;
        cut |= filter.coverage(&optics)?.cut;
        channels.push(Channel { name: object.name.clone(), image });
    }
    drop(progress);
    let mut attributes = provenance();
    attributes.push(("model".into(), arguments.model.name().into()));
    attributes.push(("filter".into(), Filter::of(relief.as_ref()).name().into()));
    attributes.push(("backend".into(), arguments.backend.name().into()));
    attributes.push(("medium".into(), format!("{media:?}")));
    exr::write(&arguments.output, &channels, &attributes)?;
    if cut {
        eprintln!("warning (kernel_cut): {CUT}");
    }
    Ok(ExitCode::SUCCESS)
}
