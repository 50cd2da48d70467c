//! The part of the report on what is determined where not everything is, and on what would free the rest.

use super::{FitReport, significant};
use crate::fit::{Advice, ChannelFit};
use serde_json::{Map, Value, json};

impl FitReport {
    /// Adds the combinations that `channel` determines.
    pub(super) fn add_determined(&mut self, channel: &str, fit: &ChannelFit) {
        for combination in &fit.determined {
            let mut entry = json!(combination);
            entry["channel"] = json!(channel);
            self.determined.push(entry);
        }
    }

    /// Adds the `advice` for `channel`, one of `channels`.
    pub(crate) fn add_advice(&mut self, channel: &str, channels: usize, fit: &ChannelFit, advice: &[Advice]) {
        let suffix = if channels == 1 { String::new() } else { format!(".{channel}") };
        for one in advice {
            let names = fit.parameters.names().into_iter().map(String::from);
            let errors: Map<String, Value> = names.zip(one.std_errors.iter().map(|e| json!(e))).collect();
            self.advice.push(json!({
                "channel": channel, "measurement": one.measurement, "frees": one.frees, "std_errors": errors,
                "message": one.line(&fit.parameters, &suffix),
            }));
        }
    }

    /// What is determined, and what would free the rest, as lines for people.
    pub(super) fn identified(&self) -> Vec<String> {
        let number = |v: &Value| v.as_f64().map_or_else(|| "-".to_string(), significant);
        let combination = |c: &Value| {
            let name = c["combination"].as_str().unwrap_or_default();
            let percent = 100.0 * c["relative_error"].as_f64().unwrap_or(f64::NAN);
            format!(
                "determined: {name} = {} ± {} ({percent:.2} %)",
                number(&c["value"]),
                number(&c["std_error"])
            )
        };
        let advice = |a: &Value| format!("advice: {}", a["message"].as_str().unwrap_or_default());
        self.determined.iter().map(combination).chain(self.advice.iter().map(advice)).collect()
    }
}
