//! Options that several commands share.

use super::backend::Wanted;
use crate::error::Result;
use crate::filter::Filter;
use crate::phase::b_of_spread_angle;
use crate::spread::Model;
use clap::Args;
use std::path::{Path, PathBuf};

/// The medium on the command line, in place of the scene's `[medium]`.
#[derive(Debug, Args)]
pub(super) struct MediumOptions {
    /// Scattering coefficient, 1/length
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub sigma_s: Option<f64>,
    /// Absorption coefficient, 1/length
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub sigma_a: Option<f64>,
    /// Width B of the Gaussian phase function, rad²
    #[arg(long, value_name = "X", conflicts_with = "spread_angle_deg", allow_negative_numbers = true)]
    pub b: Option<f64>,
    /// The same as a spread angle sqrt(4B), degrees
    #[arg(long, value_name = "D", allow_negative_numbers = true, value_parser = positive)]
    pub spread_angle_deg: Option<f64>,
}

impl MediumOptions {
    /// sigma_s, sigma_a, B where given.
    pub(super) fn values(&self) -> [Option<f64>; 3] {
        let b = self.b.or(self.spread_angle_deg.map(|d| b_of_spread_angle(d.to_radians())));
        [self.sigma_s, self.sigma_a, b]
    }
}

/// How a scene is rendered.
#[derive(Debug, Args)]
pub(super) struct RenderOptions {
    /// Spread model: beer-lambert, single-scatter, gaussian, narrow-beam-printed, narrow-beam, small-angle or auto
    #[arg(long, default_value = "auto", value_parser = parse_model)]
    pub model: Model,
    /// Filter for depth maps: eq29, composite, or auto: composite where the depth map has edges or slopes
    #[arg(long, default_value = "auto")]
    pub filter: Filter,
    /// Where to compute: cpu, gpu (a graphics adapter, be it a software one), or auto: a real one if it pays off
    #[arg(long, default_value = "auto")]
    pub backend: Wanted,
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> std::result::Result<f64, String> {
    number(text, |v| v > 0.0, "must be finite and above 0")
}

/// A finite number of at least 0.
pub(super) fn non_negative(text: &str) -> std::result::Result<f64, String> {
    number(text, |v| v >= 0.0, "must be finite and at least 0")
}

fn number(text: &str, ok: impl Fn(f64) -> bool, allowed: &str) -> std::result::Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "is no number".to_string())?;
    if value.is_finite() && ok(value) { Ok(value) } else { Err(allowed.into()) }
}

/// A model's name; `auto` is `small-angle`.
pub(super) fn parse_model(name: &str) -> Result<Model> {
    if name == "auto" { Ok(Model::SmallAngle) } else { name.parse() }
}

/// A path to an EXR image or a PNG picture.
pub(super) fn exr_or_png(path: PathBuf) -> std::result::Result<PathBuf, &'static str> {
    if has_extension(&path, "exr") || has_extension(&path, "png") {
        Ok(path)
    } else {
        Err("must end in .exr or .png")
    }
}

/// Whether `path` ends in `extension`, in any case.
pub(super) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Software and command line, for the files that a command writes.
pub(super) fn provenance() -> Vec<(String, String)> {
    let program = std::iter::once("narrowbeam".to_string());
    let command = program
        .chain(std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned()))
        .collect::<Vec<_>>()
        .join(" ");
    vec![
        ("software".into(), concat!("narrowbeam ", env!("CARGO_PKG_VERSION")).into()),
        ("command".into(), command),
    ]
}
