//! `narrowbeam reproduce`: the paper's experiments, as pictures and tables.

mod errors;
mod figure_4;
mod figure_5;
mod figure_6;
mod figure_8;

use super::console::say;
use super::progress::Progress;
use crate::error::Result;
use crate::io::atomic;
use crate::lab::paper::{self, Effort, Experiment, Rings};
use clap::ValueEnum;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// The figure to make
    #[arg(value_enum, default_value = "all")]
    figure: Figure,
    /// Directory to write the figures to, as PNG and SVG, and their numbers as CSV; made if necessary
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Trace a fiftieth of the photons, coarser maps and pictures: a check in seconds
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
    /// Image synthesis: inputs, parts and outcome
    Fig8,
    /// All of them
    All,
}

/// How a figure is made.
struct Recipe {
    files: &'static [&'static str],
    /// Writes the files into a directory and returns the text to print.
    make: fn(&Path, Effort) -> Result<String>,
}

const FIGURE_4: Recipe = Recipe {
    files: &figure_4::FILES,
    make: |dir, effort| traced(&figure_4::FILES, &paper::figure_4::experiments(effort), dir, figure_4::write),
};
const FIGURE_5: Recipe = Recipe {
    files: &figure_5::FILES,
    make: |dir, effort| traced(&figure_5::FILES, &paper::figure_5::experiments(effort), dir, figure_5::write),
};
const FIGURE_6: Recipe = Recipe {
    files: &figure_6::FILES,
    make: |dir, effort| traced(&figure_6::FILES, &paper::figure_6::experiments(effort), dir, figure_6::write),
};
const FIGURE_8: Recipe = Recipe { files: &figure_8::FILES, make: figure_8::make };

impl Figure {
    fn recipes(self) -> Vec<Recipe> {
        match self {
            Figure::Fig4 => vec![FIGURE_4],
            Figure::Fig5 => vec![FIGURE_5],
            Figure::Fig6 => vec![FIGURE_6],
            Figure::Fig8 => vec![FIGURE_8],
            Figure::All => vec![FIGURE_4, FIGURE_5, FIGURE_6, FIGURE_8],
        }
    }
}

/// A figure of traced experiments: runs them and writes the results.
fn traced(
    files: &[&str],
    experiments: &[Experiment],
    dir: &Path,
    write: fn(&Path, &[Rings]) -> Result<String>,
) -> Result<String> {
    let start = Instant::now();
    let paths = experiments.iter().map(|e| e.paths).sum();
    let progress = Progress::new(files[0], "photons", paths);
    let mut rings = Vec::new();
    for experiment in experiments {
        rings.extend(experiment.run(&|done| progress.add(done))?);
    }
    drop(progress);
    let text = write(dir, &rings)?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(format!("{text}{}: {paths} photons, {seconds:.1} s\n\n", files.join(", ")))
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let recipes = arguments.figure.recipes();
    let effort = if arguments.quick { Effort::Quick } else { Effort::Full };
    let _folder = atomic::create_dir(&arguments.out)?;
    for file in recipes.iter().flat_map(|recipe| recipe.files) {
        atomic::check_writable(&arguments.out.join(file))?;
    }
    for recipe in recipes {
        say(&(recipe.make)(&arguments.out, effort)?);
    }
    Ok(ExitCode::SUCCESS)
}
