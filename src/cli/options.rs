//! Options that several commands share.

use super::backend::Wanted;
use super::console::warn;
use super::errors::Usage;
use super::names::WantedModel;
use crate::filter::Filter;
use crate::forward::{MOST_PATHS, Tracing};
use crate::geometry::PathLengths;
use crate::io::picture::{OUTPUTS, is_output};
use crate::medium::Medium;
use crate::phase::PhaseFunction;
use crate::phase::{Family, b_of_spread_angle};
use crate::scene::{PartialMedium, Scene, medium_slip};
use crate::spread::{Model, SMALL_ANGLE_LIMIT};
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
    /// Mean cosine g of Henyey and Greenstein's phase function, in place of the Gaussian
    #[arg(long, value_name = "X", conflicts_with_all = ["b", "spread_angle_deg"], allow_negative_numbers = true)]
    pub g: Option<f64>,
}

impl MediumOptions {
    /// The values given.
    pub(super) fn values(&self) -> PartialMedium {
        let b = self.b.or(self.spread_angle_deg.map(|d| b_of_spread_angle(d.to_radians())));
        let family = if self.g.is_some() { Family::HenyeyGreenstein } else { Family::Gaussian };
        PartialMedium { sigma_s: self.sigma_s, sigma_a: self.sigma_a, family, phase_parameter: self.g.or(b) }
    }
}

/// How a scene is rendered.
#[derive(Debug, Args)]
pub(super) struct RenderOptions {
    /// Spread model; auto: the cheapest that the scene allows; traced (fit and render): paths traced for the scene, slow,
    /// valid in every medium
    #[arg(long, value_enum, default_value = "auto", value_name = "NAME")]
    pub model: WantedModel,
    /// Filter for depth maps; auto: composite where the depth map has edges or slopes
    #[arg(long, value_enum, default_value = "auto", value_name = "NAME")]
    pub filter: Filter,
    /// Where to compute; gpu: a graphics adapter, even if it is a software one; auto: a hardware one if it is worth it
    #[arg(long, value_enum, default_value = "auto", value_name = "NAME")]
    pub backend: Wanted,
}

/// The paths of the model `traced`.
#[derive(Debug, Args)]
pub(super) struct TracingOptions {
    /// Paths that --model traced traces for each scene and channel [default: 1048576 for a plane seen by parallel rays, else
    /// 16777216]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MOST_PATHS))]
    paths: Option<u64>,
    /// Seed of their random numbers, and of other noise that is drawn
    #[arg(long, default_value_t = 1, value_name = "S")]
    pub seed: u64,
}

impl TracingOptions {
    /// Paths and seed.
    pub(super) fn tracing(&self) -> Tracing {
        Tracing::new(self.paths, self.seed)
    }

    /// Refuses what contradicts the options of `rendering`.
    pub(super) fn check(&self, rendering: &RenderOptions) -> Result<(), Usage> {
        let traced = rendering.model == WantedModel::This(Model::Traced);
        let refuse = |why: &str| Err(Usage(why.into()));
        if traced && rendering.filter == Filter::Eq29 {
            return refuse(
                "--model traced includes the edges and slopes of the object; --filter eq29 ignores them",
            );
        }
        if !traced && self.paths.is_some() {
            return refuse("--paths goes with --model traced");
        }
        Ok(())
    }
}

/// Bytes: a number with or without a unit, of 1000 (kB, MB, …) or 1024 (KiB, MiB, …).
pub(super) fn size(text: &str) -> Result<u64, String> {
    let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let number = positive(&text[..text.len() - unit.len()])?;
    let lower = unit.trim().to_ascii_lowercase();
    let scale = match lower.trim_end_matches('b') {
        "" => 1,
        prefix => {
            let (letter, step) = prefix.strip_suffix('i').map_or((prefix, 1000_u64), |letter| (letter, 1024));
            let power = ["k", "m", "g", "t"].iter().position(|&known| known == letter);
            step.pow(power.ok_or("must be a number of bytes, such as 2GiB or 500MB")? as u32 + 1)
        }
    };
    let bytes = number * scale as f64;
    if bytes >= 1.0 { Ok(bytes as u64) } else { Err("must be at least one byte".into()) }
}

/// A finite number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    number(text, |v| v > 0.0, "must be finite and above 0")
}

/// A finite number of at least 0.
pub(super) fn non_negative(text: &str) -> Result<f64, String> {
    number(text, |v| v >= 0.0, "must be finite and at least 0")
}

fn number(text: &str, ok: impl Fn(f64) -> bool, allowed: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "is no number".to_string())?;
    if value.is_finite() && ok(value) { Ok(value) } else { Err(allowed.into()) }
}

impl WantedModel {
    /// The model to render `media` with over path lengths of median and longest `z`: by default `small-angle`, or
    /// `wide-angle` where `small-angle` is outside its range and `wide-angle` has kernels.
    pub(super) fn for_media(self, media: &[Medium], z: PathLengths) -> Model {
        if let WantedModel::This(model) = self {
            return model;
        }
        let wide = media.iter().any(|m| validity(m, z.median) > SMALL_ANGLE_LIMIT);
        let within = |m: &Medium| {
            Model::WideAngle.range(m.phase().family()).is_ok_and(|range| {
                m.tau(z.longest) <= range.tau
                    && m.sigma_a() * z.longest <= range.absorption
                    && (range.phase[0]..=range.phase[1]).contains(&m.phase().parameter())
            })
        };
        if wide && media.iter().all(within) { Model::WideAngle } else { Model::SmallAngle }
    }
}

/// tau times the [mean-square scattering angle](Family::mean_square_angle) over the path length `z`: how much the
/// light of a medium departs from small angles.
pub(super) fn validity(medium: &Medium, z: f64) -> f64 {
    medium.tau(z) * medium.phase().family().mean_square_angle(medium.phase().parameter())
}

/// A path to an EXR image.
pub(super) fn exr_only(path: PathBuf) -> Result<PathBuf, &'static str> {
    if has_extension(&path, "exr") { Ok(path) } else { Err("must end in .exr") }
}

/// A path to an EXR image or a PNG picture.
pub(super) fn exr_or_png(path: PathBuf) -> Result<PathBuf, &'static str> {
    if has_extension(&path, "exr") || has_extension(&path, "png") {
        Ok(path)
    } else {
        Err("must end in .exr or .png")
    }
}

/// A path to an image of a format that is written.
pub(super) fn output_image(path: PathBuf) -> Result<PathBuf, String> {
    if is_output(&path) { Ok(path) } else { Err(format!("must end in {OUTPUTS}")) }
}

/// Whether `path` ends in `extension`, in any case.
pub(super) fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// Says what is odd about a scene and its media, if anything is.
pub(super) fn say_slips(scene: &Scene, media: &[Medium]) {
    for slip in media.iter().find_map(medium_slip).into_iter().chain(scene.unit_slip()) {
        warn(&format!("warning (units): {slip}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        let bytes = ["5", "1.5kB", "2GiB", "2 gib", "3M", "1TB"].map(|text| size(text).unwrap());
        assert_eq!(bytes, [5, 1500, 2 << 30, 2 << 30, 3_000_000, 1_000_000_000_000]);
        assert!(["", "GB", "-1GB", "0", "5XB", "nan", "2 G B"].iter().all(|text| size(text).is_err()));
    }
}
