//! `narrowbeam kernel`: the spread kernels of a medium as tables and pictures, beside traced ones if wanted.

mod charts;
mod curves;
mod numbers;
mod summary;
mod tables;

use super::console::{answer, warn};
use super::errors::Usage;
use super::options::{non_negative, positive};
use super::progress::Progress;
use crate::error::{Result, in_range};
use crate::io::atomic;
use crate::medium::Medium;
use crate::phase::{Family, Phase, PhaseFunction, b_of_spread_angle};
use crate::spread::Model;
use crate::trace::{RadialConfig, RadialProfile, trace_radial};
use curves::{Curve, Grid};
use numbers::Summary;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// Scattering coefficient, 1/length
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = non_negative)]
    sigma_s: f64,
    /// Absorption coefficient, 1/length
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = non_negative)]
    sigma_a: f64,
    #[command(flatten)]
    width: Width,
    /// Path length z in the medium, from its surface to the object, length
    #[arg(long, value_name = "Z", allow_negative_numbers = true, value_parser = positive)]
    depth: f64,
    /// Model to tabulate, may be given several times; all that have a kernel if absent
    #[arg(long = "model", value_enum, value_name = "NAME")]
    models: Vec<Model>,
    /// Photons to trace for comparison
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    photons: u64,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    /// Directory to write kernel.csv, mtf.csv and their pictures to; made if necessary
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print the numbers as JSON, alone on stdout
    #[arg(long)]
    json: bool,
}

/// The phase function, by exactly one of its parameters.
#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct Width {
    /// Width B of the Gaussian phase function, rad²
    #[arg(long, value_name = "X", allow_negative_numbers = true, value_parser = positive)]
    b: Option<f64>,
    /// The same as a spread angle sqrt(4B), degrees
    #[arg(long, value_name = "D", allow_negative_numbers = true, value_parser = positive)]
    spread_angle_deg: Option<f64>,
    /// Mean cosine g of Henyey and Greenstein's phase function, in place of the Gaussian
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    g: Option<f64>,
}

impl Width {
    /// The phase function; clap ensures that exactly one of the three is given.
    fn phase(&self) -> anyhow::Result<Phase> {
        let degrees = || self.spread_angle_deg.unwrap_or_default();
        let b = || self.b.unwrap_or_else(|| b_of_spread_angle(degrees().to_radians()));
        match self.g {
            Some(g) => Family::HenyeyGreenstein.phase(g).map_err(|e| Usage(format!("--{e}")).into()),
            None => Ok(Family::Gaussian.phase(b())?),
        }
    }
}

/// The medium and depth whose kernels are shown.
#[derive(Debug, Clone, Copy)]
struct Setting {
    medium: Medium,
    z: f64,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<ExitCode> {
    let setting = Setting {
        medium: Medium::new(arguments.sigma_s, arguments.sigma_a, arguments.width.phase()?)?,
        z: in_range("--depth", arguments.depth, arguments.depth > 0.0, "above 0 (length)")?,
    };
    let width = 2.0 * setting.z * setting.medium.phase().planar_width();
    in_range(
        "--depth times twice the width of the phase function",
        width,
        (1e-9..1e9).contains(&width),
        "between 1e-9 and 1e9 (length)",
    )?;
    let any = arguments.models.is_empty();
    let mut kernels = Vec::new();
    for model in Model::ALL.into_iter().filter(|m| any || arguments.models.contains(m)) {
        match model.kernel(&setting.medium, setting.z) {
            Err(end) if any && end.is_about_model() => warn(&format!("{model} is left out: {end}")),
            kernel => kernels.push((model, kernel?)),
        }
    }
    let grid = Grid::new(&setting);
    let mut curves = kernels
        .iter()
        .map(|(m, kernel)| Curve::of_kernel(*m, &**kernel, &grid))
        .collect::<Result<Vec<_>>>()?;
    let _folder = atomic::create_dir(&arguments.out)?;
    atomic::check_writable(&arguments.out.join(tables::KERNEL))?;

    let traced = traced(arguments, &setting, &grid)?;
    curves.extend(traced.iter().map(|profile| Curve::of_profile(profile, &grid)));
    tables::write(&arguments.out, &grid, &curves)?;
    charts::write(&arguments.out, &setting, &grid, &curves)?;
    let summary = Summary::new(&setting, &kernels, traced.as_ref());
    answer(arguments.json, &summary, &summary::text(&setting, &kernels, traced.as_ref()))?;
    Ok(ExitCode::SUCCESS)
}

/// The traced kernel, if photons were asked for.
fn traced(arguments: &Arguments, setting: &Setting, grid: &Grid) -> Result<Option<RadialProfile>> {
    if arguments.photons == 0 {
        return Ok(None);
    }
    let config = RadialConfig {
        medium: setting.medium,
        depths: vec![setting.z],
        edges: grid.edges(),
        paths: arguments.photons,
        seed: arguments.seed,
    };
    let progress = Progress::new("tracing", "photons", arguments.photons);
    Ok(trace_radial(&config, &|done| progress.add(done))?.pop())
}
