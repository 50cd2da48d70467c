//! Fitting scene files: one fit a channel, over all scenes.

use super::report::FitReport;
use super::{ChannelFit, Datum, Intervals, NoiseTerm, Parameters, Settings, VeilTerm};
use super::{advise, fit_channel, path_lengths};
use crate::error::{Error, Result};
use crate::filter::{Filter, Target};
use crate::geometry::Geometry;
use crate::image::{Channel, Image};
use crate::relief::Relief;
use crate::scene::{FitOptions, Noise, ObservedScene, Veil};
use std::time::Instant;

/// The fits of all channels, the images that they leave, and the report.
#[derive(Debug, Clone)]
pub struct SceneFit {
    /// Name and fit of each channel.
    pub channels: Vec<(String, ChannelFit)>,
    /// The report for users.
    pub report: FitReport,
}

impl SceneFit {
    /// Best fit of scene `scene`, in units of its observation.
    pub fn render(&self, scene: usize) -> Vec<Channel> {
        let channel = |(name, fit): &(String, ChannelFit)| Channel {
            name: name.clone(),
            image: fit.renders[scene].clone(),
        };
        self.channels.iter().map(channel).collect()
    }

    /// Share of hidden light of every pixel of scene `scene`, where it has some.
    pub fn hidden_share(&self, scene: usize) -> Option<Vec<Channel>> {
        let channel = |(name, fit): &(String, ChannelFit)| {
            Some(Channel { name: name.clone(), image: fit.hidden_shares[scene].clone()? })
        };
        self.channels.iter().map(channel).collect()
    }

    /// Adds to the report, under `key` of each parameter, the intervals that `find` makes of each channel's data, fit and
    /// options.
    ///
    /// # Errors
    /// Those of `find`.
    pub fn add_intervals(
        &mut self,
        key: &str,
        scenes: &[ObservedScene],
        filter: Filter,
        mut find: impl FnMut(&[Datum], &ChannelFit, &FitOptions) -> Result<Intervals>,
    ) -> Result<()> {
        let reliefs = reliefs(scenes, filter);
        for (i, (name, fit)) in self.channels.iter().enumerate() {
            let intervals = find(&data(scenes, &reliefs, i), fit, &scenes[0].scene.fit[i])?;
            let suffix = if self.channels.len() == 1 { String::new() } else { format!(".{name}") };
            for (parameter, interval) in fit.parameters.names().iter().zip(intervals) {
                self.report.parameters[&format!("{parameter}{suffix}")][key] = serde_json::json!(interval);
            }
        }
        Ok(())
    }

    /// Adds to the report which measurement would free what is undetermined, if something is.
    ///
    /// # Errors
    /// As [`advise`].
    pub fn add_advice(
        &mut self,
        scenes: &[ObservedScene],
        settings: &Settings,
        filter: Filter,
    ) -> Result<()> {
        let reliefs = reliefs(scenes, filter);
        for (i, (name, fit)) in self.channels.iter().enumerate() {
            let advice = advise(&data(scenes, &reliefs, i), fit, settings)?;
            self.report.add_advice(name, self.channels.len(), fit, &advice);
        }
        Ok(())
    }

    /// Whether some light of some scene may be hidden, be it enough to leave pixels out or not.
    pub fn hides(&self) -> bool {
        self.channels.iter().any(|(_, fit)| fit.hidden_shares.iter().any(Option::is_some))
    }

    /// Observation minus best fit of scene `scene`.
    pub fn residual(&self, scene: usize, observed: &[Channel]) -> Vec<Channel> {
        let subtract = |(render, observed): (Channel, &Channel)| {
            let pairs = observed.image.data.iter().zip(&render.image.data);
            let data = pairs.map(|(o, r)| o - r).collect();
            Channel { name: render.name, image: Image { data, ..observed.image.clone() } }
        };
        self.render(scene).into_iter().zip(observed).map(subtract).collect()
    }
}

/// Refuses scenes that cannot be fitted together with `settings`, before any work is done.
///
/// # Errors
/// [`Error::Scene`] if the scenes have different channels, [`Error::NothingToFit`] if every
/// parameter is fixed, [`Error::OutOfRange`] for a start outside its bounds.
pub fn check_scenes(scenes: &[ObservedScene], settings: &Settings) -> Result<()> {
    let first = &scenes[0];
    if let Some(other) = scenes.iter().find(|scene| names(scene) != names(first)) {
        let message = format!(
            "its channels {:?} are not those of {}: {:?}",
            names(other),
            first.scene.path.display(),
            names(first)
        );
        return Err(Error::Scene { path: other.scene.path.clone(), message });
    }
    let depths: Vec<&Geometry> = scenes.iter().map(|s| &s.scene.geometry).collect();
    let lengths = path_lengths(&depths);
    for options in &first.scene.fit {
        Parameters::new(options, settings.model, lengths)?;
    }
    Ok(())
}

fn names(scene: &ObservedScene) -> Vec<String> {
    scene.scene.object.iter().map(|c| c.name.clone()).collect()
}

/// Fits `scenes`, which share one medium a channel. Options of `[fit]` are the first scene's.
///
/// # Errors
/// As [`check_scenes`] and [`fit_channel`].
pub fn fit_scenes(scenes: &[ObservedScene], settings: &Settings, filter: Filter) -> Result<SceneFit> {
    check_scenes(scenes, settings)?;
    let clock = Instant::now();
    let first = &scenes[0];
    let reliefs = reliefs(scenes, filter);
    let mut channels = Vec::new();
    for (i, name) in names(first).into_iter().enumerate() {
        channels.push((name, fit_channel(&data(scenes, &reliefs, i), &first.scene.fit[i], settings)?));
    }
    let used = Filter::of(reliefs.iter().flatten().next());
    let report = FitReport::new(&channels, settings, used, clock.elapsed().as_secs_f64());
    Ok(SceneFit { channels, report })
}

/// What `filter` needs to know of the depth map of each scene.
pub(super) fn reliefs(scenes: &[ObservedScene], filter: Filter) -> Vec<Option<Relief>> {
    scenes.iter().map(|scene| filter.relief(&scene.scene.geometry)).collect()
}

/// Channel `i` of all scenes.
pub(super) fn data<'a>(
    scenes: &'a [ObservedScene],
    reliefs: &'a [Option<Relief>],
    i: usize,
) -> Vec<Datum<'a>> {
    scenes.iter().zip(reliefs).map(|(scene, relief)| datum(scene, relief.as_ref(), i)).collect()
}

/// Channel `i` of an observed scene.
fn datum<'a>(observed: &'a ObservedScene, relief: Option<&'a Relief>, i: usize) -> Datum<'a> {
    let ObservedScene { scene, observation } = observed;
    Datum {
        target: Target {
            radiance: &scene.object[i].image,
            behind: &scene.behind[i],
            geometry: &scene.geometry,
            border: scene.border,
            view: scene.view,
            relief,
        },
        observed: &observation.image[i].image,
        mask: observation.mask.as_ref(),
        hidden_share_max: observation.hidden_share_max,
        noise: observation.noise.as_ref().map(|noise| match noise {
            Noise::Level(v) => NoiseTerm::Level(*v),
            Noise::Variance(channels) => NoiseTerm::Variance(&channels[i].image),
        }),
        gain: observation.gain,
        gain_error: observation.gain_error,
        depth_error: scene.depth_error,
        veil: match &observation.veil {
            Veil::Fixed(v) => VeilTerm::Fixed(*v),
            Veil::Image(channels) => VeilTerm::Image(&channels[i].image),
            Veil::Free => VeilTerm::Free,
        },
    }
}
