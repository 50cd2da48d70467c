//! Which channels of a file are meant.
//!
//! Radiance: `Y`, else `R`, `G`, `B`, else those names behind one layer prefix (`Combined.R`). Mask and surface: `Y`, else `Z`,
//! else the only channel. Layers that also have an `X` are vectors (normals, positions) and never taken. Other channels (`A`,
//! `Y.variance`) are ignored. Where several layers would serve, none is taken: a [`Pick`] says which.

use super::ExrFile;
use super::depth::is_depth_layer;
use crate::error::{Error, Result};
use crate::image::Channel;

const RGB: [&str; 3] = ["R", "G", "B"];

/// The layer in which Blender puts the picture itself, chosen where several layers hold R, G, B.
const MAIN_LAYER: &str = "Combined";

/// What the user says about which channels are meant; nothing by default.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Pick {
    /// Prefix of their names.
    pub layer: Option<String>,
    /// Their names behind it: one, or three for R, G, B.
    pub channels: Option<Vec<String>>,
}

impl ExrFile {
    /// Radiance: one channel `Y`, or three, `R`, `G`, `B`, in this order and under these names.
    ///
    /// # Errors
    /// [`Error::MissingChannel`] with the names present; [`Error::Ambiguous`] if several layers hold them.
    pub fn radiance(&self) -> Result<Vec<Channel>> {
        self.picked_radiance(&Pick::default())
    }

    /// The same of what is picked.
    ///
    /// # Errors
    /// As [`radiance`](Self::radiance).
    pub fn picked_radiance(&self, pick: &Pick) -> Result<Vec<Channel>> {
        match &pick.channels {
            Some(picked) if picked.len() == 1 => self.picked(&["Y"], pick),
            Some(_) => self.picked(&RGB, pick),
            None => {
                let file = self.within(pick)?;
                let plain = file.under("", &["Y"]).or_else(|| file.under("", &RGB));
                let found = match plain {
                    Some(plain) => Some(plain),
                    None => match file.in_layer(&RGB)? {
                        Some(layered) => Some(layered),
                        None => file.in_layer(&["Y"])?,
                    },
                };
                found.ok_or_else(|| self.missing("Y, nor R, G and B"))
            }
        }
    }

    /// The channels `names`, such as those of another image, bare or behind one layer prefix; if channels are picked, those, under
    /// these names.
    ///
    /// # Errors
    /// As [`radiance`](Self::radiance).
    pub fn picked(&self, names: &[&str], pick: &Pick) -> Result<Vec<Channel>> {
        let file = self.within(pick)?;
        let Some(picked) = &pick.channels else {
            let found = match file.under("", names) {
                Some(found) => Some(found),
                None => file.in_layer(names)?,
            };
            return found.ok_or_else(|| self.missing(&names.join(", ")));
        };
        if picked.len() != names.len() {
            return Err(self.missing(&format!(
                "for each of {}: channels picks {}",
                names.join(", "),
                picked.join(", ")
            )));
        }
        let channel = |(name, picked): (&&str, &String)| {
            let found = file.named(picked).map_err(|_| self.missing(picked))?;
            Ok(Channel { name: name.to_string(), ..found })
        };
        names.iter().zip(picked).map(channel).collect()
    }

    /// Exactly the channels `names`, bare or behind one layer prefix.
    ///
    /// # Errors
    /// As [`radiance`](Self::radiance).
    pub fn channels(&self, names: &[&str]) -> Result<Vec<Channel>> {
        self.picked(names, &Pick::default())
    }

    /// The only channel of interest: a mask, or the surface of the medium.
    ///
    /// # Errors
    /// [`Error::MissingChannel`] with the names present.
    pub fn single(&self) -> Result<Channel> {
        let only = || self.all.first().filter(|_| self.all.len() == 1);
        let found = self.find("Y").or_else(|| self.find("Z")).or_else(only);
        found.cloned().ok_or_else(|| self.missing("Y or Z, nor is there only one"))
    }

