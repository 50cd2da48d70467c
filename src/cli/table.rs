//! `narrowbeam table`: makes a table of the model `wide-angle` from scratch.
//!
//! Nodes are independent, each with its own seed, and are written as they are done; a run that was killed continues
//! from the last one.

use super::console::answer;
use super::progress::Progress;
use super::record::provenance;
use crate::error::{Error, Result};
use crate::io::atomic;
use crate::lab::table::node;
use crate::phase::Family;
use crate::spread::wide_angle::layout::Layout;
use crate::spread::wide_angle::table::Table;
use rayon::prelude::*;
use serde::Serialize;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Nodes between two writes: work for any number of cores.
const AT_ONCE: usize = 16;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Phase function; hg: Henyey and Greenstein's
    #[arg(long, value_enum, value_name = "NAME", default_value = "gaussian")]
    phase: Family,
    /// Paths traced for each node; fewer where little light is scattered twice, up to eight times as many where absorption takes
    /// most of them
    #[arg(long, value_name = "N", default_value_t = 200_000, value_parser = clap::value_parser!(u64).range(1..1 << 32))]
    paths: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Table to write; until it is complete, FILE.part
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print the numbers as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

/// What was made.
#[derive(Debug, Serialize)]
struct Made {
    nodes: usize,
    bytes: usize,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    atomic::check_writable(&arguments.out)?;
    let mut part = arguments.out.clone().into_os_string();
    part.push(".part");
    let part = PathBuf::from(part);
    let layout = Layout::of(arguments.phase);
    // The first table was of the Gaussian, and does not name it.
    let of = if arguments.phase == Family::Gaussian { "" } else { "hg; " };
    let fixed = format!("{of}seed {}; paths {};", arguments.seed, arguments.paths);
    let line = Table::line(&format!("{fixed} {}", provenance()[0].1));
    check_part(&part)?;
    let mut bytes = resumed(&part, &line, layout).unwrap_or_else(|| line.clone().into_bytes());
    let unwritten = |source| Error::Write { path: part.clone(), source };
    atomic::write(&part, &bytes)?;
    let mut file = fs::OpenOptions::new().append(true).open(&part).map_err(unwritten)?;

    let places = layout.places();
    let done = (bytes.len() - line.len()) / (4 * layout.numbers());
    let progress = Progress::new("tracing", "nodes", places.len() as u64);
    progress.add(done as u64);
    for start in (done..places.len()).step_by(AT_ONCE) {
        let numbers = (start..places.len().min(start + AT_ONCE))
            .into_par_iter()
            .map(|i| {
                let seed = arguments.seed.wrapping_mul(places.len() as u64).wrapping_add(i as u64);
                let numbers = node(layout, &places[i], arguments.paths, seed)?;
                progress.add(1);
                Ok(numbers)
            })
            .collect::<Result<Vec<_>>>()?;
        let new: Vec<u8> = numbers.iter().flatten().flat_map(|n| n.to_le_bytes()).collect();
        file.write_all(&new).map_err(unwritten)?;
        bytes.extend(new);
    }
    atomic::write(&arguments.out, &bytes)?;
    atomic::remove(&part)?;
    drop(progress);
    let made = Made { nodes: places.len(), bytes: bytes.len() };
    let text = format!("{}: {} nodes, {} bytes\n", arguments.out.display(), made.nodes, made.bytes);
    answer(arguments.json, &made, &text)?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses to overwrite what is there as `part` and is no part of a table.
fn check_part(part: &Path) -> Result<()> {
    atomic::check_writable(part)?;
    let is_ours = |bytes: Vec<u8>| bytes.is_empty() || Table::split(&bytes).is_ok();
    if fs::read(part).is_ok_and(|bytes| !is_ours(bytes)) {
        let why = "is no part of a table, and would be lost; move it away, or choose another --out";
        return Err(Error::Protected { path: part.to_path_buf(), why: why.into() });
    }
    Ok(())
}

/// The complete nodes of a table begun with the same line.
fn resumed(part: &Path, line: &str, layout: &Layout) -> Option<Vec<u8>> {
    let mut bytes = fs::read(part).ok()?;
    let (found, numbers) = Table::split(&bytes).ok()?;
    let whole = line.len() + numbers.len() / layout.numbers() * (4 * layout.numbers());
    if found != line {
        return None;
    }
    bytes.truncate(whole);
    Some(bytes)
}
