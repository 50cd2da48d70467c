//! `[[object.layer]]`: known surfaces behind the object, nearest first.

use super::format::{DepthKind, ObjectSection};
use super::images::{ObjectImage, along_rays, as_the_object, check_radiance, depth, pick};
use super::light::LightReader;
use super::source::Source;
use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::image::Image;

/// Puts the layers' distances behind those of `geometry`, and returns for each of the object's channels the clear
/// radiance of each layer.
pub(super) fn read_layers(
    source: &Source,
    section: &ObjectSection,
    object: &ObjectImage,
    geometry: &mut Geometry,
) -> Result<Vec<Vec<Image>>> {
    let names: Vec<&str> = object.channels.iter().map(|c| c.name.as_str()).collect();
    let mut behind = vec![Vec::new(); object.channels.len()];
    let reader = LightReader::new(source, "[object]", section.transfer.as_ref())?;
    for (i, layer) in section.layer.iter().enumerate() {
        let path = source.resolve(&layer.radiance);
        let section_name = format!("[[object.layer]] {}", i + 1);
        let pick = pick(source, &section_name, &layer.layer_name, &layer.channels)?;
        let file = reader.read(&path)?.file;
        let channels = file.picked(&names, &pick).map_err(|e| e.since(|| as_the_object(&names)))?;
        for channel in &channels {
            object.frame().check(&path, &channel.image, "the object image")?;
        }
        check_radiance(&path, &channels)?;
        behind.iter_mut().zip(channels).for_each(|(images, channel)| images.push(channel.image));

        let key = format!("{section_name} depth");
        let named = layer.depth_channel.as_deref();
        let depth = depth(source, &key, (&layer.depth, section.depth_scale, named), &object.frame())?;
        let distance = match section.depth_kind {
            DepthKind::Ray => depth.field,
            DepthKind::Planar => along_rays(geometry, &depth.field),
        };
        geometry.behind.push(distance);
        let culprit = depth.path.unwrap_or_else(|| source.path.to_path_buf());
        geometry.check_behind(i).map_err(|e| Error::Scene { path: culprit, message: e.to_string() })?;
    }
    Ok(behind)
}
