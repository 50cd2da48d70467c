//! The images that a scene names, each checked pixel by pixel.

use super::Caution;
use super::format::{NumberOrFile, ObjectSection};
use super::light::LightReader;
use super::numbers::lengths;
use super::source::{LARGEST, Source};
use crate::error::{Error, Result};
use crate::geometry::{Camera, FARTHEST, Field, Geometry};
use crate::image::{Channel, Image};
use crate::io::exr::Pick;
use crate::io::picture::Picture;
use std::path::{Path, PathBuf};

/// An image that determines the size of others.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame<'a> {
    /// Its file.
    pub path: &'a Path,
    /// Width and height, px.
    pub size: (usize, usize),
}

impl Frame<'_> {
    /// Refuses an image of the file `path` that is of another size than this one, which is `what`.
    pub fn check(&self, path: &Path, image: &Image, what: &str) -> Result<()> {
        check_size(path, image, self.size, &format!("{what} {}", self.path.display()))
    }
}

/// The object image.
pub(super) struct ObjectImage {
    pub path: PathBuf,
    pub channels: Vec<Channel>,
    /// Whether it was a photograph: codes, not radiance.
    pub is_photograph: bool,
    /// What a user should know of it.
    pub cautions: Vec<Caution>,
}

impl ObjectImage {
    pub fn frame(&self) -> Frame<'_> {
        let image = &self.channels[0].image;
        Frame { path: &self.path, size: (image.width, image.height) }
    }
}

/// Reads `[object] radiance`: finite, and not negative unless its noise is stated.
pub(super) fn read_radiance(source: &Source, section: &ObjectSection) -> Result<ObjectImage> {
    let named = match (&section.radiance, &section.reflectance) {
        (Some(_), Some(_)) => {
            return Err(source.error("[object] radiance and reflectance are both given: leave one"));
        }
        (None, None) => return Err(source.error("[object] radiance is missing")),
        (None, Some(_)) => {
            return Err(source.error(
                "[object] radiance is missing: only synthesize takes a reflectance, which the medium's light lights",
            ));
        }
        (Some(_), None) if section.shading.is_some() => {
            return Err(source.error("[object] shading is given, but no reflectance"));
        }
        (Some(named), None) => named,
    };
    let path = source.resolve(named);
    let pick = pick(source, "[object]", &section.layer_name, &section.channels)?;
    let light = LightReader::new(source, "[object]", section.transfer.as_ref())?.read_main(&path)?;
    let channels = light.file.picked_radiance(&pick)?;
    if section.noise.is_some() {
        let allowed = "finite, and at most 1e15; scale all images alike";
        channels
            .iter()
            .try_for_each(|channel| check_pixels(&path, channel, allowed, |v| v.abs() <= LARGEST as f32))?;
    } else {
        check_radiance(&path, &channels)?;
    }
    Ok(ObjectImage {
        path,
        channels,
        is_photograph: light.codes.is_some(),
        cautions: light.caution.into_iter().collect(),
    })
}

/// What `layer_name` and `channels` of this section say.
pub(super) fn pick(
    source: &Source,
    section: &str,
    layer: &Option<String>,
    channels: &Option<Vec<String>>,
) -> Result<Pick> {
    if let Some(names) = channels
        && !matches!(names.len(), 1 | 3)
    {
        return Err(source
            .error(format!("{section} channels names {}: must be one, or three for R, G, B", names.len())));
    }
    Ok(Pick { layer: layer.clone(), channels: channels.clone() })
}

/// Why an image must have the channels `names`.
pub(super) fn as_the_object(names: &[&str]) -> String {
    format!("the object has {}", names.join(", "))
}

/// Refuses the first pixel that is not finite or negative.
pub(super) fn check_radiance(path: &Path, channels: &[Channel]) -> Result<()> {
    channels.iter().try_for_each(|channel| {
        let ok = |v: f32| (0.0..=LARGEST as f32).contains(&v);
        check_pixels(path, channel, "at least 0 and at most 1e15; scale all images alike", ok)
    })
}

