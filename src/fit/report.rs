//! The result of a fit as users read it: `fit.json`, and the table on the terminal.

mod derived;
mod gauge;
mod identified;
mod warnings;

use derived::derived;
pub use gauge::Gauge;
use warnings::warnings;

use super::ladder::Rung;
use super::uncertainty::{Status, Z95};
use super::{ChannelFit, Settings};
use crate::filter::{Backend, Filter};
use crate::phase::Family;
use crate::spread::Model;
use nalgebra::Vector3;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// Something that the user should know about an estimate.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// Short name for programs.
    pub code: &'static str,
    /// What it means and what can be done.
    pub message: String,
}

/// One parameter of one channel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ParameterReport {
    /// The estimate; the last value tried if undetermined; absent if the model does not have this parameter.
    pub value: Option<f64>,
    /// Standard error from the noise.
    pub std_error: Option<f64>,
    /// The same over the value.
    pub relative_error: Option<f64>,
    /// Error of the model itself at this scene, [`ModelError`](super::ModelError); `None` where it is not known.
    pub model_error: Option<f64>,
    /// Standard error by what is said of depths and gains.
    pub input_error: Option<f64>,
    /// 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Free, fixed or undetermined.
    pub status: Status,
    /// Where the fit began.
    pub start: Option<f64>,
}

/// Everything about a fit, over all its channels.
#[derive(Debug, Clone, Serialize)]
pub struct FitReport {
    /// Version of the program.
    pub version: &'static str,
    /// Spread model.
    pub model: &'static str,
    /// Family of the phase function.
    pub phase: &'static str,
    /// Filter for depth maps.
    pub filter: &'static str,
    /// What computed the renders.
    pub backend: Value,
    /// sigma_s, sigma_a, b or g; with a suffix `.R` and so on for colour.
    pub parameters: Map<String, Value>,
    /// Quantities that follow from them, with the same suffixes.
    pub derived: Map<String, Value>,
    /// Correlations of the parameters' errors, `sigma_s,sigma_a` and so on, with the same suffixes; null where one of the two
    /// is fixed or undetermined.
    pub correlations: Map<String, Value>,
    /// How the fit went, over all channels.
    pub fit: Value,
    /// Gain, veil, noise and misfit of every scene and channel.
    pub exposures: Vec<Value>,
    /// Starting values used.
    pub start: Map<String, Value>,
    /// The command line, if there was one.
    pub command: Option<String>,
    /// Combinations of the parameters that the data determine where they leave one open, or hold two only together.
    pub determined: Vec<Value>,
    /// Which measurement would free what is undetermined, the best first; empty if nothing is.
    pub advice: Vec<Value>,
    /// The models that were tried, cheapest first; empty if one was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ladder: Vec<Rung>,
    /// What the user should know.
    pub warnings: Vec<Warning>,
}

impl FitReport {
    /// Report of the fits of all `channels` (name and fit) that took `seconds`.
    pub fn new(channels: &[(String, ChannelFit)], settings: &Settings, filter: Filter, seconds: f64) -> Self {
        let mut report = Self {
            version: env!("CARGO_PKG_VERSION"),
            model: settings.model.name(),
            phase: channels.first().map_or(Family::default(), |(_, fit)| fit.parameters.family()).name(),
            filter: filter.name(),
            backend: backend(settings.backend),
            parameters: Map::new(),
            derived: Map::new(),
            correlations: Map::new(),
            fit: summary(channels, settings.tracing.seed, seconds),
            exposures: Vec::new(),
            start: Map::new(),
            command: None,
            determined: Vec::new(),
            advice: Vec::new(),
            ladder: Vec::new(),
            warnings: Vec::new(),
        };
        for (name, fit) in channels {
            let suffix = if channels.len() == 1 { String::new() } else { format!(".{name}") };
            report.add(&suffix, name, fit, settings.model);
        }
        report
    }

