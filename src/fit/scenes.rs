//! Fitting scene files: one fit a channel, over all scenes.

use super::inference::ChannelFit;
use super::interval::Intervals;
use super::observation::{NoiseTerm, Observation, VeilTerm};
use super::parameters::Parameters;
use super::report::{Fit, Warning, Ways, suffix};
use super::slips::slips;
use super::{Settings, fit_channel};
use crate::error::{Error, Result};
use crate::filter::{Filter, Target};
use crate::geometry::path_lengths;
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
    pub report: Fit,
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
            Some(Channel { name: name.clone(), image: fit.unseen[scene].hidden.clone()? })
        };
        self.channels.iter().map(channel).collect()
    }

    /// Adds to the report the intervals that `find` makes of each channel's observations, fit and options, found in this way.
    ///
    /// # Errors
    /// Those of `find`.
    pub fn add_intervals(
        &mut self,
        way: Ways,
        scenes: &[ObservedScene],
        filter: Filter,
        mut find: impl FnMut(&[Observation], &ChannelFit, &FitOptions) -> Result<Intervals>,
    ) -> Result<()> {
        let reliefs = reliefs(scenes, filter);
        for (i, (name, fit)) in self.channels.iter().enumerate() {
            let intervals = find(&observations(scenes, &reliefs, i), fit, &scenes[0].scene.fit[i])?;
            let suffix = suffix(name, self.channels.len());
            for (parameter, interval) in intervals {
                self.report.add_interval(&format!("{parameter}{suffix}"), way, interval);
            }
        }
        Ok(())
    }

    /// Whether some light of some scene may be hidden, even if too little to leave pixels out.
    pub fn hides(&self) -> bool {
        self.channels.iter().any(|(_, fit)| fit.unseen.iter().any(|unseen| unseen.hidden.is_some()))
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
/// [`Error::Scene`] if the scenes have different channels, or two of them the same observation, [`Error::NothingToFit`] if every parameter is fixed,
/// [`Error::OutOfRange`] for a start outside its bounds, [`Error::NotShifted`] if an observation is to be registered by a model
/// that does not render shifts.
pub fn check_scenes(scenes: &[ObservedScene], settings: &Settings) -> Result<()> {
    let first = &scenes[0].scene;
    for ObservedScene { scene, .. } in scenes {
        if scene.channels() != first.channels() {
            let message = format!(
                "its channels {:?} are not those of {}: {:?}",
                scene.channels(),
                first.path.display(),
                first.channels()
            );
            return Err(Error::Scene { path: scene.path.clone(), message });
        }
    }
    for (i, ObservedScene { scene, observation }) in scenes.iter().enumerate() {
        if let Some(before) = scenes[..i].iter().find(|before| before.observation.image == observation.image)
        {
            let message = format!(
                "what was observed is the same image as that of {}: counted twice, it would make the error bars too small",
                before.scene.path.display()
            );
            return Err(Error::Scene { path: scene.path.clone(), message });
        }
    }
    if !settings.engine().renders_shifts() && scenes.iter().any(|s| s.observation.frees_camera()) {
        return Err(Error::NotShifted);
    }
    let shown: Vec<_> = scenes.iter().map(|s| (&s.scene.geometry, &s.scene.object[0].image)).collect();
    let lengths = path_lengths(&shown);
    for options in &first.fit {
        Parameters::new(options, settings.model, lengths).map_err(|e| e.about("[fit]"))?;
    }
    Ok(())
}

/// Fits `scenes`, which share one medium a channel. Options of `[fit]` are the first scene's. `progress` is called after every
/// render.
///
/// # Errors
/// As [`check_scenes`] and [`fit_channel`].
pub fn fit_scenes(
    scenes: &[ObservedScene],
    settings: &Settings,
    filter: Filter,
    progress: &dyn Fn(),
) -> Result<SceneFit> {
    check_scenes(scenes, settings)?;
    let clock = Instant::now();
    let first = &scenes[0].scene;
    let reliefs = reliefs(scenes, filter);
    let mut channels = Vec::new();
    for (i, name) in first.channels().into_iter().enumerate() {
        let observations = observations(scenes, &reliefs, i);
        channels.push((name.to_string(), fit_channel(&observations, &first.fit[i], settings, progress)?));
    }
    let used = Filter::of(reliefs.iter().flatten().next());
    let mut report = Fit::new(&channels, settings, used, clock.elapsed().as_secs_f64());
    for seen in scenes {
        let cautions = seen.scene.cautions.iter().chain(&seen.observation.cautions);
        report.warnings.extend(cautions.map(Warning::from));
    }
    report.warnings.extend(slips(scenes));
    Ok(SceneFit { channels, report })
}

/// What `filter` needs to know of the depth map of each scene.
pub(super) fn reliefs(scenes: &[ObservedScene], filter: Filter) -> Vec<Option<Relief>> {
    scenes.iter().map(|s| filter.relief(&s.scene.geometry)).collect()
}

/// Channel `i` of all scenes.
pub(super) fn observations<'a>(
    scenes: &'a [ObservedScene],
    reliefs: &'a [Option<Relief>],
    i: usize,
) -> Vec<Observation<'a>> {
    scenes.iter().zip(reliefs).map(|(scene, relief)| observation(scene, relief.as_ref(), i)).collect()
}

/// Channel `i` of an observed scene.
fn observation<'a>(seen: &'a ObservedScene, relief: Option<&'a Relief>, i: usize) -> Observation<'a> {
    let ObservedScene { scene, observation } = seen;
    Observation {
        target: Target {
            radiance: &scene.object[i].image,
            behind: &scene.behind[i],
            geometry: &scene.geometry,
            border: scene.border,
            sampling: scene.sampling,
            view: scene.view,
            relief,
        },
        observed: &observation.image[i].image,
        mask: observation.mask.as_ref(),
        hidden_share_max: observation.hidden_share_max,
        noise: observation.noise.as_ref().map(|noise| noise_term(noise, i)),
        object_noise: scene.object_noise.as_ref().map(|noise| noise_term(noise, i)),
        gain: observation.gain,
        gain_error: observation.gain_error,
        depth_error: scene.depth_error,
        veil: match &observation.veil {
            Veil::Fixed(v) => VeilTerm::Fixed(*v),
            Veil::Image(channels) => VeilTerm::Image(&channels[i].image),
            Veil::Free(field) => VeilTerm::Free(*field),
            Veil::Auto => VeilTerm::Fixed(0.0),
        },
        registration: observation.registration.least(),
        blur: observation.blur.least(),
        gain_field: observation.gain_field.least(),
        sampling_is_known: scene.sampling_is_known,
        loss: observation.loss,
        saturated_pixels: observation.saturated_pixels,
    }
}

/// The noise of channel `i`.
fn noise_term(noise: &Noise, i: usize) -> NoiseTerm<'_> {
    match noise {
        Noise::Level(v) => NoiseTerm::Level(*v),
        Noise::Sensor { read, shot } => NoiseTerm::Sensor { read: *read, shot: *shot },
        Noise::Variance(channels) => NoiseTerm::Variance(&channels[i].image),
    }
}
