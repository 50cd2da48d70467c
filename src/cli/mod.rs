//! The command line: one file per command.

mod backend;
mod calibrate;
mod chart;
mod console;
mod documents;
mod errors;
mod fit;
mod forecast;
mod init;
mod kernel;
mod names;
mod options;
mod outputs;
mod pool;
mod progress;
mod record;
mod render;
mod reproduce;
mod results;
mod signals;
mod stability;
mod synthesize;
mod table;
mod trace;

use crate::memory::set_budget;
use clap::{CommandFactory, Parser, Subcommand};
use console::Level;
use std::process::ExitCode;

/// A fit that did not converge, or that left a free parameter undetermined.
const UNDETERMINED: u8 = 3;

#[derive(Debug, Parser)]
#[command(name = "narrowbeam", version, about, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// Print warnings, errors and what --json asks for, nothing else
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Also print what is read, written and computed with
    #[arg(long, short, global = true)]
    verbose: bool,
    /// Memory that may be taken, such as 2GiB or 500MB [default: three quarters of what the machine or its control group has]
    #[arg(long, global = true, value_name = "SIZE", value_parser = options::size)]
    memory: Option<u64>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Estimate sigma_s, sigma_a and B from one or more observed scenes that share a medium
    Fit(fit::Arguments),
    /// Predict the errors and correlations of a planned measurement
    Forecast(forecast::Arguments),
    /// Write a scene file for two photographs, look at them, and say what to expect of a fit
    Init(init::Arguments),
    /// Render a scene through its medium with a spread model
    Render(render::Arguments),
    /// Synthesize a scene's image: direct and scattered light of the object, and the veil of the illumination
    Synthesize(synthesize::Arguments),
    /// Trace a scene through its medium path by path: the truth, with its variance
    Trace(trace::Arguments),
    /// Tabulate and draw the spread kernels of a medium, beside traced ones if wanted
    Kernel(kernel::Arguments),
    /// Reproduce the paper's experiments: its figures as PNG and SVG, with their numbers as CSV
    Reproduce(reproduce::Arguments),
    /// Fit noisy images of known media many times: do the error bars contain the truth as often as they should?
    Calibrate(calibrate::Arguments),
    /// Map where each method fails, and whether it reports that
    Stability(stability::Arguments),
    /// Chart speed against accuracy: renders and fits of scenes whose medium is known, by every model and backend
    Chart(chart::Arguments),
    /// Make a table behind the model wide-angle from scratch
    Table(table::Arguments),
    /// Print the completions of a shell: narrowbeam completions bash > /etc/bash_completion.d/narrowbeam
    Completions(documents::Completions),
    /// Print a manual page: narrowbeam man fit | man -l -
    Man(documents::Man),
}

/// The rows of a table as lines, in columns.
fn aligned(rows: &[Vec<String>]) -> String {
    let width =
        |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let line = |row: &Vec<String>| {
        let cells: Vec<String> =
            row.iter().enumerate().map(|(c, cell)| format!("{cell:<w$}", w = width(c))).collect();
        format!("{}\n", cells.join("   ").trim_end())
    };
    rows.iter().map(line).collect()
}

/// Runs the command that the process was started with and returns its exit code: 0 done; 2 bad usage or input;
/// 3 a fit that did not converge or left a parameter undetermined; 1 anything else.
pub fn main() -> ExitCode {
    let Arguments { command, quiet, verbose, memory } = Arguments::parse();
    console::set_level(match (quiet, verbose) {
        (true, _) => Level::Quiet,
        (_, true) => Level::Verbose,
        _ => Level::Normal,
    });
    memory.into_iter().for_each(set_budget);
    signals::watch();
    let done = pool::within(|| run(command)).unwrap_or_else(|error| Err(error.into()));
    done.unwrap_or_else(|error| errors::report(&error))
}

fn run(command: Command) -> anyhow::Result<ExitCode> {
    match command {
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Forecast(arguments) => forecast::run(&arguments),
        Command::Init(arguments) => init::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Synthesize(arguments) => synthesize::run(&arguments),
        Command::Trace(arguments) => trace::run(&arguments),
        Command::Kernel(arguments) => kernel::run(&arguments),
        Command::Reproduce(arguments) => reproduce::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Stability(arguments) => stability::run(&arguments),
        Command::Chart(arguments) => chart::run(&arguments),
        Command::Table(arguments) => table::run(&arguments),
        Command::Completions(arguments) => documents::completions(&arguments, Arguments::command()),
        Command::Man(arguments) => documents::man(&arguments, Arguments::command()),
    }
}
