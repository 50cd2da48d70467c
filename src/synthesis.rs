//! Image synthesis: direct and scattered light of the object, and the veil of the illumination.
//!
//! Shinya et al., section 6 and fig. 8. The [filter](crate::filter) computes the object light. The veil is an image given
//! by the user, or that of a plane-parallel medium ([`illumination`](crate::illumination)), which the paper assumes as well
//! (its ref. 8).

use crate::error::Result;
use crate::filter::{Backend, Filter, Optics, Target};
use crate::illumination::{Bottom, PlaneParallel, lit_radiance};
use crate::image::{Channel, Image};
use crate::medium::Medium;
use crate::scene::{Illumination, LitScene, Scene};
use crate::spread::Model;

/// The light of an image by its origin, one channel each as the object has them, over the scene's view.
#[derive(Debug, Clone)]
pub struct Synthesis {
    /// The object in clear air, under the light in clear air.
    pub clear: Vec<Channel>,
    /// Object light that arrives unscattered.
    pub direct: Vec<Channel>,
    /// Object light scattered on its way to the camera.
    pub scattered: Vec<Channel>,
    /// Light of the illumination that the medium scatters to the camera.
    pub veil: Vec<Channel>,
    /// Whether a kernel reaches farther than the padding: [`CUT`](crate::filter::CUT).
    pub cut: bool,
}

impl Synthesis {
    /// What the camera sees: direct + scattered + veil.
    pub fn total(&self) -> Vec<Channel> {
        let mut total = self.direct.clone();
        for (i, channel) in total.iter_mut().enumerate() {
            let more = self.scattered[i].image.data.iter().zip(&self.veil[i].image.data);
            channel.image.data.iter_mut().zip(more).for_each(|(t, (s, v))| *t += s + v);
        }
        total
    }
}

/// The image of `lit` through `media`, one for each of its channels.
///
/// # Errors
/// As [`Backend::prepare`].
pub fn synthesize(
    lit: &LitScene,
    media: &[Medium],
    model: Model,
    filter: Filter,
    backend: Backend,
) -> Result<Synthesis> {
    let LitScene { scene, shading, illumination } = lit;
    let relief = filter.relief(&scene.geometry);
    let none = || Vec::with_capacity(scene.object.len());
    let mut made = Synthesis { clear: none(), direct: none(), scattered: none(), veil: none(), cut: false };
    for (i, medium) in media.iter().enumerate() {
        let object = &scene.object[i].image;
        let (clear, radiance, veil) = match illumination {
            Illumination::Veil(channels) => (object.clone(), object.clone(), channels[i].image.clone()),
            Illumination::Parallel { sun, irradiance, bottom } => {
                let air = Medium::new(0.0, 0.0, *medium.phase())?;
                let air = PlaneParallel::new(*sun, irradiance[i], Bottom::NONE, air)?;
                let light = PlaneParallel::new(*sun, irradiance[i], bottom[i], *medium)?;
                let under = |light: &PlaneParallel| match shading {
                    None => object.clone(),
                    Some(shading) => lit_radiance(object, shading, &scene.geometry, light),
                };
                (under(&air), under(&light), veil(scene, &light))
            }
        };
        let target = Target {
            radiance: &radiance,
            behind: &scene.behind[i],
            geometry: &scene.geometry,
            border: scene.border,
            sampling: scene.sampling,
            view: scene.view,
            relief: relief.as_ref(),
        };
        let optics = Optics { model, medium: *medium };
        let prepared = backend.prepare(target, &optics, 1.0)?;
        let direct = unscattered(&target, |z| medium.transmittance(z));
        let mut scattered = prepared.render(&optics)?;
        scattered.data.iter_mut().zip(&direct.data).for_each(|(all, direct)| *all -= direct);
        made.cut |= prepared.coverage(&optics)?.cut;

        let name = &scene.object[i].name;
        let channel = |image: Image| Channel { name: name.clone(), image };
        made.clear.push(channel(unscattered(&Target { radiance: &clear, ..target }, |_| 1.0)));
        made.direct.push(channel(direct));
        made.scattered.push(channel(scattered));
        made.veil.push(channel(veil));
    }
    Ok(made)
}

/// T(z) L of what each pixel of the view sees in clear air, `transmittance` being T: the object, or where that is empty
/// the next layer, which only filters with a relief use.
fn unscattered(target: &Target, transmittance: impl Fn(f64) -> f64) -> Image {
    let geometry = target.geometry;
    let layers = if target.relief.is_some() { geometry.behind.len() } else { 0 };
    let fields = || std::iter::once(&geometry.depth).chain(&geometry.behind[..layers]);
    let images = || std::iter::once(target.radiance).chain(target.behind);
    Image::from_fn(target.view.width, target.view.height, |x, y| {
        let (x, y) = (x + target.view.x, y + target.view.y);
        let seen = fields().zip(images()).find_map(|(field, image)| Some((field.distance(x, y)?, image)));
        seen.map_or(0.0, |(d, image)| {
            (transmittance(d - geometry.surface.at(x, y)) * f64::from(image.at(x, y))) as f32
        })
    })
}

/// The veil of every pixel of the view. Where there is no object the ray continues to the bottom. Where there is no
/// surface of the medium there is no veil.
fn veil(scene: &Scene, light: &PlaneParallel) -> Image {
    let geometry = &scene.geometry;
    Image::from_fn(scene.view.width, scene.view.height, |x, y| {
        let (x, y) = (x + scene.view.x, y + scene.view.y);
        let z = match geometry.path_length(x, y) {
            Some(z) => z,
            None if geometry.surface.at(x, y).is_finite() => f64::INFINITY,
            None => 0.0,
        };
        light.veil(geometry.ray_direction(x, y), z) as f32
    })
}
