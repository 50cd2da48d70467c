//! Which channel of a file is meant.
//!
//! Radiance: `Y`, else `R`, `G`, `B`, else those names behind one layer prefix (`Combined.R`). Depth: `Z`, else
//! `Y`, else a channel of a layer named depth (`depth.T`, `ViewLayer.Depth.Z`), else `*.Z` of a layer that is not
//! a vector. Mask and surface: `Y`, else `Z`, else the only channel. Layers that also have an `X` are vectors
//! (normals, positions) and never taken. Other channels (`A`, `Y.variance`) are ignored.

use super::ExrFile;
use crate::error::{Error, Result};
use crate::image::Channel;

const RGB: [&str; 3] = ["R", "G", "B"];

/// The layer in which Blender puts the picture itself, chosen where several layers hold R, G, B.
const MAIN_LAYER: &str = "Combined";

impl ExrFile {
    /// Radiance: one channel `Y`, or three, `R`, `G`, `B`, in this order and under these names.
    ///
    /// # Errors
    /// [`Error::MissingChannel`] with the names present.
    pub fn radiance(&self) -> Result<Vec<Channel>> {
        let plain = self.under("", &["Y"]).or_else(|| self.under("", &RGB));
        let layered = || self.in_layer(&RGB).or_else(|| self.in_layer(&["Y"]));
        plain.or_else(layered).ok_or_else(|| {
            self.missing("Y, nor R, G and B of one layer that is the only one, or the only main one")
        })
    }

    /// Exactly the channels `names`, such as those of another image, bare or behind one layer prefix.
    ///
    /// # Errors
    /// [`Error::MissingChannel`] with the names present.
    pub fn channels(&self, names: &[&str]) -> Result<Vec<Channel>> {
        let found = self.under("", names).or_else(|| self.in_layer(names));
        found.ok_or_else(|| self.missing(&names.join(", ")))
    }

    /// Distance, planar or along the ray.
    ///
    /// # Errors
    /// [`Error::MissingChannel`] with the names present.
    pub fn depth(&self) -> Result<Channel> {
        let by_layer = || self.all.iter().find(|c| in_depth_layer(&c.name));
        let by_suffix = || self.all.iter().find(|c| c.name.ends_with(".Z") && !self.is_vector(&c.name));
        let found = self.find("Z").or_else(|| self.find("Y")).or_else(by_layer).or_else(by_suffix);
        found.cloned().ok_or_else(|| self.missing("Z, Y, depth.* or *.Z"))
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

    fn find(&self, name: &str) -> Option<&Channel> {
        self.all.iter().find(|c| c.name == name)
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
    fn in_layer(&self, names: &[&str]) -> Option<Vec<Channel>> {
        let suffix = format!(".{}", names[0]);
        let layers: Vec<&str> = self
            .all
            .iter()
            .filter_map(|c| c.name.strip_suffix(&suffix))
            .filter(|layer| names[1..].iter().all(|n| self.find(&format!("{layer}.{n}")).is_some()))
            .filter(|layer| {
                !self.is_vector(&format!("{layer}{suffix}")) && !in_depth_layer(&format!("{layer}."))
            })
            .collect();
        let mut main = layers.iter().filter(|layer| layer.rsplit('.').next() == Some(MAIN_LAYER));
        // Of several main layers none is meant more than the others.
        let layer =
            if layers.len() == 1 { layers.first() } else { main.next().filter(|_| main.next().is_none()) };
        layer.and_then(|layer| self.under(&format!("{layer}."), names))
    }

    /// Whether the layer of channel `name` also holds an `X`.
    fn is_vector(&self, name: &str) -> bool {
        name.rsplit_once('.').is_some_and(|(layer, _)| self.find(&format!("{layer}.X")).is_some())
    }

    fn missing(&self, wanted: &str) -> Error {
        let names: Vec<&str> = self.all.iter().map(|c| c.name.as_str()).collect();
        Error::MissingChannel { path: self.path.clone(), wanted: wanted.into(), found: names.join(", ") }
    }
}

/// Whether the channel's last layer is named `depth`, in any case.
fn in_depth_layer(name: &str) -> bool {
    name.rsplit('.').nth(1).is_some_and(|layer| layer.eq_ignore_ascii_case("depth"))
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
    fn depth_is_found_under_the_names_that_renderers_give_it() {
        let depth = |names: &[&str]| file(names).depth().map(|c| c.name).ok();
        for name in ["Z", "Y", "depth.T", "depth.Y", "ViewLayer.Depth.Z", "ViewLayer.Depth.V", "mist.Z"] {
            assert_eq!(depth(&["B", "G", "R", name]).as_deref(), Some(name));
        }
        assert_eq!(depth(&["v.Normal.X", "v.Normal.Y", "v.Normal.Z"]), None);
        assert_eq!(depth(&["B", "G", "R"]), None);
    }

    #[test]
    fn a_mask_may_be_the_only_channel() {
        assert_eq!(file(&["alpha"]).single().unwrap().name, "alpha");
        assert!(file(&["B", "G", "R"]).single().is_err());
    }

    #[test]
    fn a_missing_channel_is_reported_with_those_present() {
        let message = file(&["B", "G"]).radiance().unwrap_err().to_string();
        assert_eq!(
            message,
            "a.exr: has no channel Y, nor R, G and B of one layer that is the only one, or the only main one; it holds B, G"
        );
    }
}
