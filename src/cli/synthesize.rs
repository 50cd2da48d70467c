//! `narrowbeam synthesize`: all the light of a scene, including that of the illumination.

use super::backend::Chosen;
use super::console::warn;
use super::errors::Usage;
use super::names::WantedModel;
use super::options::{MediumOptions, RenderOptions, exr_only, output_image, say_slips, validity};
use super::outputs;
use super::progress::Progress;
use super::record::{provenance, record_of, tell_inputs};
use crate::filter::CUT;
use crate::geometry::median;
use crate::image::Channel;
use crate::io::identity::same;
use crate::io::{exr, picture};
use crate::phase::PhaseFunction;
use crate::scene::LitScene;
use crate::spread::{Model, SMALL_ANGLE_LIMIT, small_angle_error};
use crate::synthesis::{Synthesis, synthesize};
use anyhow::Result;
use clap::builder::{PathBufValueParser, TypedValueParser};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scene file with an [illumination]
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    #[command(flatten)]
    rendering: RenderOptions,
    #[command(flatten)]
    medium: MediumOptions,
    /// Image to write: direct + scattered object light + veil, as .exr, .tif, .pfm or .hdr (linear), or .png (an 8-bit picture)
    #[arg(long, value_name = "FILE", value_parser = PathBufValueParser::new().try_map(output_image))]
    output: PathBuf,
    /// Also write its parts as channels of an EXR: clear.R (object in clear air), direct.R, scattered.R, veil.R, ...
    #[arg(long, value_name = "FILE.exr", value_parser = PathBufValueParser::new().try_map(exr_only))]
    parts: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    let lit = LitScene::read(&arguments.scene)?;
    tell_inputs(&lit.scene.files);
    let media = lit.scene.media(arguments.medium.values())?;
    say_slips(&lit.scene, &media);
    outputs::check(&arguments.output, &lit.scene.files)?;
    if let Some(path) = &arguments.parts {
        if same(path, &arguments.output) {
            Err(Usage(format!("--parts {}: is --output too", path.display())))?;
        }
        outputs::check(path, &lit.scene.files)?;
    }
    let chosen = Chosen::new(arguments.rendering.backend, [&lit.scene], [1, 1])?;
    let model = match arguments.rendering.model {
        WantedModel::This(model) => model,
        // For pictures: wide-angle takes minutes and gigabytes where a perspective camera looks through an oblique surface.
        WantedModel::Auto => Model::SmallAngle,
    };
    let progress = Progress::uncounted("synthesizing");
    let made = synthesize(&lit, &media, model, arguments.rendering.filter, chosen.backend())?;
    drop(progress);

    let mut attributes = provenance();
    attributes.push(("model".into(), model.name().into()));
    attributes.push(("backend".into(), chosen.describe()));
    attributes.extend(record_of(&media));
    let total = made.total();
    picture::write(&arguments.output, &total, &attributes)?;
    if let Some(path) = &arguments.parts {
        exr::write_finite(path, &layers(&made), &attributes)?;
    }
    if made.cut {
        warn(&format!("warning (kernel_cut): {CUT}"));
    }
    let z = median(lit.scene.geometry.path_lengths());
    for (channel, medium) in total.iter().zip(&media) {
        let validity = validity(medium, z);
        if model.rests_on_small_angles() && validity > SMALL_ANGLE_LIMIT {
            warn(&format!(
                "warning (outside_validity): tau·{} of channel {} is {validity:.3}, above {SMALL_ANGLE_LIMIT}: {} rests \
                 on small angles, whose transfer function is off by {} there",
                medium.phase().family().mean_square_angle_formula(),
                channel.name,
                model,
                small_angle_error(validity)
            ));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// The parts as channels of one file, each behind its name.
fn layers(made: &Synthesis) -> Vec<Channel> {
    let parts = [
        ("clear", &made.clear),
        ("direct", &made.direct),
        ("scattered", &made.scattered),
        ("veil", &made.veil),
    ];
    let layer = |(part, channels): (&str, &Vec<Channel>)| -> Vec<Channel> {
        channels
            .iter()
            .map(|c| Channel { name: format!("{part}.{}", c.name), image: c.image.clone() })
            .collect()
    };
    parts.into_iter().flat_map(layer).collect()
}
