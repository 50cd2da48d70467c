//! The result of a fit as users read it: `fit.json`, and the table on the terminal.

use super::ladder::Rung;
use super::uncertainty::{Status, Z95};
use super::{ChannelFit, MISFIT, NAMES, Settings};
use crate::filter::{Backend, CUT, Filter};
use crate::medium::Medium;
use crate::phase::{Gaussian, PhaseFunction};
use crate::spread::{Model, SMALL_ANGLE_LIMIT, small_angle_error};
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
    /// Error of the model itself at this scene, [`ModelError`](super::ModelError); `None` where it is not known.
    pub model_error: Option<f64>,
    /// 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Free, fixed or undetermined.
    pub status: Status,
}

/// Everything about a fit, over all its channels.
#[derive(Debug, Clone, Serialize)]
pub struct FitReport {
    /// Version of the program.
    pub version: &'static str,
    /// Spread model.
    pub model: &'static str,
    /// Filter for depth maps.
    pub filter: &'static str,
    /// What computed the renders.
    pub backend: Value,
    /// sigma_s, sigma_a, b; with a suffix `.R` and so on for colour.
    pub parameters: Map<String, Value>,
    /// Quantities that follow from them, with the same suffixes.
    pub derived: Map<String, Value>,
    /// How the fit went, over all channels.
    pub fit: Value,
    /// Gain, veil, noise and misfit of every scene and channel.
    pub exposures: Vec<Value>,
    /// Starting values used.
    pub start: Map<String, Value>,
    /// The command line, if there was one.
    pub command: Option<String>,
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
            filter: filter.name(),
            backend: backend(settings.backend),
            parameters: Map::new(),
            derived: Map::new(),
            fit: summary(channels, seconds),
            exposures: Vec::new(),
            start: Map::new(),
            command: None,
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
        for (i, name) in NAMES.iter().enumerate() {
            let key = format!("{name}{suffix}");
            let parameter = parameter(fit, i);
            self.start.insert(key.clone(), json!(parameter.value.map(|_| fit.start[i])));
            self.parameters.insert(key, json!(parameter));
        }
        for (name, value) in derived(fit, model) {
            self.derived.insert(format!("{name}{suffix}"), value);
        }
        for (scene, e) in fit.exposures.iter().enumerate() {
            self.exposures.push(json!({
                "scene": scene, "channel": channel,
                "gain": { "value": e.gain, "std_error": e.gain_error },
                "veil": { "value": e.veil, "std_error": e.veil_error },
                "noise": e.noise, "chi2": e.chi2, "pixels": e.pixels, "hidden_pixels": e.hidden_pixels,
            }));
        }
        self.warnings.extend(warnings(suffix, fit, model));
    }

    /// Whether every fit converged and every free parameter is determined.
    pub fn is_complete(&self) -> bool {
        self.fit["converged"] == json!(true)
            && self.parameters.values().all(|p| p["status"] != json!(Status::Undetermined))
    }

    /// Rows of the table for people: heading, then a row a parameter.
    pub fn table(&self, unit: &str) -> Vec<Vec<String>> {
        let row = |cells: [&str; 5]| cells.map(String::from).to_vec();
        let mut rows = vec![row(["", "value", "std error", "95 % interval", "unit"])];
        let number = |v: &Value| v.as_f64().map_or_else(|| "-".to_string(), significant);
        for (name, p) in &self.parameters {
            let unit = if name.starts_with('b') { "rad²" } else { unit };
            let interval = match &p["ci95"] {
                Value::Array(ends) => format!("{} … {}", number(&ends[0]), number(&ends[1])),
                _ => p["status"].as_str().unwrap_or("-").to_string(),
            };
            rows.push(row([name, &number(&p["value"]), &number(&p["std_error"]), &interval, unit]));
        }
        for name in ["sigma_t", "sigma_s_b"] {
            for (key, d) in self.derived.iter().filter(|(k, _)| k.split('.').next() == Some(name)) {
                rows.push(row([key, &number(&d["value"]), &number(&d["std_error"]), "derived", ""]));
            }
        }
        rows
    }
}

