//! `[illumination]`, and the object that lies in its light.

use super::format::{IlluminationSection, Numbers, ObjectSection};
use super::images::{check_pixels, check_radiance, check_size, radiance};
use super::medium::channel_value;
use super::source::Source;
use super::{Illumination, Purpose};
use crate::error::Result;
use crate::geometry::Geometry;
use crate::illumination::{Bottom, Shading, Sun};
use crate::image::{Channel, View};
use crate::io::exr::ExrFile;
use glam::DVec3;
use std::path::{Path, PathBuf};

/// The object image: its radiances, or its reflectances and how they are lit.
pub(super) struct Object {
    pub path: PathBuf,
    pub channels: Vec<Channel>,
    pub shading: Option<Shading>,
}

/// Reads `[object] radiance`, or `reflectance` and `shading`.
pub(super) fn read_object(source: &Source, section: &ObjectSection, purpose: Purpose) -> Result<Object> {
    match (&section.radiance, &section.reflectance) {
        (Some(_), Some(_)) => Err(source.error("[object] radiance and reflectance are both given: leave one")),
        (None, None) => Err(source.error("[object] radiance is missing")),
        (Some(_), None) if section.shading.is_some() => {
            Err(source.error("[object] shading is given, but no reflectance"))
        }
        (Some(named), None) => {
            let path = source.resolve(named);
            Ok(Object { channels: radiance(&path)?, path, shading: None })
        }
        (None, Some(_)) if purpose != Purpose::Synthesize => Err(source.error(
            "[object] radiance is missing: only synthesize takes a reflectance, which the medium's light lights",
        )),
        (None, Some(_)) if !section.layer.is_empty() => {
            Err(source.error("[[object.layer]] is given, but [object] reflectance has no layers"))
        }
        (None, Some(named)) => {
            let path = source.resolve(named);
            let channels = ExrFile::read(&path)?.radiance()?;
            for channel in &channels {
                check_pixels(&path, channel, "between 0 and 1, a reflectance", |v| (0.0..=1.0).contains(&v))?;
            }
            let shading = match &section.shading {
                None => Shading::FromDepth,
                Some(named) => read_shading(source.resolve(named), &path, &channels[0])?,
            };
            Ok(Object { path, channels, shading: Some(shading) })
        }
    }
}

fn read_shading(path: PathBuf, object_path: &Path, object: &Channel) -> Result<Shading> {
    let channel = ExrFile::read(&path)?.single()?;
    let size = (object.image.width, object.image.height);
    check_size(&path, &channel.image, size, &format!("the object image {}", object_path.display()))?;
    check_pixels(&path, &channel, "between 0 and 1", |v| (0.0..=1.0).contains(&v))?;
    Ok(Shading::Map(channel.image))
}

/// Reads `[illumination]` for `object` at `geometry`; `lit`: whether it lends the object its light.
pub(super) fn read_illumination(
    source: &Source,
    section: Option<&IlluminationSection>,
    object: &[Channel],
    (geometry, view): (&Geometry, View),
    lit: bool,
) -> Result<Illumination> {
    let Some(section) = section else {
        return Err(
            source.error("section [illumination] is missing: synthesize needs its image or direction")
        );
    };
    match (&section.image, section.direction) {
        (Some(_), Some(_)) => {
            Err(source.error("[illumination] image and direction are both given: leave one"))
        }
        (None, None) => Err(source.error("[illumination] image or direction is missing")),
        (Some(_), None) if lit => Err(source.error(
            "[illumination] image does not say how the object is lit: give [object] radiance, or a direction",
        )),
        (Some(named), None) => {
            for (key, given) in [
                ("irradiance", section.irradiance.is_some()),
                ("normal", section.normal.is_some()),
                ("bottom", section.bottom.is_some()),
                ("bottom_reflectance", section.bottom_reflectance.is_some()),
            ] {
                if given {
                    return Err(
                        source.error(format!("[illumination] {key} is given, but belongs to a direction"))
                    );
                }
            }
            let path = source.resolve(named);
            let names: Vec<&str> = object.iter().map(|c| c.name.as_str()).collect();
            let channels = ExrFile::read(&path)?.channels(&names)?;
            for channel in &channels {
                check_size(
                    &path,
                    &channel.image,
                    (view.width, view.height),
                    "[illumination] image: the view",
                )?;
            }
            check_radiance(&path, &channels)?;
            Ok(Illumination::Veil(channels))
        }
        (None, Some(direction)) => parallel(source, section, direction, object.len(), geometry),
    }
}

fn parallel(
    source: &Source,
    section: &IlluminationSection,
    direction: [f64; 3],
    channels: usize,
    geometry: &Geometry,
) -> Result<Illumination> {
    let named = |e: crate::Error| source.error(format!("[illumination] {e}"));
    let normal = section.normal.map_or(DVec3::NEG_Z, DVec3::from_array);
    let sun = Sun::new(DVec3::from_array(direction), normal).map_err(named)?;
    let value =
        |key: &str, numbers: Option<Numbers>, i: usize| channel_value(source, key, numbers, i, channels);
    let mut irradiance = Vec::new();
    let mut bottom = Vec::new();
    for i in 0..channels {
        let key = "[illumination] irradiance";
        let given =
            value(key, section.irradiance, i)?.ok_or_else(|| source.error(format!("{key} is missing")))?;
        irradiance.push(source.non_negative(key, given)?);
        let reflectance = value("[illumination] bottom_reflectance", section.bottom_reflectance, i)?;
        bottom.push(match (section.bottom, reflectance) {
            (Some(depth), reflectance) => Bottom::new(depth, reflectance.unwrap_or(0.0)).map_err(named)?,
            (None, Some(_)) => {
                return Err(source.error("[illumination] bottom is missing: bottom_reflectance is given"));
            }
            (None, None) => Bottom::NONE,
        });
    }
    check_rays(source, sun, bottom[0].depth(), geometry)?;
    Ok(Illumination::Parallel { sun, irradiance, bottom })
}

/// By which share of the bottom's depth an object may lie below it: roundings of f32 depth maps, and a depth typed in.
const BELOW_BOTTOM: f64 = 1e-3;

/// Refuses rays that never enter the medium through the light's surface, and objects below the bottom.
fn check_rays(source: &Source, sun: Sun, bottom: f64, geometry: &Geometry) -> Result<()> {
    for (x, y) in (0..geometry.height).flat_map(|y| (0..geometry.width).map(move |x| (x, y))) {
        let mu = -geometry.ray_direction(x, y).dot(sun.normal());
        if mu <= 0.0 {
            return Err(source.error(format!(
                "[illumination] normal: the ray of pixel ({x}, {y}) never enters that surface"
            )));
        }
        if let Some(z) = geometry.path_length(x, y).filter(|z| z * mu > bottom * (1.0 + BELOW_BOTTOM)) {
            let h = z * mu;
            return Err(source.error(format!(
                "[illumination] bottom = {bottom}: the object at pixel ({x}, {y}) lies at depth {h}, below it"
            )));
        }
    }
    Ok(())
}