/// A distance and the file it came from, if any.
pub(super) struct Distance {
    pub field: Field,
    pub path: Option<PathBuf>,
}

/// The depth of the object or of a further layer, as `key` says: NaN is an error, and so is a number that means no
/// object. `object` is the object image.
pub(super) fn depth(
    source: &Source,
    key: &str,
    (value, scale, channel): (&NumberOrFile, Option<f64>, Option<&str>),
    object: &Frame,
) -> Result<Distance> {
    match value {
        NumberOrFile::Number(_) if channel.is_some() => {
            Err(source.error(format!("{key}_channel is given, but the depth is a number")))
        }
        NumberOrFile::Number(v) => {
            let ok = *v > 0.0 && *v <= FARTHEST;
            source.in_range(key, *v, ok, "above 0 and at most 1e9")?;
            Ok(Distance { field: Field::Uniform(*v), path: None })
        }
        NumberOrFile::File(named) => {
            let path = source.resolve(named);
            let channel = lengths(source, &path, scale, |picture| {
                channel.map_or_else(|| picture.file.depth(), |name| picture.file.named(name))
            })?;
            map(path, channel, object, "a distance (0 or infinite where there is no object)", |v| !v.is_nan())
        }
    }
}

/// `[object] surface`: at least 0; where there is no surface its pixels may be infinite.
pub(super) fn surface(
    source: &Source,
    (value, scale): (&NumberOrFile, Option<f64>),
    object: &Frame,
) -> Result<Distance> {
    match value {
        NumberOrFile::Number(v) => {
            source.non_negative("[object] surface", *v)?;
            Ok(Distance { field: Field::Uniform(*v), path: None })
        }
        NumberOrFile::File(named) => {
            let path = source.resolve(named);
            let channel = lengths(source, &path, scale, Picture::single)?;
            map(path, channel, object, "at least 0", |v| v >= 0.0)
        }
    }
}

fn map(
    path: PathBuf,
    channel: Channel,
    object: &Frame,
    allowed: &'static str,
    ok: impl Fn(f32) -> bool,
) -> Result<Distance> {
    object.check(&path, &channel.image, "the object image")?;
    check_pixels(&path, &channel, allowed, ok)?;
    Ok(Distance { field: Field::Map(channel.image), path: Some(path) })
}

/// Distances along the axis turned into distances along the rays of `geometry`'s camera: divided by the cosine of
/// the angle between the two. Empty pixels remain empty.
pub(super) fn along_rays(geometry: &Geometry, planar: &Field) -> Field {
    let same = matches!(geometry.camera, Camera::Orthographic { .. }) || *planar == Field::Uniform(0.0);
    if same {
        return planar.clone();
    }
    let convert = |x, y| (planar.at(x, y) / geometry.cos_off_axis(x, y)) as f32;
    Field::Map(Image::from_fn(geometry.width, geometry.height, convert))
}

/// Refuses an image that is not `size` (width, height) px, the size of `what`.
pub(super) fn check_size(path: &Path, image: &Image, size: (usize, usize), what: &str) -> Result<()> {
    if (image.width, image.height) == size {
        return Ok(());
    }
    let expected = format!("{what} is {}x{} px", size.0, size.1);
    Err(Error::WrongSize { path: path.into(), found: format!("{}x{}", image.width, image.height), expected })
}

/// Refuses the first pixel that is not `ok`, by name.
pub(super) fn check_pixels(
    path: &Path,
    channel: &Channel,
    allowed: &'static str,
    ok: impl Fn(f32) -> bool,
) -> Result<()> {
    match channel.image.data.iter().position(|&v| !ok(v)) {
        Some(i) => Err(Error::BadPixel {
            path: path.into(),
            channel: channel.name.clone(),
            x: i % channel.image.width,
            y: i / channel.image.width,
            value: f64::from(channel.image.data[i]),
            allowed,
        }),
        None => Ok(()),
    }
}
