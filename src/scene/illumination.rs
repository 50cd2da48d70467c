//! `[illumination]`, and the object that it lights.

use super::format::{IlluminationSection, ObjectSection};
use super::images::{ObjectImage, as_the_object, check_pixels, check_radiance, check_size, pick};
use super::light::LightReader;
use super::medium::ChannelOf;
use super::numbers::shares;
use super::source::Source;
use super::{Illumination, Scene};
use crate::error::Result;
use crate::geometry::Geometry;
use crate::illumination::{Bottom, Shading, Sun};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Reads `[object] reflectance`, the file `named`, and how it is lit.
pub(super) fn read_reflectance(
    source: &Source,
    section: &ObjectSection,
    named: &Path,
) -> Result<(ObjectImage, Shading)> {
    if !section.layer.is_empty() {
        return Err(source.error("[[object.layer]] is given, but [object] reflectance has no layers"));
    }
    let path = source.resolve(named);
    let pick = pick(source, "[object]", &section.layer_name, &section.channels)?;
    let light = LightReader::new(source, "[object]", section.transfer.as_ref())?.read_main(&path)?;
    let channels = light.file.picked_radiance(&pick)?;
    for channel in &channels {
        check_pixels(&path, channel, "between 0 and 1, a reflectance", |v| (0.0..=1.0).contains(&v))?;
    }
    let cautions = light.caution.into_iter().collect();
    let object = ObjectImage { path, channels, is_photograph: light.codes.is_some(), cautions };
    let shading = match &section.shading {
        None => Shading::FromDepth,
        Some(named) => read_shading(source.resolve(named), &object)?,
    };
    Ok((object, shading))
}

fn read_shading(path: PathBuf, object: &ObjectImage) -> Result<Shading> {
    let channel = shares(&path)?;
    object.frame().check(&path, &channel.image, "the object image")?;
    check_pixels(&path, &channel, "between 0 and 1", |v| (0.0..=1.0).contains(&v))?;
    Ok(Shading::Map(channel.image))
}

/// Reads `[illumination]` of `scene`; `lit`: whether it lights the object.
pub(super) fn read_illumination(
    source: &Source,
    section: Option<&IlluminationSection>,
    scene: &Scene,
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
            let names: Vec<&str> = scene.object.iter().map(|c| c.name.as_str()).collect();
            let reader = LightReader::new(source, "[illumination]", section.transfer.as_ref())?;
            let file = reader.read_main(&path)?.file;
            let channels = file.channels(&names).map_err(|e| e.since(|| as_the_object(&names)))?;
            for channel in &channels {
                let size = (scene.view.width, scene.view.height);
                check_size(&path, &channel.image, size, "[illumination] image: the view")?;
            }
            check_radiance(&path, &channels)?;
            Ok(Illumination::Veil(channels))
        }
        (None, Some(direction)) => parallel(source, section, direction, scene),
    }
}

fn parallel(
    source: &Source,
    section: &IlluminationSection,
    direction: [f64; 3],
    scene: &Scene,
) -> Result<Illumination> {
    let named = |e: crate::Error| source.error(format!("[illumination] {e}"));
    let normal = section.normal.map_or(DVec3::NEG_Z, DVec3::from_array);
    let sun = Sun::new(DVec3::from_array(direction), normal).map_err(named)?;
    let mut irradiance = Vec::new();
    let mut bottom = Vec::new();
    for index in 0..scene.object.len() {
        let channel = ChannelOf { source, index, count: scene.object.len() };
        let key = "[illumination] irradiance";
        let given = channel
            .value(key, section.irradiance)?
            .ok_or_else(|| source.error(format!("{key} is missing")))?;
        irradiance.push(source.non_negative(key, given)?);
        let reflectance = channel.value("[illumination] bottom_reflectance", section.bottom_reflectance)?;
        bottom.push(match (section.bottom, reflectance) {
            (Some(depth), reflectance) => Bottom::new(depth, reflectance.unwrap_or(0.0)).map_err(named)?,
            (None, Some(_)) => {
                return Err(source.error("[illumination] bottom is missing: bottom_reflectance is given"));
            }
            (None, None) => Bottom::NONE,
        });
    }
    check_rays(source, sun, bottom[0].depth(), &scene.geometry)?;
    Ok(Illumination::Parallel { sun, irradiance, bottom })
}

/// Relative depth by which an object may lie below the bottom: rounding of f32 depth maps and of depths typed in.
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