    fn add(&mut self, suffix: &str, channel: &str, fit: &ChannelFit, model: Model) {
        let names = fit.parameters.names();
        for (i, name) in names.iter().enumerate() {
            let key = format!("{name}{suffix}");
            let parameter = parameter(fit, i);
            self.start.insert(key.clone(), json!(parameter.value.map(|_| fit.start[i])));
            self.parameters.insert(key, json!(parameter));
        }
        for (name, value) in derived(fit, model) {
            self.derived.insert(format!("{name}{suffix}"), value);
        }
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let key = format!("{}{suffix},{}{suffix}", names[i], names[j]);
            self.correlations.insert(key, json!(fit.uncertainty.correlation(i, j)));
        }
        for (scene, e) in fit.exposures.iter().enumerate() {
            self.exposures.push(json!({
                "scene": scene, "channel": channel,
                "gain": { "value": e.gain, "std_error": e.gain_error },
                "veil": { "value": e.veil, "std_error": e.veil_error },
                "noise": e.noise, "chi2": e.chi2, "pixels": e.pixels, "hidden_pixels": e.hidden_pixels,
            }));
        }
        self.add_determined(channel, fit);
        self.warnings.extend(warnings(suffix, fit, model));
    }

    /// Whether every fit converged and every free parameter is determined.
    pub fn is_complete(&self) -> bool {
        self.fit["converged"] == json!(true)
            && self.parameters.values().all(|p| p["status"] != json!(Status::Undetermined))
    }

    /// Rows of the table for people: heading, then a row a parameter.
    pub fn table(&self, unit: &str) -> Vec<Vec<String>> {
        let row = |cells: [&str; 8]| cells.map(String::from).to_vec();
        let heading = ["", "value", "std error", "", "model error", "95 % interval", "start", "unit"];
        let mut rows = vec![row(heading)];
        let number = |v: &Value| v.as_f64().map_or_else(|| "-".to_string(), significant);
        for (name, p) in &self.parameters {
            let of = Family::ALL.into_iter().find(|f| name.split('.').next() == Some(f.parameter()));
            let unit = of.map_or(unit, |of| of.unit());
            let interval = match &p["ci95"] {
                Value::Array(ends) => format!("{} … {}", number(&ends[0]), number(&ends[1])),
                _ => p["status"].as_str().unwrap_or("-").to_string(),
            };
            let relative =
                p["relative_error"].as_f64().map_or(String::new(), |e| format!("({:.2} %)", 100.0 * e));
            let [value, std_error, model_error, start] =
                ["value", "std_error", "model_error", "start"].map(|key| number(&p[key]));
            rows.push(row([name, &value, &std_error, &relative, &model_error, &interval, &start, unit]));
        }
        for name in ["sigma_t", "sigma_s_b", "sigma_s_reduced"] {
            for (key, d) in self.derived.iter().filter(|(k, _)| k.split('.').next() == Some(name)) {
                let [value, std_error] = ["value", "std_error"].map(|key| number(&d[key]));
                rows.push(row([key, &value, &std_error, "", "", "derived", "", ""]));
            }
        }
        rows
    }

    /// Correlations and statistics, and what kind of scattering this is, as lines for people.
    pub fn remarks(&self) -> Vec<String> {
        let number = |key: &str| self.fit[key].as_f64().map_or_else(|| "-".to_string(), significant);
        let known =
            self.correlations.iter().filter_map(|(key, v)| Some(format!("{key} {:+.3}", v.as_f64()?)));
        let known: Vec<String> = known.collect();
        let mut lines = Vec::new();
        for (key, how) in [("profile95", "profile likelihood"), ("bootstrap95", "bootstrap")] {
            let end = |v: &Value| v.as_f64().map_or_else(|| "open".to_string(), significant);
            let interval = |(name, p): (&String, &Value)| {
                let ends = p.get(key)?.as_array()?;
                Some(format!("{name} {} … {}", end(&ends[0]), end(&ends[1])))
            };
            let found: Vec<String> = self.parameters.iter().filter_map(interval).collect();
            if !found.is_empty() {
                lines.push(format!("95 % by {how}: {}", found.join(";  ")));
            }
        }
        if !known.is_empty() {
            lines.push(format!("correlations: {}", known.join(";  ")));
        }
        lines.extend(self.identified());
        lines.push(format!(
            "chi² {}, reduced {}, AIC {}, BIC {}; {} pixels, {} numbers fitted",
            number("chi2"),
            number("reduced_chi2"),
            number("aic"),
            number("bic"),
            self.fit["pixels"],
            self.fit["fitted"]
        ));
        for (key, verdict) in self.derived.iter().filter(|(key, _)| key.split('.').next() == Some("verdict"))
        {
            lines.push(format!("{key}: {}", verdict.as_str().unwrap_or("-")));
        }
        lines
    }
}

