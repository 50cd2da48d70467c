//! `narrowbeam chart`: speed against accuracy, of renders and of fits.

mod pictures;
mod points;
mod tables;

use super::aligned;
use super::console::{answer, note, without_loader_noise};
use super::outputs;
use super::progress::Progress;
use crate::error::Error;
use crate::filter::Backend;
use crate::gpu::Gpu;
use crate::io::atomic;
use crate::lab::study::chart::{Charted, Dataset, Effort, Step, read_trajectory};
use anyhow::Result;
use points::Clock;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Folders with scene.toml, its images, and truth.toml, the medium that made them
    #[arg(value_name = "DATASET", default_values = DATASETS)]
    datasets: Vec<PathBuf>,
    /// Directory for renders.csv, fits.csv and peer.csv, and pictures of them
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Directory with trajectories of the peer, NAME.csv for a folder NAME, as scripts/peer_mitsuba.py writes them; docs/peer if
    /// that is there
    #[arg(long, value_name = "DIR")]
    peer: Option<PathBuf>,
    /// Which time is charted; the tables have both
    #[arg(long, value_enum, default_value_t = Clock::Wall)]
    clock: Clock,
    /// Fewer runs, coarser traced images: a look in seconds
    #[arg(long)]
    quick: bool,
    /// Print the numbers as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

/// Planes and depth maps, narrow and wide: the datasets by default.
const DATASETS: [&str; 6] = [
    "datasets/mitsuba-checker",
    "datasets/mitsuba-natural",
    "datasets/mitsuba-tilt",
    "datasets/mitsuba-planes",
    "datasets/wide-30",
    "datasets/wide-30-thick",
];
/// Where trajectories are looked for by default.
const PEER: &str = "docs/peer";

pub(super) fn run(arguments: &Arguments) -> Result<ExitCode> {
    let sets =
        arguments.datasets.iter().map(|folder| Dataset::read(folder)).collect::<crate::Result<Vec<_>>>()?;
    let peer = arguments.peer.as_deref();
    let peers = sets.iter().map(|set| trajectory(peer, set)).collect::<crate::Result<Vec<_>>>()?;
    let of = |(set, folder): (&Dataset, &PathBuf)| {
        let others = [folder.join("truth.toml"), trajectory_path(peer, set)];
        set.scene().files.iter().cloned().chain(others).collect::<Vec<_>>()
    };
    let inputs: Vec<PathBuf> = sets.iter().zip(&arguments.datasets).flat_map(of).collect();
    let _folder = atomic::create_dir(&arguments.out)?;
    for name in tables::FILES.iter().chain(&pictures::FILES) {
        outputs::check(&arguments.out.join(name), &inputs)?;
    }
    let effort = if arguments.quick { Effort::quick() } else { Effort::full() };
    let gpu = without_loader_noise(Gpu::open);
    if let Err(error) = &gpu {
        note(&format!("on the CPU alone: {error}"));
    }
    let mut backends = vec![Backend::Cpu];
    backends.extend(gpu.as_ref().ok().map(Backend::Gpu));
    let total = sets.iter().map(|set| Charted::count(set, backends.len(), &effort)).sum::<usize>();
    let progress = Progress::new("charting", "renders and fits", total as u64);
    let tick = || progress.add(1);
    let of = |(set, peer): (Dataset, Vec<Step>)| Charted::new(set, peer, &backends, &effort, &tick);
    let charted: Vec<Charted> = sets.into_iter().zip(peers).map(of).collect();
    drop(progress);
    tables::write(&arguments.out, &charted, arguments.clock)?;
    let adapter = gpu.as_ref().ok().map(|gpu| gpu.adapter().to_string());
    pictures::write(&arguments.out, &charted, arguments.clock, adapter.as_deref())?;
    let fronts = tables::fronts(&charted, arguments.clock);
    answer(arguments.json, &fronts, &aligned(&tables::rows(&fronts, arguments.clock)))?;
    Ok(ExitCode::SUCCESS)
}

/// The trajectory of the peer on `set`; empty if there is none. A directory that is `named` must exist.
fn trajectory(named: Option<&Path>, set: &Dataset) -> crate::Result<Vec<Step>> {
    if let Some(dir) = named.filter(|dir| !dir.is_dir()) {
        return Err(Error::Read { path: dir.to_path_buf(), reason: "--peer: is no directory".into() });
    }
    let path = trajectory_path(named, set);
    if path.exists() { read_trajectory(&path, set) } else { Ok(Vec::new()) }
}

fn trajectory_path(named: Option<&Path>, set: &Dataset) -> PathBuf {
    named.unwrap_or(Path::new(PEER)).join(format!("{}.csv", set.name))
}
