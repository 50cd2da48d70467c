//! `narrowbeam trace`: a scene's image by following paths, with the variance of each pixel.

use super::console::answer;
use super::options::{MediumOptions, has_extension, output_image, say_slips};
use super::outputs;
use super::progress::Progress;
use super::record::{provenance, record_of, tell_inputs};
use crate::image::{Channel, Image};
use crate::io::{exr, picture};
use crate::medium::Medium;
use crate::scene::Scene;
use crate::trace::{ImageConfig, trace_image};
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The scene file (TOML)
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Paths per pixel, at least 2: the variance is estimated from their differences
    #[arg(long, value_name = "N", default_value_t = 256, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(2..))]
    samples: u32,
    /// Seed of the random numbers: the same seed gives the same image, for any number of threads
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    #[command(flatten)]
    medium: MediumOptions,
    /// Image to write: an EXR of the channels Y and Y.variance, or R, R.variance, G, ...; without the variances a .tif, .pfm or .hdr
    /// (linear), or a .png (an 8-bit picture)
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(output_image))]
    output: PathBuf,
    /// Print the numbers as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

/// What was traced.
#[derive(Debug, Serialize)]
struct Traced {
    paths: u64,
    seconds: f64,
    paths_per_second: f64,
    seed: u64,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let scene = Scene::read(&arguments.scene)?;
    tell_inputs(&scene.files);
    let media = scene.media(arguments.medium.values())?;
    say_slips(&scene, &media);
    outputs::check(&arguments.output, &scene.files)?;

    let all = (scene.view.pixels() * scene.object.len()) as u64 * u64::from(arguments.samples);
    let progress = Progress::new("tracing", "paths", all);
    let start = Instant::now();
    let mut channels = Vec::new();
    let mut paths = 0;
    for (i, (object, &medium)) in scene.object.iter().zip(&media).enumerate() {
        let config = ImageConfig {
            geometry: &scene.geometry,
            radiance: &object.image,
            behind: &scene.behind[i],
            border: scene.border,
            view: scene.view,
            medium,
            samples: arguments.samples,
            seed: channel_seed(arguments.seed, i),
        };
        let traced = trace_image(&config, &|done| progress.add(done))?;
        paths += traced.paths;
        let mut push = |name: String, image: Image| channels.push(Channel { name, image });
        push(object.name.clone(), traced.mean);
        push(format!("{}.variance", object.name), traced.variance);
    }
    let seconds = start.elapsed().as_secs_f64();
    drop(progress);

    let attributes = record(arguments, &media);
    if has_extension(&arguments.output, "exr") {
        exr::write_finite(&arguments.output, &channels, &attributes)?;
    } else {
        // Each mean is followed by its variance.
        let means: Vec<Channel> = channels.into_iter().step_by(2).collect();
        picture::write(&arguments.output, &means, &attributes)?;
    }
    let rate = paths as f64 / seconds / 1e6;
    let traced = Traced { paths, seconds, paths_per_second: paths as f64 / seconds, seed: arguments.seed };
    let text = format!("traced {paths} paths in {seconds:.2} s: {rate:.2} million paths/s\n");
    answer(arguments.json, &traced, &text)?;
    Ok(ExitCode::SUCCESS)
}

/// The seed of channel `i`. The odd constant is 2^64 divided by the golden ratio: seeds counted 1, 2, 3 … do not
/// coincide with those of another channel.
fn channel_seed(seed: u64, i: usize) -> u64 {
    seed.wrapping_add((i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// How the image was made; one value per channel.
fn record(arguments: &Arguments, media: &[Medium]) -> Vec<(String, String)> {
    let mut pairs = provenance();
    pairs.push(("seed".into(), arguments.seed.to_string()));
    pairs.push(("samples".into(), arguments.samples.to_string()));
    pairs.extend(record_of(media));
    pairs
}
