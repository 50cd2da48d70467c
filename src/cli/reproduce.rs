//! `narrowbeam reproduce`: the paper's experiments again, as pictures and tables.

mod errors;
mod figure_4;
mod figure_5;
mod figure_6;

use super::progress::Progress;
use super::say;
use crate::error::{Error, Result};
use crate::io::atomic;
use crate::paper::{self, Effort, Experiment, Rings};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The figure to make
    #[arg(value_enum, default_value = "all")]
    figure: Figure,
    /// Directory to write the figures to, as PNG and SVG, and their numbers as CSV; made if need be
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Trace a fiftieth of the photons, coarser maps: a check in seconds
    #[arg(long)]
    quick: bool,
}

/// A figure of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Figure {
    /// Maps of 2πrΨ over (r, z), traced beside each kernel
    Fig4,
    /// The kernels' rms error against the spread angle
    Fig5,
    /// Profiles of 2πrΨ at a low and a high albedo
    Fig6,
    /// Images (not built yet)
    Fig8,
    /// All that are built
    All,
}

/// How a figure comes about.
struct Recipe {
    files: &'static [&'static str],
    experiments: fn(Effort) -> Vec<Experiment>,
    /// Writes the files and returns what is to be said.
    write: fn(&Path, &[Rings]) -> Result<String>,
}

const FIGURE_4: Recipe =
    Recipe { files: &figure_4::FILES, experiments: paper::figure_4::experiments, write: figure_4::write };
const FIGURE_5: Recipe =
    Recipe { files: &figure_5::FILES, experiments: paper::figure_5::experiments, write: figure_5::write };
const FIGURE_6: Recipe =
    Recipe { files: &figure_6::FILES, experiments: paper::figure_6::experiments, write: figure_6::write };

impl Figure {
    fn recipes(self) -> Result<Vec<Recipe>> {
        match self {
            Figure::Fig4 => Ok(vec![FIGURE_4]),
            Figure::Fig5 => Ok(vec![FIGURE_5]),
            Figure::Fig6 => Ok(vec![FIGURE_6]),
            Figure::Fig8 => Err(Error::NotBuilt("fig8".into())),
            Figure::All => Ok(vec![FIGURE_4, FIGURE_5, FIGURE_6]),
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let recipes = arguments.figure.recipes()?;
    let effort = if arguments.quick { Effort::Quick } else { Effort::Full };
    atomic::create_dir(&arguments.out)?;
    for file in recipes.iter().flat_map(|recipe| recipe.files) {
        atomic::check_writable(&arguments.out.join(file))?;
    }
    for recipe in recipes {
        let start = Instant::now();
        let experiments = (recipe.experiments)(effort);
        let paths = experiments.iter().map(|e| e.paths).sum();
        let progress = Progress::new(recipe.files[0], "photons", paths);
        let mut rings = Vec::new();
        for experiment in &experiments {
            rings.extend(experiment.run(&|done| progress.add(done))?);
        }
        drop(progress);
        let text = (recipe.write)(&arguments.out, &rings)?;
        let files = recipe.files.join(", ");
        let seconds = start.elapsed().as_secs_f64();
        say(&format!("{text}{files}: {paths} photons, {seconds:.1} s\n\n"))?;
    }
    Ok(ExitCode::SUCCESS)
}
