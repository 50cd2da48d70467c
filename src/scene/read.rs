//! From a scene file to a [`Scene`].

use super::fit_options::read_fit;
use super::format::{CameraSection, DepthKind, SceneFile, parse};
use super::illumination::{Object, read_illumination, read_object};
use super::images::{Distance, along_rays, depth, surface};
use super::layers::read_layers;
use super::medium::read_medium;
use super::observation::{read_observation, view};
use super::source::Source;
use super::{Purpose, Scene};
use crate::error::{Error, Result};
use crate::geometry::{Camera, Geometry};
use crate::image::{Border, Channel, Image};
use crate::io::exr::ExrFile;
use std::path::Path;

impl Scene {
    /// Reads the scene file `path` and the images it names, and checks them.
    ///
    /// # Errors
    /// Whatever is wrong first, with file and key or pixel: [`Error::Read`], [`Error::Scene`],
    /// [`Error::MissingChannel`], [`Error::WrongSize`], [`Error::BadPixel`], or [`Error::NothingToFit`].
    pub fn read(path: &Path, purpose: Purpose) -> Result<Self> {
        let source = Source { path };
        let file: SceneFile = parse(&source)?;
        let camera = camera(&source, &file.camera)?;
        let section = file.observation.as_ref();
        let observed_path = section.filter(|_| purpose == Purpose::Fit).and_then(|s| s.image.as_ref());
        // The two large images are decoded side by side; the first one's errors come first.
        let (object, observed) = rayon::join(
            || read_object(&source, &file.object, purpose),
            || observed_path.map(|named| ExrFile::read(&source.resolve(named))),
        );
        let Object { path: object_path, channels: object, shading } = object?;
        let channels = object.len();
        let medium = read_medium(&source, file.medium.as_ref(), channels)?;
        let fit = read_fit(&source, &file.fit, channels)?;

        let size = (object[0].image.width, object[0].image.height);
        let depth = depth(&source, "[object] depth", &file.object.depth, (&object_path, size))?;
        let surface = surface(&source, &file.object.surface, (&object_path, size))?;
        let kind = file.object.depth_kind;
        let mut geometry = geometry(path, camera, size, (depth, surface), kind)?;
        let behind = read_layers(&source, &file.object.layer, kind, (&object_path, &object), &mut geometry)?;
        let depth_error = source.relative_error("[object] depth_error", file.object.depth_error)?;
        let border = file.object.border;
        let view = view(&source, section, size, purpose)?;
        let observation = match purpose {
            Purpose::Render | Purpose::Synthesize => None,
            Purpose::Fit => {
                check_contrast(&object_path, (&object, &behind), &geometry, border)?;
                Some(read_observation(&source, section, observed, &object, view)?)
            }
        };
        let illumination = match purpose {
            Purpose::Synthesize => {
                let lit = shading.is_some();
                Some(read_illumination(&source, file.illumination.as_ref(), &object, (&geometry, view), lit)?)
            }
            Purpose::Render | Purpose::Fit => None,
        };
        Ok(Self {
            path: path.into(),
            object,
            shading,
            behind,
            geometry,
            depth_error,
            border,
            view,
            observation,
            medium,
            illumination,
            fit,
        })
    }
}

fn camera(source: &Source, section: &CameraSection) -> Result<Camera> {
    let made = match (section.pixel_pitch, section.fov_x_deg) {
        (Some(pitch), None) => Camera::orthographic(pitch),
        (None, Some(fov)) => Camera::perspective(fov),
        (Some(_), Some(_)) => {
            return Err(source.error("[camera] pixel_pitch and fov_x_deg are both given: leave one"));
        }
        (None, None) => return Err(source.error("[camera] pixel_pitch or fov_x_deg is missing")),
    };
    made.map_err(|e| source.error(format!("[camera] {e}")))
}

/// Puts the distances together, along the rays, and refuses an object before the medium's surface.
fn geometry(
    scene: &Path,
    camera: Camera,
    (width, height): (usize, usize),
    (depth, surface): (Distance, Distance),
    kind: DepthKind,
) -> Result<Geometry> {
    let mut geometry =
        Geometry { width, height, camera, depth: depth.field, behind: Vec::new(), surface: surface.field };
    if kind == DepthKind::Planar {
        geometry.depth = along_rays(&geometry, &geometry.depth);
        geometry.surface = along_rays(&geometry, &geometry.surface);
    }
    let culprit = depth.path.or(surface.path).unwrap_or_else(|| scene.to_path_buf());
    geometry.check().map_err(|e| Error::Scene { path: culprit, message: e.to_string() })?;
    Ok(geometry)
}

/// Refuses an object of which a medium could not be told: one whose clear view, further layers included, is without
/// light, or of one value everywhere, outside included.
fn check_contrast(
    path: &Path,
    (object, behind): (&[Channel], &[Vec<Image>]),
    geometry: &Geometry,
    border: Border,
) -> Result<()> {
    for (channel, behind) in object.iter().zip(behind) {
        let pixels = (0..geometry.height).flat_map(|y| (0..geometry.width).map(move |x| (x, y)));
        let light = |(x, y): (usize, usize)| {
            let further = geometry.behind.iter().zip(behind);
            let mut layers = [(&geometry.depth, &channel.image)].into_iter().chain(further);
            layers.find(|(depth, _)| depth.distance(x, y).is_some()).map_or(0.0, |(_, image)| image.at(x, y))
        };
        let (low, high) = pixels.map(light).fold((f32::MAX, 0.0_f32), |(a, b), v| (a.min(v), b.max(v)));
        let because = if high == 0.0 {
            "is black"
        } else if low == high && border != Border::Zero {
            "is uniform, and so is what the border rule puts around it"
        } else {
            continue;
        };
        let name = &channel.name;
        return Err(Error::NothingToFit(format!("{}: channel {name} {because}", path.display())));
    }
    Ok(())
}
