//! `[fit]`: starting values, fixed values and bounds of each channel.

use super::FitOptions;
use super::format::{FitSection, Numbers, Pairs, PerParameter};
use super::medium::{channel_value, three_for_one};
use super::source::Source;
use crate::error::Result;

/// The parameters in their order, and whether each must be above 0 (its logarithm is fitted) or may be 0.
const PARAMETERS: [(&str, bool); 3] = [("sigma_s", true), ("sigma_a", false), ("b", true)];

/// The options of each of `channels` channels.
pub(super) fn read_fit(source: &Source, section: &FitSection, channels: usize) -> Result<Vec<FitOptions>> {
    (0..channels).map(|i| channel_options(source, section, i, channels)).collect()
}

fn channel_options(source: &Source, section: &FitSection, i: usize, channels: usize) -> Result<FitOptions> {
    let mut options = FitOptions::default();
    let (start, fixed) = (in_order(&section.start), in_order(&section.fixed));
    let bounds = in_order(&section.bounds);
    for (p, (name, above_zero)) in PARAMETERS.into_iter().enumerate() {
        let check = |key: &str, v: f64| {
            if above_zero { source.positive(key, v) } else { source.non_negative(key, v) }
        };
        let value = |table: &str, numbers: Option<Numbers>| {
            let key = format!("[fit] {table} {name}");
            channel_value(source, &key, numbers, i, channels)?.map(|v| check(&key, v)).transpose()
        };
        options.start[p] = value("start", start[p])?;
        // A parameter that is held may be 0 even if its logarithm would be fitted; B has no kernel at 0.
        let key = format!("[fit] fixed {name}");
        let held = channel_value(source, &key, fixed[p], i, channels)?;
        let allowed = |v| if name == "b" { source.positive(&key, v) } else { source.non_negative(&key, v) };
        options.fixed[p] = held.map(allowed).transpose()?;

        let key = format!("[fit] bounds {name}");
        options.bounds[p] = match bounds[p] {
            None => None,
            Some(Pairs::One(pair)) => Some(pair),
            Some(Pairs::Three(pairs)) if channels == 3 => Some(pairs[i]),
            Some(Pairs::Three(_)) => return Err(three_for_one(source, &key)),
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

fn in_order<T: Copy>(table: &PerParameter<T>) -> [Option<T>; 3] {
    [table.sigma_s, table.sigma_a, table.b]
}