fn backend(backend: Backend) -> Value {
    let adapter = match backend {
        Backend::Cpu => Value::Null,
        #[cfg(feature = "gpu")]
        Backend::Gpu(gpu) => json!(gpu.adapter().to_string()),
    };
    json!({ "kind": backend.name(), "adapter": adapter })
}

/// Five significant digits.
fn significant(v: f64) -> String {
    if v == 0.0 {
        return "0".into();
    }
    let magnitude = v.abs().log10().floor();
    if (-4.0..6.0).contains(&magnitude) {
        format!("{v:.*}", (4.0 - magnitude).max(0.0) as usize)
    } else {
        format!("{v:.4e}")
    }
}

fn parameter(fit: &ChannelFit, i: usize) -> ParameterReport {
    let value = fit.parameters.values()[i];
    let given = fit.parameters.is_fixed(i);
    let absent = fit.parameters.is_placeholder(i);
    let status = if given { Status::Fixed } else { fit.uncertainty.status(i) };
    let error = fit.uncertainty.std_error(i);
    let input_error = error.map(|_| fit.input_error.variance_of(&Vector3::ith(i, 1.0)).sqrt());
    let parameters = &fit.parameters;
    let slope = parameters.slope(i).abs();
    let model_error = error.and(fit.model_error.as_ref()).map(|m| m.of(&Vector3::ith(i, 1.0)));
    let interval = |e: f64| {
        let [low, high] = parameters.bounds(i);
        // What is noise adds in squares, what is an error in full.
        let sampled = fit.model_error.map_or(0.0, |m| m.variance_of(&Vector3::ith(i, 1.0)).sqrt());
        let noise = e.hypot(input_error.unwrap_or(0.0)).hypot(sampled);
        let half = Z95 * noise + model_error.unwrap_or(0.0) - sampled;
        let u = parameters.coordinate(i, value);
        let [a, b] = [u - half, u + half].map(|u| parameters.value_at(i, u));
        [a.min(b).max(low).min(value), a.max(b).min(high).max(value)]
    };
    ParameterReport {
        value: (!absent).then_some(value),
        std_error: error.map(|e| e * slope),
        relative_error: error.filter(|_| value > 0.0).map(|e| e * (slope / value)),
        model_error: model_error.map(|e| e * slope),
        input_error: input_error.map(|e| e * slope),
        ci95: error.map(interval),
        status,
        start: (!absent).then_some(fit.start[i]),
    }
}

fn summary(channels: &[(String, ChannelFit)], seed: u64, seconds: f64) -> Value {
    let fits = || channels.iter().map(|(_, fit)| fit);
    let sum = |f: fn(&ChannelFit) -> u64| fits().map(f).sum::<u64>();
    let pixels = sum(|f| f.pixels as u64);
    let chi2 = fits().map(|f| f.reduced_chi2 * f.pixels as f64).sum::<f64>() / pixels.max(1) as f64;
    let stops: Vec<&str> = fits().map(|f| f.stop.as_str()).collect();
    let all_same = stops.iter().all(|s| *s == stops[0]);
    json!({
        "converged": fits().all(|f| f.converged),
        "stop": if all_same { stops[0].to_string() } else { stops.join("; ") },
        "cost": fits().map(|f| f.cost).sum::<f64>(),
        "chi2": fits().map(|f| 2.0 * f.cost).sum::<f64>(),
        "reduced_chi2": chi2,
        "aic": fits().map(ChannelFit::aic).sum::<f64>(),
        "bic": fits().map(ChannelFit::bic).sum::<f64>(),
        "fitted": sum(|f| f.fitted as u64),
        "pixels": pixels,
        "hidden_pixels": sum(|f| f.hidden_pixels as u64),
        "path": if fits().all(|f| f.by_sums.is_some()) { "sums" } else { "renders" },
        "iterations": sum(|f| f.iterations),
        "evaluations": sum(|f| f.evaluations),
        "sum_evaluations": sum(|f| f.sum_evaluations),
        "traced": fits().find_map(|f| f.paths).map(|_| json!({
            "paths": sum(|f| f.paths.map_or(0, |(count, _)| count)),
            "effective_share": fits().filter_map(|f| f.paths).map(|(_, share)| share).fold(1.0, f64::min),
            "seed": seed,
        })),
        "seconds": seconds,
    })
}
