//! A fit as text for people: a table, and remarks below it.

use super::number::significant;
use super::{AdviceReport, Derived, Determined, DiagnosisReport, Estimate, Fit};
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
        lines.extend(self.registrations());
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

    /// How far each observation that was registered is shifted.
    fn registrations(&self) -> Vec<String> {
        let line = |e: &super::ExposureReport| {
            let registration = e.registration.as_ref()?;
            let errors = registration.std_errors.shift_px.map(|error| match error {
                Some(error) => format!("± {error:.4}"),
                None => "undetermined".into(),
            });
            let [x, y] = registration.shift_px;
            Some(format!(
                "scene {}, channel {}: shifted by {x:.4} {} px to the right, {y:.4} {} px down",
                e.scene + 1,
                e.channel,
                errors[0],
                errors[1]
            ))
        };
        self.exposures.iter().filter_map(line).collect()
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
