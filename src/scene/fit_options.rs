//! `[fit]`: phase function, starting values, fixed values and bounds of each channel.

use super::format::{FitSection, Numbers, Pairs, PerParameter};
use super::medium::{ChannelOf, family};
use super::source::Source;
use super::{FitOptions, ParameterOptions};
use crate::error::Result;
use crate::phase::Family;

/// The options of each of `channels` channels.
pub(super) fn read_fit(source: &Source, section: &FitSection, channels: usize) -> Result<Vec<FitOptions>> {
    let key = "[fit] phase";
    let family = family(source, key, section.phase.as_deref())?.unwrap_or_default();
    for (table, given) in [
        ("start", phase_parameters(&section.start)),
        ("fixed", phase_parameters(&section.fixed)),
        ("bounds", phase_parameters(&section.bounds)),
    ] {
        for other in Family::ALL.into_iter().filter(|f| *f != family) {
            if given.contains(&other.parameter_name()) {
                let (name, wrong, right) = (family.name(), other.parameter_name(), family.parameter_name());
                let message = format!("[fit] {table} {wrong} is given, but {key} = \"{name}\" has {right}");
                return Err(source.error(message));
            }
        }
    }
    let of = |index: usize| ChannelOf { source, index, count: channels };
    (0..channels).map(|index| channel_options(of(index), section, family)).collect()
}

fn channel_options(channel: ChannelOf, section: &FitSection, family: Family) -> Result<FitOptions> {
    let FitSection { start, fixed, bounds, .. } = section;
    let read = |name: &str, of: Of, given: Given| Reader { channel, family, name, of }.options(given);
    let sigma_s = Given { start: start.sigma_s, fixed: fixed.sigma_s, bounds: bounds.sigma_s };
    let sigma_a = Given { start: start.sigma_a, fixed: fixed.sigma_a, bounds: bounds.sigma_a };
    // Whichever of B and g does not belong to the family has been refused.
    let phase =
        Given { start: start.b.or(start.g), fixed: fixed.b.or(fixed.g), bounds: bounds.b.or(bounds.g) };
    Ok(FitOptions {
        family,
        sigma_s: read("sigma_s", Of::SigmaS, sigma_s)?,
        sigma_a: read("sigma_a", Of::SigmaA, sigma_a)?,
        phase: read(family.parameter_name(), Of::Phase, phase)?,
    })
}

/// Which parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    SigmaS,
    SigmaA,
    Phase,
}

/// What the file gives of one parameter.
struct Given {
    start: Option<Numbers>,
    fixed: Option<Numbers>,
    bounds: Option<Pairs>,
}

/// Reads the options of one parameter of one channel.
struct Reader<'a> {
    channel: ChannelOf<'a>,
    family: Family,
    name: &'a str,
    of: Of,
}

impl Reader<'_> {
    fn options(&self, Given { start, fixed, bounds }: Given) -> Result<ParameterOptions> {
        let key = self.key("start");
        let start = self.value("start", start)?.map(|v| self.check(&key, v)).transpose()?;
        // A fixed parameter may be 0 even if its logarithm would be fitted, except the width of a phase function.
        let key = self.key("fixed");
        let allowed = |v| match self.of {
            Of::Phase => self.check(&key, v),
            Of::SigmaS | Of::SigmaA => self.channel.source.non_negative(&key, v),
        };
        let fixed = self.value("fixed", fixed)?.map(allowed).transpose()?;
        let bounds = self.bounds(bounds)?;
        let outside = |v: &f64| bounds.is_some_and(|[low, high]| !(low..=high).contains(v));
        if let Some(v) = start.filter(outside).filter(|_| fixed.is_none()) {
            let message = format!("[fit] start {} = {v}: must lie within its bounds", self.name);
            return Err(self.channel.source.error(message));
        }
        Ok(ParameterOptions { start, fixed, bounds })
    }

    fn bounds(&self, bounds: Option<Pairs>) -> Result<Option<[f64; 2]>> {
        let key = self.key("bounds");
        let [low, high] = match bounds {
            None => return Ok(None),
            Some(Pairs::One(pair)) => pair,
            Some(Pairs::Three(pairs)) => self.channel.of_three(&key, pairs)?,
        };
        self.check(&key, low)?;
        self.check(&key, high)?;
        if low >= high {
            let message = format!("{key} = [{low}, {high}]: the first must be below the second");
            return Err(self.channel.source.error(message));
        }
        Ok(Some([low, high]))
    }

    fn key(&self, table: &str) -> String {
        format!("[fit] {table} {}", self.name)
    }

    fn value(&self, table: &str, numbers: Option<Numbers>) -> Result<Option<f64>> {
        self.channel.value(&self.key(table), numbers)
    }

    /// `value` if a fit may move the parameter there: the logarithm of sigma_s is fitted, sigma_a may be 0.
    fn check(&self, key: &str, value: f64) -> Result<f64> {
        match self.of {
            Of::SigmaS => self.channel.source.positive(key, value),
            Of::SigmaA => self.channel.source.non_negative(key, value),
            Of::Phase => {
                self.channel.source.in_range(key, value, self.family.allows(value), self.family.allowed())
            }
        }
    }
}

/// The keys of `table` that are parameters of a phase function.
fn phase_parameters<T>(table: &PerParameter<T>) -> Vec<&'static str> {
    let given = |family: &Family| match family {
        Family::Gaussian => table.b.is_some(),
        Family::HenyeyGreenstein => table.g.is_some(),
    };
    Family::ALL.into_iter().filter(given).map(Family::parameter_name).collect()
}
