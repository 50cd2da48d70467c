//! From a scene file to a [`Scene`], an [`ObservedScene`] or a [`LitScene`].

use super::background::empty_dark_background;
use super::files::files;
use super::fit_options::read_fit;
use super::format::{CameraSection, DepthKind, ObservationSection, SceneFile, parse};
use super::illumination::{read_illumination, read_reflectance};
use super::images::{Distance, Frame, ObjectImage, along_rays, depth, read_radiance, surface};
use super::layers::read_layers;
use super::light::{Light, LightReader};
use super::medium::read_medium;
use super::observation::{observed_view, planned_view, read_observation};
use super::sampling::read_sampling;
use super::source::Source;
use super::{LitScene, ObservedScene, Scene};
use crate::error::{Error, Result};
use crate::geometry::{Camera, Geometry};
use crate::image::{Border, View};
use std::path::{Path, PathBuf};

impl Scene {
    /// Reads the scene file `path` and the images it names, and checks them. Of `[observation]` only the place and the size
    /// of the view are read.
    ///
    /// # Errors
    /// Whatever is wrong first, with file and key or pixel: [`Error::Read`], [`Error::Scene`],
    /// [`Error::MissingChannel`], [`Error::WrongSize`], or [`Error::BadPixel`].
    pub fn read(path: &Path) -> Result<Self> {
        let reader = Reader::open(path)?;
        let object = read_radiance(&reader.source, &reader.file.object)?;
        Ok(seen(reader.scene(object, planned_view)?))
    }
}

impl ObservedScene {
    /// Reads the scene file `path`, which needs an `[observation]`, and the images it names, and checks them.
    ///
    /// # Errors
    /// As [`Scene::read`], and [`Error::NothingToFit`] if object or observation show nothing.
    pub fn read(path: &Path) -> Result<Self> {
        let reader = Reader::open(path)?;
        let Reader { source, file, .. } = &reader;
        let named = file.observation.as_ref().and_then(|section| section.image.as_ref());
        let transfer = file.observation.as_ref().and_then(|section| section.transfer.as_ref());
        let read_observed = |named: &PathBuf| -> Result<Light> {
            LightReader::new(source, "[observation]", transfer)?.read_main(&source.resolve(named))
        };
        // The two large images are decoded side by side; the first one's errors come first.
        let (object, observed) =
            rayon::join(|| read_radiance(source, &file.object), || named.map(read_observed));
        let object = object?;
        let (object_path, is_photograph) = (object.path.clone(), object.is_photograph);
        let scene = seen(reader.scene(object, observed_view)?);
        check_contrast(&object_path, &scene)?;
        let mut observation = read_observation(source, file.observation.as_ref(), observed, &scene)?;
        if is_photograph {
            observation.leave_out_saturated_object(&scene, &object_path);
        }
        Ok(Self { scene, observation })
    }
}

impl LitScene {
    /// Reads the scene file `path`, which needs an `[illumination]`, and the images it names, and checks them. Of
    /// `[observation]` only the place and the size of the view are read.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn read(path: &Path) -> Result<Self> {
        let reader = Reader::open(path)?;
        let Reader { source, file, .. } = &reader;
        let (object, shading) = match &file.object.reflectance {
            Some(named) if file.object.radiance.is_none() => {
                let (object, shading) = read_reflectance(source, &file.object, named)?;
                (object, Some(shading))
            }
            _ => (read_radiance(source, &file.object)?, None),
        };
        let scene = reader.scene(object, planned_view)?;
        let illumination = read_illumination(source, file.illumination.as_ref(), &scene, shading.is_some())?;
        Ok(Self { scene, shading, illumination })
    }
}

/// `scene` as its own light shows it.
fn seen(mut scene: Scene) -> Scene {
    empty_dark_background(&mut scene.geometry, &scene.object, &scene.behind);
    scene
}

/// Finds the part of the object image that is seen from `[observation]`.
type ViewRule = fn(&Source, Option<&ObservationSection>, (usize, usize)) -> Result<View>;

/// A scene file whose keys are known.
struct Reader<'a> {
    source: Source<'a>,
    file: SceneFile,
    camera: Camera,
}

