//! A folder with a scene and the medium through which it was observed.

use crate::error::{Error, Result};
use crate::filter::{Backend, Filter, Optics, Target, hidden_share};
use crate::geometry::path_lengths;
use crate::image::{Channel, Image, Sampling};
use crate::io::exr::ExrFile;
use crate::lab::compare::{RmsError, rms_error};
use crate::medium::Medium;
use crate::relief::Relief;
use crate::scene::{Gain, Noise, Observation, ObservedScene, Scene, Veil, read_truth};
use crate::spread::Model;
use crate::trace::Estimate;
use std::path::Path;

/// A scene that was observed through a known medium.
#[derive(Debug, Clone)]
pub struct Dataset {
    /// Name of its folder.
    pub name: String,
    /// The scene with its observation.
    pub observed: ObservedScene,
    /// The medium of each channel.
    pub truth: Vec<Medium>,
    /// Median path length, length.
    pub z: f64,
    /// Channel and index of every pixel that counts: where the mask permits it and hardly any light is hidden.
    counted: Vec<(usize, usize)>,
    /// Light from the object at these pixels, with gain and veil removed, and its noise.
    light: Vec<Estimate>,
}

impl Dataset {
    /// Reads `scene.toml` and `truth.toml` of `folder`.
    ///
    /// # Errors
    /// As [`ObservedScene::read`] and [`read_truth`]; [`Error::Scene`] if gain, veil or noise of the observation are not known.
    pub fn read(folder: &Path) -> Result<Self> {
        let observed = ObservedScene::read(&folder.join("scene.toml"))?;
        let channels = observed.scene.object.len();
        let truth_path = folder.join("truth.toml");
        let mut truth = read_truth(&truth_path)?;
        if truth.len() == 1 {
            truth.resize(channels, truth[0]);
        } else if truth.len() != channels {
            return Err(Error::Scene {
                path: truth_path,
                message: "[medium] has three values, but the object image has one channel".into(),
            });
        }
        let z = path_lengths(&[(&observed.scene.geometry, &observed.scene.object[0].image)]).median;
        let whole = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
        let name = whole.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut set = Self { name, observed, truth, z, counted: Vec::new(), light: Vec::new() };
        for (channel, pixel, light) in set.light_that_counts()? {
            set.counted.push((channel, pixel));
            set.light.push(light);
        }
        if set.compare(set.light.iter().map(|o| o.value).collect()).is_none() {
            let what = format!("{}: its light is not above its noise", set.scene().path.display());
            return Err(Error::NothingToFit(what));
        }
        Ok(set)
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.observed.scene
    }

    /// Channel, index and object light of the pixels that count.
    fn light_that_counts(&self) -> Result<Vec<(usize, usize, Estimate)>> {
        let o = &self.observed.observation;
        let refuse = |why: &str| {
            let message = format!("[observation] {why}: without, the error of a render is not known");
            Error::Scene { path: self.scene().path.clone(), message }
        };
        let Gain::Fixed(gain) = o.gain else { return Err(refuse("gain must be a number")) };
        if matches!(o.veil, Veil::Free(_)) {
            return Err(refuse("veil must be a number or an image"));
        }
        let variances =
            variances(o)?.ok_or_else(|| refuse("noise is missing, and so is a channel of variance"))?;
        let relief = Filter::Auto.relief(&self.scene().geometry);
        let mut light = Vec::new();
        for (c, channel) in o.image.iter().enumerate() {
            let optics = self.optics(Model::SmallAngle, c);
            let hidden = hidden_share(&self.target(c, relief.as_ref()), &optics, Backend::Cpu)?;
            for (i, &value) in channel.image.data.iter().enumerate() {
                let masked = o.mask.as_ref().is_some_and(|mask| mask.data[i] <= 0.0);
                if masked || f64::from(hidden.data[i]) > o.hidden_share_max {
                    continue;
                }
                let veil = match &o.veil {
                    Veil::Image(veil) => f64::from(veil[c].image.data[i]),
                    Veil::Fixed(veil) => *veil,
                    Veil::Free(_) | Veil::Auto => 0.0,
                };
                let seen = Estimate {
                    value: (f64::from(value) - veil) / gain,
                    std_error: f64::from(variances[c].image.data[i]).sqrt() / gain,
                };
                light.push((c, i, seen));
            }
        }
        Ok(light)
    }

    /// The optics of `model` in the medium of channel `c`.
    pub(super) fn optics(&self, model: Model, c: usize) -> Optics {
        Optics { model, medium: self.truth[c] }
    }

    /// Channel `c` of the object.
    pub(super) fn target<'a>(&'a self, c: usize, relief: Option<&'a Relief>) -> Target<'a> {
        Target {
            radiance: &self.scene().object[c].image,
            behind: &self.scene().behind[c],
            geometry: &self.scene().geometry,
            border: self.scene().border,
            sampling: Sampling::Pixel,
            view: self.scene().view,
            relief,
        }
    }

    /// Pixels that count, over all channels.
    pub fn pixels(&self) -> usize {
        self.counted.len()
    }

    /// The error of a render, one image per channel, relative to the root mean square of the observed light.
    pub fn error_of(&self, render: &[Image]) -> RmsError {
        let pixels = self.counted.iter().map(|&(c, i)| f64::from(render[c].data[i]));
        self.compare(pixels.collect()).expect("there is light: checked on reading")
    }

    /// The error that a perfect render shows because of the noise of the observation, at one standard deviation of its square.
    pub fn floor(&self) -> f64 {
        let perfect = self.compare(self.light.iter().map(|o| o.value).collect());
        perfect.expect("there is light: checked on reading").error.std_error
    }

    fn compare(&self, render: Vec<f64>) -> Option<RmsError> {
        rms_error(&render, &self.light, None)
    }
}

/// The variance of every pixel of the observation: its file's channels `.variance`, or else the noise that the scene states.
fn variances(observation: &Observation) -> Result<Option<Vec<Channel>>> {
    let names: Vec<String> = observation.image.iter().map(|c| format!("{}.variance", c.name)).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let variances = match ExrFile::read(&observation.path)?.channels(&names) {
        Err(Error::MissingChannel { .. }) => {
            let uniform = |level: f64, c: &Channel| Channel {
                name: format!("{}.variance", c.name),
                image: Image::filled(c.image.width, c.image.height, (level * level) as f32),
            };
            let variances = |noise: &Noise| match noise {
                Noise::Level(level) => observation.image.iter().map(|c| uniform(*level, c)).collect(),
                Noise::Sensor { read, shot } => {
                    let of = |v: &f32| (read * read + shot * shot * f64::from(v.max(0.0))) as f32;
                    let sensor = |c: &Channel| Channel {
                        name: format!("{}.variance", c.name),
                        image: Image { data: c.image.data.iter().map(of).collect(), ..c.image },
                    };
                    observation.image.iter().map(sensor).collect()
                }
                Noise::Variance(variances) => variances.clone(),
            };
            return Ok(observation.noise.as_ref().map(variances));
        }
        read => read?,
    };
    for Channel { name, image } in &variances {
        if let Some(i) = image.data.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            return Err(Error::BadPixel {
                path: observation.path.clone(),
                channel: name.clone(),
                x: i % image.width,
                y: i / image.width,
                value: image.data[i].into(),
                allowed: "finite and at least 0",
            });
        }
    }
    Ok(Some(variances))
}