    /// The channel of exactly this name (`Y.variance`, say).
    ///
    /// # Errors
    /// [`Error::MissingChannel`] with the names present.
    pub fn named(&self, name: &str) -> Result<Channel> {
        self.find(name).cloned().ok_or_else(|| self.missing(name))
    }

    pub(super) fn find(&self, name: &str) -> Option<&Channel> {
        self.all.iter().find(|c| c.name == name)
    }

    /// The channels behind the picked prefix, without it.
    fn within(&self, pick: &Pick) -> Result<Self> {
        let Some(layer) = &pick.layer else { return Ok(self.clone()) };
        let prefix = format!("{layer}.");
        let strip = |c: &Channel| {
            let name = c.name.strip_prefix(&prefix)?.to_string();
            Some(Channel { name, image: c.image.clone() })
        };
        let all: Vec<Channel> = self.all.iter().filter_map(strip).collect();
        if all.is_empty() {
            return Err(self.missing(&format!("of the layer {layer}")));
        }
        Ok(Self { path: self.path.clone(), all })
    }

    /// All of `names` behind `prefix`, renamed without it.
    fn under(&self, prefix: &str, names: &[&str]) -> Option<Vec<Channel>> {
        let rename = |name: &&str| {
            let channel = self.find(&format!("{prefix}{name}"))?;
            Some(Channel { name: name.to_string(), image: channel.image.clone() })
        };
        names.iter().map(rename).collect()
    }

    /// All of `names` in the one layer that has them, or in the main one of several.
    fn in_layer(&self, names: &[&str]) -> Result<Option<Vec<Channel>>> {
        let suffix = format!(".{}", names[0]);
        let layers: Vec<&str> = self
            .all
            .iter()
            .filter_map(|c| c.name.strip_suffix(&suffix))
            .filter(|layer| names[1..].iter().all(|n| self.find(&format!("{layer}.{n}")).is_some()))
            .filter(|layer| !self.is_vector(&format!("{layer}{suffix}")) && !is_depth_layer(layer))
            .collect();
        let is_main = |layer: &&&str| layer.rsplit('.').next() == Some(MAIN_LAYER);
        let main: Vec<&str> = layers.iter().filter(is_main).copied().collect();
        let meant = if main.is_empty() { &layers } else { &main };
        match meant[..] {
            [] => Ok(None),
            [layer] => Ok(self.under(&format!("{layer}."), names)),
            // Of several none is meant more than the others.
            _ => Err(self.ambiguous(&names.join(", "), meant, "layer_name")),
        }
    }

    /// Whether the layer of channel `name` also holds an `X`.
    pub(super) fn is_vector(&self, name: &str) -> bool {
        name.rsplit_once('.').is_some_and(|(layer, _)| self.find(&format!("{layer}.X")).is_some())
    }

    pub(super) fn missing(&self, wanted: &str) -> Error {
        let names: Vec<&str> = self.all.iter().map(|c| c.name.as_str()).collect();
        Error::MissingChannel { path: self.path.clone(), wanted: wanted.into(), found: names.join(", ") }
    }