fn backend(backend: Backend) -> Value {
    let adapter = match backend {
        Backend::Cpu => Value::Null,
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
    let logarithmic = i != 1;
    let model_error = error.and(fit.model_error.as_ref()).map(|m| m.of(&Vector3::ith(i, 1.0)));
    let interval = |e: f64| {
        let [low, high] = fit.parameters.bounds(i);
        let half = Z95 * e + model_error.unwrap_or(0.0);
        let ends = if logarithmic {
            [value * (-half).exp(), value * half.exp()]
        } else {
            [value - half, value + half]
        };
        [ends[0].max(low).min(value), ends[1].min(high).max(value)]
    };
    ParameterReport {
        value: (!absent).then_some(value),
        std_error: error.map(|e| if logarithmic { e * value } else { e }),
        model_error: model_error.map(|e| if logarithmic { e * value } else { e }),
        ci95: error.map(interval),
        status,
    }
}

/// What follows from the parameters of one channel.
fn derived(fit: &ChannelFit, model: Model) -> Vec<(&'static str, Value)> {
    let [sigma_s, sigma_a, b] = fit.parameters.values();
    let medium = Medium::new(sigma_s, sigma_a).expect("parameters stay in their range");
    let error = |gradient: [f64; 3], scale: f64| {
        fit.uncertainty.variance_of(&Vector3::from(gradient)).map(|v| v.sqrt() * scale)
    };
    let z = fit.median_z;
    let sigma_t = json!({ "value": medium.sigma_t(), "std_error": error([sigma_s, 1.0, 0.0], 1.0) });
    let mut all = vec![("sigma_t", sigma_t)];
    if model.spreads() {
        let product = sigma_s * b;
        all.push(("sigma_s_b", json!({ "value": product, "std_error": error([1.0, 0.0, 1.0], product) })));
    }
    all.push(("tau", json!(medium.tau(z))));
    all.push(("optical_depth", json!(medium.sigma_t() * z)));
    all.push(("albedo", json!(medium.albedo())));
    if model.spreads() {
        let phase = Gaussian::new(b).expect("parameters stay in their range");
        all.push(("spread_angle_deg", json!(phase.spread_angle().to_degrees())));
        all.push(("g", json!(phase.mean_cosine())));
        all.push(("validity", json!(medium.tau(z) * 4.0 * b)));
    }
    all.push(("z", json!(z)));
    all
}

fn summary(channels: &[(String, ChannelFit)], seconds: f64) -> Value {
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
        "reduced_chi2": chi2,
        "pixels": pixels,
        "hidden_pixels": sum(|f| f.hidden_pixels as u64),
        "path": if fits().all(|f| f.by_sums.is_some()) { "sums" } else { "renders" },
        "iterations": sum(|f| f.iterations),
        "evaluations": sum(|f| f.evaluations),
        "sum_evaluations": sum(|f| f.sum_evaluations),
        "seconds": seconds,
    })
}

fn warnings(suffix: &str, fit: &ChannelFit, model: Model) -> Vec<Warning> {
    let mut all = Vec::new();
    let mut warn = |code, message| all.push(Warning { code, message });
    if !fit.converged {
        warn("not_converged", format!("the fit{suffix} stopped before its optimum: {}", fit.stop));
    }
    let lost: Vec<usize> = (0..3).filter(|&i| fit.uncertainty.status(i) == Status::Undetermined).collect();
    if !lost.is_empty() {
        let names: Vec<String> = lost.iter().map(|&i| format!("{}{suffix}", NAMES[i])).collect();
        warn(
            "undetermined",
            format!("the data do not determine {}: {}", names.join(" and "), why(fit, &lost, model)),
        );
    }
    if fit.cut {
        warn("kernel_cut", format!("{CUT}{suffix}"));
    }
    if !fit.settled {
        let message = "the noise of the scenes or the depth slices of the render did not settle";
        warn("not_settled", format!("{message}{suffix}"));
    }
    if fit.hidden_pixels > fit.pixels {
        warn(
            "hidden_light",
            format!(
                "{} of {} pixels{suffix} are left out, as more than hidden_share_max of their light may be hidden \
                 behind near surfaces; give what lies there as [[object.layer]], or raise [observation] \
                 hidden_share_max",
                fit.hidden_pixels,
                fit.hidden_pixels + fit.pixels
            ),
        );
    }
    if fit.reduced_chi2 > MISFIT {
        warn(
            "misfit",
            format!(
                "reduced chi²{suffix} is {}: the image is not what {model} makes of this scene; the noise may be \
                 more than stated, the geometry or the object wrong, or the scenes' media different",
                significant(fit.reduced_chi2)
            ),
        );
    }
    let on = fit.parameters.at_bound();
    let pressed: Vec<String> = on
        .iter()
        .filter(|&&i| !(i == 1 && fit.parameters.values()[1] == 0.0))
        .map(|&i| format!("{}{suffix}", NAMES[i]))
        .collect();
    if !pressed.is_empty() {
        warn("at_bound", format!("on a bound, where the interval is cut: {}", pressed.join(", ")));
    }
    let [sigma_s, _, b] = fit.parameters.values();
    let validity = sigma_s * fit.median_z * 4.0 * b;
    if model.rests_on_small_angles() && validity > SMALL_ANGLE_LIMIT {
        warn(
            "outside_validity",
            format!(
                "tau·4B{suffix} = {validity:.3} is above {SMALL_ANGLE_LIMIT}: {model} rests on small angles, whose \
                 transfer function is off by {} here; the residual does not show it, and the intervals leave it out",
                small_angle_error(validity)
            ),
        );
    }
    all
}

/// Why `lost` parameters are undetermined, and what would help.
fn why(fit: &ChannelFit, lost: &[usize], model: Model) -> &'static str {
    let free_gain = fit.exposures.iter().any(|e| e.gain_error.is_none() && fit.free_gain);
    if !model.spreads() {
        "direct light alone shows only sigma_t; fix sigma_s or sigma_a, or use a model that spreads light"
    } else if lost == [1] && free_gain {
        "with a free gain of its own, a scene at one depth cannot tell absorption from exposure; give the gain of one \
         scene, or use an object that spans depths"
    } else if lost.contains(&0) && lost.contains(&2) {
        "they trade against each other; only sigma_s·B (derived.sigma_s_b) may be known; a second depth, a sharper \
         object or less noise would part them"
    } else {
        "the noise allows it almost any value; a longer exposure, a sharper object or another depth would help"
    }
}
