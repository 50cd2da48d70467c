//! A linear or logarithmic axis: where its ticks are and how their numbers are written.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use std::ops::Range;

/// Largest number of labels on an axis.
const MAX_TICKS: usize = 9;

/// From a value to its place on an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    pub log: bool,
}

impl Scale {
    /// An axis that shows all `values`, with a little room around them. A logarithmic one leaves out what is not
    /// positive, and shows at most `decades` below the largest value.
    pub fn around(values: impl Iterator<Item = f64>, log: bool, decades: f64) -> Self {
        let shown = values.filter(|v| v.is_finite() && (!log || *v > 0.0));
        let (low, high) = shown.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        if low > high {
            return Self { low: if log { 0.1 } else { 0.0 }, high: 1.0, log };
        }
        if log {
            let low = low.max(high * 10f64.powf(-decades));
            // An eighth of a decade at either end keeps the outermost points off the frame.
            return Self { low: low * 0.75, high: high / 0.75, log };
        }
        let room = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
        // Data that begin at 0 keep it as the edge.
        let bottom = if low == 0.0 { 0.0 } else { low - room };
        Self { low: bottom, high: high + room, log }
    }

    /// Where `value` lies: 0 at the low end, 1 at the high end.
    pub fn share(&self, value: f64) -> f64 {
        if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// The value at the share `t`.
    pub fn value(&self, t: f64) -> f64 {
        if self.log {
            self.low * (self.high / self.low).powf(t)
        } else {
            self.low + t * (self.high - self.low)
        }
    }

    /// Round values, at most `most` of them.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        if self.log {
            let decades = self.low.log10().ceil() as i32..=self.high.log10().floor() as i32;
            let count = decades.clone().count();
            if count >= 3 {
                let every = count.div_ceil(most);
                return decades.filter(|d| d.rem_euclid(every as i32) == 0).map(|d| 10f64.powi(d)).collect();
            }
            let first = self.low.log10().floor() as i32;
            let fine = (first..=first + 3).flat_map(|d| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(d)));
            let fine: Vec<f64> = fine.filter(|v| (self.low..=self.high).contains(v)).collect();
            if fine.len() >= 2 && fine.len() <= most {
                return fine;
            }
        }
        let step = round_step((self.high - self.low) / most as f64);
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }

    /// `value` as the axis writes it.
    pub fn label(&self, value: f64) -> String {
        if value == 0.0 {
            return "0".into();
        }
        let largest = self.low.abs().max(self.high.abs());
        let wide = self.log && self.high / self.low > 1e3;
        if wide || !(1e-2..1e5).contains(&largest) {
            return scientific(value);
        }
        // Enough decimals to distinguish neighbours at the finest step.
        let step = if self.log { value } else { round_step((self.high - self.low) / MAX_TICKS as f64) };
        let decimals = (-(step * 1.0001).log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{value:.decimals$}").replace('-', "−")
    }
}

/// The round number (1, 2 or 5 times a power of ten) at or above `step`.
pub(super) fn round_step(step: f64) -> f64 {
    let decade = 10f64.powf(step.log10().floor());
    let round = [1.0, 2.0, 5.0].into_iter().find(|m| m * decade >= step * 0.9999);
    round.unwrap_or(10.0) * decade
}

/// `2.5·10⁻³`, and `10⁻³` for a bare power of ten.
fn scientific(value: f64) -> String {
    let written = format!("{value:.1e}");
    let (mantissa, exponent) = written.split_once('e').unwrap_or((&written, "0"));
    let mantissa = mantissa.strip_suffix(".0").unwrap_or(mantissa).replace('-', "−");
    let digit = |c: char| {
        if c == '-' {
            '⁻'
        } else {
            ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][c as usize - 48]
        }
    };
    let power: String = exponent.chars().map(digit).collect();
    match (mantissa.as_str(), exponent) {
        (m, "0") => m.to_string(),
        ("1", _) => format!("10{power}"),
        (m, _) => format!("{m}·10{power}"),
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        limit.0 + (f64::from(limit.1 - limit.0) * self.share(*value)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        self.ticks(hint.max_num_points().clamp(2, MAX_TICKS))
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Scale {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, log: bool) -> Vec<String> {
        let scale = Scale { low, high, log };
        scale.ticks(6).into_iter().map(|v| scale.label(v)).collect()
    }

    #[test]
    fn ticks_are_round_and_labels_short() {
        assert_eq!(labels(0.0, 1.0, false), ["0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(-0.004, 0.004, false), ["−4·10⁻³", "−2·10⁻³", "0", "2·10⁻³", "4·10⁻³"]);
        assert_eq!(labels(0.0, 250.0, false), ["0", "50", "100", "150", "200", "250"]);
        assert_eq!(labels(1e-4, 2.0, true), ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]);
        assert_eq!(labels(0.3, 4.0, true), ["0.5", "1", "2"]);
    }

    #[test]
    fn a_scale_maps_there_and_back() {
        for log in [false, true] {
            let scale = Scale { low: 0.02, high: 5.0, log };
            assert!((scale.value(scale.share(0.7)) - 0.7).abs() < 1e-12);
            assert_eq!((scale.share(0.02), scale.share(5.0)), (0.0, 1.0));
        }
    }

    #[test]
    fn a_logarithmic_axis_leaves_out_what_it_cannot_show() {
        let scale = Scale::around([0.0, -1.0, 1e-30, 1.0, f64::NAN].into_iter(), true, 6.0);
        assert!(scale.low > 5e-7 && scale.high < 1.5, "{scale:?}");
        let empty = Scale::around([f64::NAN].into_iter(), false, 6.0);
        assert!(empty.high > empty.low);
    }
}