    pub(super) fn ambiguous(&self, wanted: &str, among: &[&str], key: &'static str) -> Error {
        let (path, wanted, among) = (self.path.clone(), wanted.into(), among.join(", "));
        Error::Ambiguous { path, wanted, among, key }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    fn file(names: &[&str]) -> ExrFile {
        let channel = |(i, name): (usize, &&str)| Channel {
            name: name.to_string(),
            image: Image::filled(1, 1, i as f32),
        };
        ExrFile { path: "a.exr".into(), all: names.iter().enumerate().map(channel).collect() }
    }

    fn radiance(names: &[&str]) -> Option<Vec<(String, f32)>> {
        let channels = file(names).radiance().ok()?;
        Some(channels.iter().map(|c| (c.name.clone(), c.image.at(0, 0))).collect())
    }

    fn rgb(values: [f32; 3]) -> Option<Vec<(String, f32)>> {
        Some(RGB.iter().map(|n| n.to_string()).zip(values).collect())
    }

    #[test]
    fn radiance_is_y_or_r_g_b_in_this_order() {
        assert_eq!(radiance(&["Y", "Y.variance"]), Some(vec![("Y".into(), 0.0)]));
        assert_eq!(radiance(&["A", "B", "G", "R", "Z"]), rgb([3.0, 2.0, 1.0]));
        assert_eq!(radiance(&["B", "G"]), None);
        assert_eq!(radiance(&["depth.Y"]), None);
    }

    #[test]
    fn radiance_is_found_in_the_main_layer() {
        assert_eq!(radiance(&["a.B", "a.G", "a.R", "n.X", "n.Y", "n.Z"]), rgb([2.0, 1.0, 0.0]));
        assert_eq!(radiance(&["a.B", "a.G", "a.R", "v.Combined.B", "v.Combined.G", "v.Combined.R"]), {
            rgb([5.0, 4.0, 3.0])
        });
        assert_eq!(radiance(&["a.B", "a.G", "a.R", "b.B", "b.G", "b.R"]), None);
        let views =
            ["Clear.Combined", "Fog.Combined"].map(|view| ["B", "G", "R"].map(|c| format!("{view}.{c}")));
        let views: Vec<&str> = views.iter().flatten().map(String::as_str).collect();
        assert_eq!(radiance(&views), None);
    }

    #[test]
    fn a_picked_layer_or_channel_is_taken() {
        let views =
            ["Clear.Combined", "Fog.Combined"].map(|view| ["B", "G", "R"].map(|c| format!("{view}.{c}")));
        let views: Vec<&str> = views.iter().flatten().map(String::as_str).collect();
        let values = |pick: &Pick| {
            let channels = file(&views).picked_radiance(pick)?;
            Ok::<_, Error>(channels.iter().map(|c| (c.name.clone(), c.image.at(0, 0))).collect::<Vec<_>>())
        };
        let pick = |layer: Option<&str>, channels: Option<&[&str]>| Pick {
            layer: layer.map(str::to_string),
            channels: channels.map(|names| names.iter().map(|name| name.to_string()).collect()),
        };
        assert_eq!(values(&pick(Some("Fog"), None)).ok(), rgb([5.0, 4.0, 3.0]));
        assert_eq!(values(&pick(Some("Clear.Combined"), Some(&["R", "G", "B"]))).ok(), rgb([2.0, 1.0, 0.0]));
        assert_eq!(values(&pick(None, Some(&["Fog.Combined.G"]))).ok(), Some(vec![("Y".into(), 4.0)]));
        let message = values(&pick(None, None)).unwrap_err().to_string();
        assert_eq!(
            message,
            "a.exr: several layers hold R, G, B: Clear.Combined, Fog.Combined; say which by the key layer_name"
        );
        for (pick, words) in [
            (pick(Some("Mist"), None), "no channel of the layer Mist"),
            (pick(None, Some(&["Fog.Y"])), "no channel Fog.Y"),
            (pick(Some("Fog"), Some(&["Combined.R", "Combined.G"])), "channels picks Combined.R, Combined.G"),
        ] {
            let message = values(&pick).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
    }

    #[test]
    fn a_mask_may_be_the_only_channel() {
        assert_eq!(file(&["alpha"]).single().unwrap().name, "alpha");
        assert!(file(&["B", "G", "R"]).single().is_err());
    }

    #[test]
    fn a_missing_channel_is_reported_with_those_present() {
        let message = file(&["B", "G"]).radiance().unwrap_err().to_string();
        assert_eq!(message, "a.exr: has no channel Y, nor R, G and B; it holds B, G");
    }
}
