//! `[[object.layer]]`: what is known to lie behind the object, nearest first.

use super::format::{DepthKind, LayerSection};
use super::images::{along_rays, check_radiance, check_size, depth};
use super::source::Source;
use crate::error::{Error, Result};
use crate::geometry::Geometry;
use crate::image::{Channel, Image};
use crate::io::exr::ExrFile;
use std::path::Path;

/// Puts the layers' distances behind those of `geometry`, and returns for each of the object's channels the clear
/// radiance of each layer. `object` is the object image with its path.
pub(super) fn read_layers(
    source: &Source,
    sections: &[LayerSection],
    kind: DepthKind,
    (object_path, object): (&Path, &[Channel]),
    geometry: &mut Geometry,
) -> Result<Vec<Vec<Image>>> {
    let size = (geometry.width, geometry.height);
    let names: Vec<&str> = object.iter().map(|c| c.name.as_str()).collect();
    let mut behind = vec![Vec::new(); object.len()];
    for (i, section) in sections.iter().enumerate() {
        let path = source.resolve(&section.radiance);
        let channels = ExrFile::read(&path)?.channels(&names)?;
        for channel in &channels {
            let what = format!("the object image {}", object_path.display());
            check_size(&path, &channel.image, size, &what)?;
        }
        check_radiance(&path, &channels)?;
        behind.iter_mut().zip(channels).for_each(|(images, channel)| images.push(channel.image));

        let key = format!("[[object.layer]] {} depth", i + 1);
        let depth = depth(source, &key, &section.depth, (object_path, size))?;
        let distance = match kind {
            DepthKind::Ray => depth.field,
            DepthKind::Planar => along_rays(geometry, &depth.field),
        };
        geometry.behind.push(distance);
        let culprit = depth.path.unwrap_or_else(|| source.path.to_path_buf());
        geometry.check_behind(i).map_err(|e| Error::Scene { path: culprit, message: e.to_string() })?;
    }
    Ok(behind)
}