impl<'a> Reader<'a> {
    fn open(path: &'a Path) -> Result<Self> {
        let source = Source::read(path)?;
        let file: SceneFile = parse(&source)?;
        let camera = camera(&source, &file.camera)?;
        Ok(Self { source, file, camera })
    }

    /// What every kind of scene needs.
    fn scene(&self, object: ObjectImage, view: ViewRule) -> Result<Scene> {
        let (source, section) = (&self.source, &self.file.object);
        let channels = object.channels.len();
        let medium = read_medium(source, self.file.medium.as_ref(), channels)?;
        let fit = read_fit(source, &self.file.fit, channels)?;
        let frame = object.frame();
        let (scale, named) = (section.depth_scale, section.depth_channel.as_deref());
        let depth = depth(source, "[object] depth", (&section.depth, scale, named), &frame)?;
        let surface = surface(source, (&section.surface, scale), &frame)?;
        let mut geometry = self.geometry(frame, depth, surface)?;
        let behind = read_layers(source, section, &object, &mut geometry)?;
        let depth_error = source.relative_error("[object] depth_error", section.depth_error)?;
        let view = view(source, self.file.observation.as_ref(), frame.size)?;
        let (sampling, sampling_is_known) = read_sampling(source, section.sampling.as_deref(), &object)?;
        // A photograph shows no black around itself.
        let ends_with_the_frame = object.is_photograph && (view.width, view.height) == frame.size;
        let noise = section.noise.as_ref().map(|noise| {
            let names: Vec<&str> = object.channels.iter().map(|c| c.name.as_str()).collect();
            noise.read(source, "[object] noise", &names, (&frame, None))
        });
        Ok(Scene {
            path: source.path.into(),
            files: files(source),
            object_noise: noise.transpose()?,
            cautions: object.cautions.clone(),
            object: object.channels.clone(),
            behind,
            geometry,
            depth_error,
            border: section.border.unwrap_or(if ends_with_the_frame {
                Border::Unknown
            } else {
                Border::Zero
            }),
            sampling,
            sampling_is_known,
            view,
            medium,
            fit,
        })
    }

    /// Puts the distances together, along the rays, and refuses an object before the medium's surface.
    fn geometry(&self, frame: Frame, depth: Distance, surface: Distance) -> Result<Geometry> {
        let (width, height) = frame.size;
        let mut geometry = Geometry {
            width,
            height,
            camera: self.camera,
            depth: depth.field,
            behind: Vec::new(),
            surface: surface.field,
        };
        if self.file.object.depth_kind == DepthKind::Planar {
            geometry.depth = along_rays(&geometry, &geometry.depth);
            geometry.surface = along_rays(&geometry, &geometry.surface);
        }
        let culprit = depth.path.or(surface.path);
        geometry.check().map_err(|e| match culprit {
            Some(path) => Error::Scene { path, message: e.to_string() },
            None => self.source.error(format!("[object] depth: {e}")),
        })?;
        Ok(geometry)
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

/// Refuses an object from which no medium could be estimated: one whose clear view, further layers included, is without
/// light, or of one value everywhere, outside included.
fn check_contrast(path: &Path, scene: &Scene) -> Result<()> {
    let geometry = &scene.geometry;
    for (channel, behind) in scene.object.iter().zip(&scene.behind) {
        let pixels = (0..geometry.height).flat_map(|y| (0..geometry.width).map(move |x| (x, y)));
        let light = |(x, y): (usize, usize)| {
            let further = geometry.behind.iter().zip(behind);
            let mut layers = [(&geometry.depth, &channel.image)].into_iter().chain(further);
            layers.find(|(depth, _)| depth.distance(x, y).is_some()).map_or(0.0, |(_, image)| image.at(x, y))
        };
        let (low, high) = pixels.map(light).fold((f32::MAX, 0.0_f32), |(a, b), v| (a.min(v), b.max(v)));
        let because = if high == 0.0 {
            "is black"
        } else if low == high && scene.border != Border::Zero {
            "is uniform, and so is what the border rule puts around it"
        } else {
            continue;
        };
        let name = &channel.name;
        return Err(Error::NothingToFit(format!("{}: channel {name} {because}", path.display())));
    }
    Ok(())
}
