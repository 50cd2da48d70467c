//! `[medium]`: numbers for all channels or for each, completed from the command line.

use super::format::{MediumSection, Numbers, TruthFile, parse};
use super::source::Source;
use super::{PartialMedium, Scene};
use crate::error::{Result, in_range};
use crate::medium::Medium;
use crate::phase::{Family, b_of_spread_angle};
use std::path::Path;

impl Scene {
    /// The medium of each object channel: `[medium]`, and over it what `overrides` gives, on the command line, for all
    /// channels.
    ///
    /// # Errors
    /// [`Error::Scene`](crate::Error::Scene) that names a missing value;
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) for an override, or for a value that no medium has.
    pub fn media(&self, overrides: PartialMedium) -> Result<Vec<Medium>> {
        let PartialMedium { sigma_s, sigma_a, family, phase_parameter } = overrides;
        let coefficient = |v: f64| v.is_finite() && v >= 0.0;
        for (name, value) in [("--sigma-s", sigma_s), ("--sigma-a", sigma_a)] {
            if let Some(v) = value {
                in_range(name, v, coefficient(v), "finite and at least 0 (1/length)")?;
            }
        }
        if let Some(v) = phase_parameter {
            in_range(&format!("--{}", family.parameter_name()), v, family.allows(v), family.allowed())?;
        }
        let source = Source { path: &self.path, text: String::new() };
        let merge = |medium: &PartialMedium| {
            complete(
                &source,
                PartialMedium {
                    sigma_s: sigma_s.or(medium.sigma_s),
                    sigma_a: sigma_a.or(medium.sigma_a),
                    family: if phase_parameter.is_some() { family } else { medium.family },
                    phase_parameter: phase_parameter.or(medium.phase_parameter),
                },
            )
        };
        self.medium.iter().map(merge).collect()
    }
}

/// The medium that a `truth.toml` says its images were made with: one, or three for R, G, B. Other tables of the
/// file are ignored.
///
/// # Errors
/// [`Error::Read`](crate::Error::Read) or [`Error::Scene`](crate::Error::Scene), naming file and key;
/// [`Error::OutOfRange`](crate::Error::OutOfRange) for a value that no medium has.
pub fn read_truth(path: &Path) -> Result<Vec<Medium>> {
    let source = Source::read(path)?;
    let section = parse::<TruthFile>(&source)?.medium;
    let all = [section.sigma_s, section.sigma_a, section.b, section.spread_angle_deg, section.g];
    let channels = if all.iter().any(|n| matches!(n, Some(Numbers::Three(_)))) { 3 } else { 1 };
    let media = read_medium(&source, Some(&section), channels)?;
    media.into_iter().map(|medium| complete(&source, medium)).collect()
}

/// The given values of each of `channels` channels.
pub(super) fn read_medium(
    source: &Source,
    section: Option<&MediumSection>,
    channels: usize,
) -> Result<Vec<PartialMedium>> {
    let mut media = vec![PartialMedium::default(); channels];
    let Some(section) = section else { return Ok(media) };
    let family = family_of(source, section)?;
    for (index, medium) in media.iter_mut().enumerate() {
        let of = ChannelOf { source, index, count: channels };
        let value = |key: &str, numbers: Option<Numbers>| of.value(key, numbers);
        let coefficient = |key: &str, numbers: Option<Numbers>| {
            value(key, numbers)?.map(|v| source.non_negative(key, v)).transpose()
        };
        medium.sigma_s = coefficient("[medium] sigma_s", section.sigma_s)?;
        medium.sigma_a = coefficient("[medium] sigma_a", section.sigma_a)?;
        medium.family = family;
        let key = format!("[medium] {}", family.parameter_name());
        let parameter = value(&key, section.b.or(section.g))?;
        let parameter =
            parameter.map(|v| source.in_range(&key, v, family.allows(v), family.allowed())).transpose()?;
        let key = "[medium] spread_angle_deg";
        let angle = value(key, section.spread_angle_deg)?.map(|v| source.positive(key, v)).transpose()?;
        medium.phase_parameter = parameter.or(angle.map(|degrees| b_of_spread_angle(degrees.to_radians())));
    }
    Ok(media)
}

/// The family of the phase function that `[medium]` names or whose parameter it gives, once.
fn family_of(source: &Source, section: &MediumSection) -> Result<Family> {
    let keys = [
        ("b", section.b, Family::Gaussian),
        ("spread_angle_deg", section.spread_angle_deg, Family::Gaussian),
        ("g", section.g, Family::HenyeyGreenstein),
    ];
    let given: Vec<(&str, Family)> =
        keys.into_iter().filter(|(_, v, _)| v.is_some()).map(|(key, _, of)| (key, of)).collect();
    if let [(one, of), (other, of_other), ..] = given[..] {
        let why = if of == of_other {
            "they say the same, leave one"
        } else {
            "they belong to different phase functions, leave one"
        };
        return Err(source.error(format!("[medium] {one} and {other} are both given: {why}")));
    }
    let named = family(source, "[medium] phase", section.phase.as_deref())?;
    match (named, given.first()) {
        (Some(named), Some((key, of))) if named != *of => {
            let (name, right) = (named.name(), named.parameter_name());
            Err(source.error(format!("[medium] {key} is given, but phase = \"{name}\" has {right}")))
        }
        (named, given) => Ok(named.or(given.map(|(_, of)| *of)).unwrap_or_default()),
    }
}

/// The family called `name`, if there is a name.
pub(super) fn family(source: &Source, key: &str, name: Option<&str>) -> Result<Option<Family>> {
    let wrong = |error: crate::Error| source.error(format!("{key}: {error}"));
    name.map(|name| name.parse().map_err(wrong)).transpose()
}

/// One of the object's channels, whose values are read.
#[derive(Clone, Copy)]
pub(super) struct ChannelOf<'a> {
    pub source: &'a Source<'a>,
    /// Which of them.
    pub index: usize,
    /// How many there are.
    pub count: usize,
}

impl ChannelOf<'_> {
    /// The value of `numbers` for this channel.
    pub fn value(&self, key: &str, numbers: Option<Numbers>) -> Result<Option<f64>> {
        match numbers {
            None => Ok(None),
            Some(Numbers::One(v)) => Ok(Some(v)),
            Some(Numbers::Three(v)) => self.of_three(key, v).map(Some),
        }
    }

    /// Its own of three values.
    pub fn of_three<T: Copy>(&self, key: &str, values: [T; 3]) -> Result<T> {
        if self.count == 3 {
            Ok(values[self.index])
        } else {
            let message = format!("{key} has three values, but the object image has one channel");
            Err(self.source.error(message))
        }
    }
}

fn complete(source: &Source, medium: PartialMedium) -> Result<Medium> {
    let missing =
        |key: &str, option: &str| source.error(format!("[medium] {key} is missing (or give {option})"));
    let family = medium.family;
    let instead = match family {
        Family::Gaussian => "spread_angle_deg or g, --b, --spread-angle-deg or --g",
        Family::HenyeyGreenstein => "--g",
    };
    let sigma_s = medium.sigma_s.ok_or_else(|| missing("sigma_s", "--sigma-s"))?;
    let sigma_a = medium.sigma_a.ok_or_else(|| missing("sigma_a", "--sigma-a"))?;
    let parameter = medium.phase_parameter.ok_or_else(|| missing(family.parameter_name(), instead))?;
    Medium::new(sigma_s, sigma_a, family.phase(parameter)?)
}
