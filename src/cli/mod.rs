//! The command line: one file per command.

mod backend;
mod calibrate;
mod chart;
mod errors;
mod fit;
mod forecast;
mod kernel;
mod names;
mod options;
mod progress;
mod render;
mod reproduce;
mod stability;
mod synthesize;
mod table;
mod trace;

use crate::error::Error;
use crate::memory::set_budget;
use clap::{Parser, Subcommand};
use std::io::Write;
use std::process::ExitCode;

/// A fit that did not converge, or that left a free parameter undetermined.
const UNDETERMINED: u8 = 3;

#[derive(Debug, Parser)]
#[command(name = "narrowbeam", version, about, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
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

/// Writes `text` to stdout. A closed pipe is not an error.
fn say(text: &str) -> crate::Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        done => done.map_err(|source| Error::Write { path: "standard output".into(), source }),
    }
}

/// Runs the command that the process was started with and returns its exit code: 0 done; 2 bad usage or input;
/// 3 a fit that did not converge or left a parameter undetermined; 1 anything else.
pub fn main() -> ExitCode {
    let Arguments { command, memory } = Arguments::parse();
    memory.into_iter().for_each(set_budget);
    let done = match command {
        Command::Fit(arguments) => fit::run(&arguments),
        Command::Forecast(arguments) => forecast::run(&arguments),
        Command::Render(arguments) => render::run(&arguments),
        Command::Synthesize(arguments) => synthesize::run(&arguments),
        Command::Trace(arguments) => trace::run(&arguments),
        Command::Kernel(arguments) => kernel::run(&arguments),
        Command::Reproduce(arguments) => reproduce::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Stability(arguments) => stability::run(&arguments),
        Command::Chart(arguments) => chart::run(&arguments),
        Command::Table(arguments) => table::run(&arguments),
    };
    done.unwrap_or_else(|error| errors::report(&error))
}
