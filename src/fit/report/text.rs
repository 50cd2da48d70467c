//! A fit as text for people: a table, and remarks below it.

use super::number::significant;
use super::{
    AdviceReport, Derived, Determined, DiagnosisReport, Estimate, ExposureReport, FieldReport, Fit,
    RegistrationReport, Term,
};
use crate::fit::inference::Status;
use crate::phase::Family;

impl Fit {
    /// Rows of the table for people: heading, then a row a parameter.
    pub fn table(&self, unit: &str) -> Vec<Vec<String>> {
        let row = |cells: [&str; 8]| cells.map(String::from).to_vec();
        let heading = ["", "value", "std error", "", "model error", "95 % interval", "start", "unit"];
        let mut rows = vec![row(heading)];
        for (name, p) in &self.parameters {
            let of = Family::ALL.into_iter().find(|f| base(name) == f.parameter_name());
            let unit = of.map_or(unit, |of| of.unit());
            let relative = p.relative_error.map_or(String::new(), |e| format!("({:.2} %)", 100.0 * e));
            let known = matches!(p.status, Status::Free | Status::Fixed);
            let of_known = |value: Option<f64>| number(value.filter(|_| known));
            let relative = if known { relative } else { String::new() };
            let [value, std_error, model_error] = [p.value, p.std_error, p.model_error].map(of_known);
            let start = number(p.start);
            rows.push(row([name, &value, &std_error, &relative, &model_error, &interval(p), &start, unit]));
        }
        for name in ["sigma_t", "sigma_s_b", "sigma_s_reduced"] {
            for (key, derived) in self.derived.iter().filter(|(key, _)| base(key) == name) {
                let Derived::Estimate { value, std_error } = derived else { continue };
                let (value, std_error) = (significant(*value), number(*std_error));
                rows.push(row([key, &value, &std_error, "", "", "derived", "", ""]));
            }
        }
        rows
    }

    /// Correlations and statistics, and what kind of scattering this is, as lines for people.
    pub fn remarks(&self) -> Vec<String> {
        let mut lines = Vec::new();
        type Further = fn(&Estimate) -> Option<[Option<f64>; 2]>;
        let profile: Further = |p| p.profile95.flatten();
        let bootstrap: Further = |p| p.bootstrap95.flatten();
        for (ends, how) in [(profile, "profile likelihood"), (bootstrap, "bootstrap")] {
            let found = self.parameters.iter().filter_map(|(name, p)| {
                let [low, high] = ends(p)?.map(|end| end.map_or_else(|| "open".to_string(), significant));
                Some(format!("{name} {low} … {high}"))
            });
            let found: Vec<String> = found.collect();
            if !found.is_empty() {
                lines.push(format!("95 % by {how}: {}", found.join(";  ")));
            }
        }
        let known = self.correlations.iter().filter_map(|(key, v)| Some(format!("{key} {:+.3}", (*v)?)));
        let known: Vec<String> = known.collect();
        if !known.is_empty() {
            lines.push(format!("correlations: {}", known.join(";  ")));
        }
        lines.extend(self.cameras());
        lines.extend(self.diagnosis.iter().map(DiagnosisReport::line));
        lines.extend(self.determined.iter().map(determined));
        lines.extend(self.advice.iter().map(|AdviceReport { message, .. }| format!("advice: {message}")));
        lines.push(self.statistics());
        for (key, words) in self.derived.iter().filter(|(key, _)| base(key) == "verdict") {
            if let Derived::Words(words) = words {
                lines.push(format!("{key}: {words}"));
            }
        }
        lines
    }

    fn statistics(&self) -> String {
        let fit = &self.fit;
        format!(
            "chi² {}, reduced {}, AIC {}, BIC {}; {} pixels, {} numbers fitted",
            significant(fit.chi2),
            significant(fit.reduced_chi2),
            significant(fit.aic),
            significant(fit.bic),
            fit.pixels,
            fit.fitted
        )
    }

    /// What was fitted of the camera of each observation.
    fn cameras(&self) -> Vec<String> {
        let line = |e: &ExposureReport| {
            let parts: Vec<String> = [
                e.registration.as_ref().map(registration),
                e.blur_px
                    .as_ref()
                    .map(|blur| format!("blurred by {} px", with_error(blur.value, blur.std_error))),
                e.gain_field.as_ref().map(|field| format!("gain field {}", terms(field))),
                e.veil_field.as_ref().map(|field| format!("veil field {}", terms(field))),
            ]
            .into_iter()
            .flatten()
            .collect();
            let place = format!("scene {}, channel {}", e.scene + 1, e.channel);
            (!parts.is_empty()).then(|| format!("{place}: {}", parts.join("; ")))
        };
        self.exposures.iter().filter_map(line).collect()
    }
}

fn registration(found: &RegistrationReport) -> String {
    let ([x, y], errors) = (found.shift_px, &found.std_errors);
    let [x, y] = [with_error(x, errors.shift_px[0]), with_error(y, errors.shift_px[1])];
    let shifted = format!("shifted by {x} px to the right, {y} px down");
    match (found.rotation_deg, found.scale) {
        (Some(angle), Some(scale)) => format!(
            "{shifted}, turned by {} degrees, {} times as large",
            with_error(angle, errors.rotation_deg),
            with_error(scale, errors.scale)
        ),
        _ => shifted,
    }
}

fn terms(field: &FieldReport) -> String {
    let term = |(name, term): (&String, &Term)| format!("{name}: {}", with_error(term.value, term.std_error));
    field.terms.iter().map(term).collect::<Vec<_>>().join(", ")
}

fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{value:.4} ± {error:.4}"),
        None => format!("{value:.4} undetermined"),
    }
}

/// The name of a parameter without that of its channel.
fn base(name: &str) -> &str {
    name.split('.').next().unwrap_or(name)
}

fn interval(estimate: &Estimate) -> String {
    match (estimate.ci95, estimate.status) {
        (Some([low, high]), _) => format!("{} … {}", significant(low), significant(high)),
        (None, Status::Free) => "free".into(),
        (None, Status::Fixed) => "fixed".into(),
        (None, Status::Undetermined) => "undetermined".into(),
        (None, Status::Doubtful) => "doubtful".into(),
    }
}

fn determined(Determined { combination, .. }: &Determined) -> String {
    format!(
        "determined: {} = {} ± {} ({:.2} %)",
        combination.combination,
        significant(combination.value),
        significant(combination.std_error),
        100.0 * combination.relative_error
    )
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_string(), significant)
}
