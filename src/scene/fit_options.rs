//! `[fit]`: phase function, starting values, fixed values and bounds of each channel.

use super::FitOptions;
use super::format::{FitSection, Numbers, Pairs, PerParameter};
use super::medium::{ChannelOf, family};
use super::source::Source;
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
    let source = channel.source;
    let mut options = FitOptions { family, ..FitOptions::default() };
    let (start, fixed) = (in_order(&section.start), in_order(&section.fixed));
    let bounds = in_order(&section.bounds);
    for (p, name) in ["sigma_s", "sigma_a", family.parameter_name()].into_iter().enumerate() {
        // The logarithm of sigma_s is fitted, sigma_a may be 0.
        let check = |key: &str, v: f64| match p {
            0 => source.positive(key, v),
            1 => source.non_negative(key, v),
            _ => source.in_range(key, v, family.allows(v), family.allowed()),
        };
        let value = |table: &str, numbers: Option<Numbers>| {
            let key = format!("[fit] {table} {name}");
            channel.value(&key, numbers)?.map(|v| check(&key, v)).transpose()
        };
        options.start[p] = value("start", start[p])?;
        // A parameter that is held may be 0 even if its logarithm would be fitted; a phase function has no width 0.
        let key = format!("[fit] fixed {name}");
        let held = channel.value(&key, fixed[p])?;
        let allowed = |v| if p == 2 { check(&key, v) } else { source.non_negative(&key, v) };
        options.fixed[p] = held.map(allowed).transpose()?;

        let key = format!("[fit] bounds {name}");
        options.bounds[p] = match bounds[p] {
            None => None,
            Some(Pairs::One(pair)) => Some(pair),
            Some(Pairs::Three(pairs)) => Some(channel.of_three(&key, pairs)?),
        };
        if let Some([low, high]) = options.bounds[p] {
            check(&key, low)?;
            check(&key, high)?;
            if low >= high {
                return Err(
                    source.error(format!("{key} = [{low}, {high}]: the first must be below the second"))
                );
            }
            let outside = |v: &f64| !(low..=high).contains(v);
            if let Some(v) = options.start[p].filter(outside).filter(|_| options.fixed[p].is_none()) {
                return Err(source.error(format!("[fit] start {name} = {v}: must lie within its bounds")));
            }
        }
    }
    Ok(options)
}

/// The keys of `table` that are parameters of a phase function.
fn phase_parameters<T>(table: &PerParameter<T>) -> Vec<&'static str> {
    let given = |family: &Family| match family {
        Family::Gaussian => table.b.is_some(),
        Family::HenyeyGreenstein => table.g.is_some(),
    };
    Family::ALL.into_iter().filter(given).map(Family::parameter_name).collect()
}

/// sigma_s, sigma_a and whichever phase-function parameter is given: the other is refused before.
fn in_order<T: Copy>(table: &PerParameter<T>) -> [Option<T>; 3] {
    [table.sigma_s, table.sigma_a, table.b.or(table.g)]
}
