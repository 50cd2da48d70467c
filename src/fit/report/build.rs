//! From the fits of all channels to the report.

use super::derived::derived;
use super::exposure::ExposureReport;
use super::warnings::warnings;
use super::{BackendReport, DiagnosisReport, Estimate, Fit, Severity, Summary};
use crate::filter::{Backend, Filter};
use crate::fit::Settings;
use crate::fit::inference::ChannelFit;
use crate::phase::Family;
use crate::spread::Model;
use indexmap::IndexMap;

/// What names of parameters of the channel `name`, one of `channels`, end in.
pub(in crate::fit) fn suffix(name: &str, channels: usize) -> String {
    if channels == 1 { String::new() } else { format!(".{name}") }
}

impl Fit {
    /// Report of the fits of all `channels` (name and fit) that took `seconds`.
    pub(crate) fn new(
        channels: &[(String, ChannelFit)],
        settings: &Settings,
        filter: Filter,
        seconds: f64,
    ) -> Self {
        let family = channels.first().map_or(Family::default(), |(_, fit)| fit.parameters.family());
        let mut report = Self {
            version: env!("CARGO_PKG_VERSION").into(),
            model: settings.model.name().into(),
            phase: family.name().into(),
            filter: filter.name().into(),
            backend: backend(settings.backend),
            parameters: IndexMap::new(),
            derived: IndexMap::new(),
            correlations: IndexMap::new(),
            fit: Summary::new(channels, settings.tracing.seed, seconds),
            exposures: Vec::new(),
            start: IndexMap::new(),
            command: None,
            provenance: None,
            files: IndexMap::new(),
            determined: Vec::new(),
            advice: Vec::new(),
            candidates: Vec::new(),
            camera: Vec::new(),
            diagnosis: Vec::new(),
            warnings: Vec::new(),
        };
        for (name, fit) in channels {
            report.add(&suffix(name, channels.len()), name, fit, settings.model);
        }
        report
    }

    fn add(&mut self, suffix: &str, channel: &str, fit: &ChannelFit, model: Model) {
        let before = self.parameters.len();
        for (id, parameter) in fit.parameters.of_medium() {
            let key = format!("{}{suffix}", parameter.name());
            let estimate = Estimate::new(fit, id);
            self.start.insert(key.clone(), estimate.start);
            self.parameters.insert(key, estimate);
        }
        for (name, value) in derived(fit, model) {
            self.derived.insert(format!("{name}{suffix}"), value);
        }
        let of_medium: Vec<_> = fit.parameters.of_medium().collect();
        for (i, (id, first)) in of_medium.iter().enumerate() {
            for (other, second) in &of_medium[i + 1..] {
                let key = format!("{}{suffix},{}{suffix}", first.name(), second.name());
                self.correlations.insert(key, fit.covariance.correlation(*id, *other));
            }
        }
        let exposures = fit.exposures.iter().enumerate();
        self.exposures.extend(exposures.map(|(scene, e)| ExposureReport::new(scene, channel, e, fit)));
        self.add_determined(channel, fit);
        let findings = fit.findings.iter();
        self.diagnosis.extend(findings.map(|finding| DiagnosisReport::new(finding, fit, channel, suffix)));
        let warnings = warnings(suffix, fit, model);
        if warnings.iter().any(|warning| warning.severity == Severity::Invalid) {
            self.parameters.values_mut().skip(before).for_each(Estimate::doubt);
        }
        self.warnings.extend(warnings);
    }
}

fn backend(backend: Backend) -> BackendReport {
    BackendReport { kind: backend.name().into(), adapter: backend.adapter(), reason: None }
}
