//! Which channel of a file is the depth.
//!
//! In this order: `Z`; a bare channel named like a depth (`depth`, `zDepth`, `V`); a channel of a layer named so
//! (`ViewLayer.Depth.Z` or `.V` by Blender, `depth.T` and `VRayZDepth.R` by others); `*.T`, as Mitsuba's AOVs have it
//! (`dd.T`, `dd.y.T`); `*.Z` of a layer that is no vector; `Y`; `R` where `G` and `B` are the same.

use super::ExrFile;
use crate::error::{Error, Result};
use crate::image::Channel;

/// Names of depths, without case and separators.
const DEPTHS: [&str; 5] = ["depth", "zdepth", "vrayzdepth", "depthz", "distance"];
/// What the channel of a depth is called in its layer, the likeliest first.
const IN_LAYER: [&str; 5] = ["Z", "V", "T", "Y", "R"];

impl ExrFile {
    /// Distance, planar or along the ray.
    ///
    /// # Errors
    /// [`Error::MissingChannel`] with the names present; [`Error::Ambiguous`] if several channels may be meant.
    pub fn depth(&self) -> Result<Channel> {
        let rules: [&dyn Fn(&str) -> bool; 7] = [
            &|name| name == "Z",
            &|name| name == "V" || is_depth(name),
            &|name| self.is_in_depth_layer(name),
            &|name| name.ends_with(".T") && !self.is_vector(name),
            &|name| name.ends_with(".Z") && !self.is_vector(name),
            &|name| name == "Y",
            &|name| name == "R",
        ];
        for rule in rules {
            let found: Vec<&Channel> = self.all.iter().filter(|c| rule(&c.name)).collect();
            match found[..] {
                [] => (),
                [channel] => return self.grey(channel).cloned(),
                _ => {
                    let names: Vec<&str> = found.iter().map(|c| c.name.as_str()).collect();
                    return Err(self.ambiguous("a depth", &names, "depth_channel"));
                }
            }
        }
        Err(self.missing("Z, Y, depth.*, *.T or *.Z"))
    }

    /// Whether channel `name` is the likeliest of a layer named like a depth.
    fn is_in_depth_layer(&self, name: &str) -> bool {
        let Some((layer, _)) = name.rsplit_once('.').filter(|(layer, _)| is_depth_layer(layer)) else {
            return false;
        };
        let mut likeliest = IN_LAYER.iter().map(|own| format!("{layer}.{own}"));
        likeliest.find(|own| self.find(own).is_some()).is_some_and(|own| own == name)
    }

    /// `channel`, if it is not one of three that differ.
    fn grey<'c>(&'c self, channel: &'c Channel) -> Result<&'c Channel> {
        let Some(prefix) = channel.name.strip_suffix('R').filter(|p| p.is_empty() || p.ends_with('.')) else {
            return Ok(channel);
        };
        let others = ["G", "B"].map(|name| self.find(&format!("{prefix}{name}")));
        let same = |other: &Channel| {
            let pairs = other.image.data.iter().zip(&channel.image.data);
            other.image.data.len() == channel.image.data.len() && { pairs }
                .all(|(a, b)| a.to_bits() == b.to_bits())
        };
        if others.into_iter().flatten().all(same) {
            return Ok(channel);
        }
        Err(Error::MissingChannel {
            path: self.path.clone(),
            wanted: format!("of a depth: {prefix}R, {prefix}G and {prefix}B differ"),
            found: self.all.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }
}

/// Whether the last part of this layer's name is that of a depth.
pub(super) fn is_depth_layer(layer: &str) -> bool {
    layer.rsplit('.').next().is_some_and(is_depth)
}

fn is_depth(name: &str) -> bool {
    let letters: String = name.chars().filter(|c| !matches!(c, '_' | '-' | ' ')).collect();
    DEPTHS.contains(&letters.to_ascii_lowercase().as_str())
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

    #[test]
    fn depth_is_found_under_the_names_that_renderers_give_it() {
        let depth = |names: &[&str]| file(names).depth().map(|c| c.name).ok();
        for name in [
            "Z",
            "Y",
            "V",
            "depth",
            "zDepth",
            "Z_Depth",
            "depth.T",
            "depth.Y",
            "dd.T",
            "dd.y.T",
            "ViewLayer.Depth.Z",
            "ViewLayer.Depth.V",
            "VRayZDepth.R",
            "View Layer.Depth.Z",
            "mist.Z",
        ] {
            assert_eq!(depth(&["B", "G", "R", name]).as_deref(), Some(name));
        }
        assert_eq!(depth(&["Y", "depth.T"]).as_deref(), Some("depth.T"));
        assert_eq!(depth(&["v.Normal.X", "v.Normal.Y", "v.Normal.Z"]), None);
    }

    #[test]
    fn red_is_a_depth_where_green_and_blue_are_the_same() {
        let mut grey = file(&["B", "G", "R"]);
        let message = grey.depth().unwrap_err().to_string();
        assert!(message.contains("R, G and B differ"), "{message}");
        grey.all.iter_mut().for_each(|channel| channel.image.data[0] = 3.0);
        assert_eq!(grey.depth().unwrap().name, "R");
    }

    #[test]
    fn of_several_depths_one_has_to_be_picked() {
        let file = file(&["Clear.Depth.Z", "Fog.Depth.Z"]);
        let message = file.depth().unwrap_err().to_string();
        assert_eq!(
            message,
            "a.exr: several layers hold a depth: Clear.Depth.Z, Fog.Depth.Z; say which by the key depth_channel"
        );
    }
}
