//! Figure 8: a picture of objects in a scattering medium, from the depth of the medium's surface, the depth of the objects
//! and their reflection image.
//!
//! The paper's own scene is not published; ours is four balls over a checkered floor in milk thinned 1 : 1000 (Narasimhan
//! et al., 2006), lengths in centimetres, seen by parallel rays that meet the surface at an angle.

use super::Effort;
use crate::error::Result;
use crate::filter::{Backend, Filter};
use crate::geometry::{Camera, Field, Geometry};
use crate::illumination::{Bottom, Shading, Sun};
use crate::image::{Border, Channel, Image, Sampling, View};
use crate::medium::Medium;
use crate::scene::{Illumination, LitScene, Scene};
use crate::spread::Model;
use crate::synthesis::{Synthesis, synthesize};
use glam::{DVec2, DVec3};
use std::path::PathBuf;

/// What is compared: the paper's kernel and the one nearest to the truth.
pub const MODELS: [Model; 2] = [Model::NarrowBeamPrinted, Model::WideAngle];

/// Side of the square image that is seen, cm.
const WIDTH: f64 = 24.0;
/// Angle between the line of sight and the surface's normal.
const TILT: f64 = 0.45;
/// From the camera to the surface along the central ray, cm.
const DISTANCE: f64 = 20.0;
/// Of the floor below the surface, cm.
const FLOOR: f64 = 9.0;
/// Sides of the floor's squares, cm.
const TILE: f64 = 2.5;
/// Colours of the floor; white is on the balls as well.
const WHITE: [f64; 3] = [0.85, 0.85, 0.85];
const GRAY: [f64; 3] = [0.12, 0.13, 0.16];
/// Direction of the light in the tub's axes: right, away from the camera, up.
const LIGHT: DVec3 = DVec3::new(0.5, 0.35, -1.0);
const IRRADIANCE: [f64; 3] = [3.2, 3.0, 2.8];

/// sigma_s, sigma_a (1/cm) and B = (1 - g)/2 of red, green and blue.
const MEDIA: [[f64; 3]; 3] = [[0.1312, 2.87e-5, 0.034], [0.1544, 5.75e-5, 0.049], [0.1796, 1.15e-4, 0.0705]];

/// A ball of `radius` with stripes of two colours.
struct Ball {
    /// In the tub's axes; the surface is at height 0.
    centre: DVec3,
    radius: f64,
    colours: [[f64; 3]; 2],
}

const BALLS: [Ball; 4] = [
    Ball { centre: DVec3::new(-6.0, -3.2, -3.2), radius: 2.4, colours: [[0.8, 0.08, 0.06], WHITE] },
    Ball { centre: DVec3::new(1.2, 0.6, -5.2), radius: 2.4, colours: [[0.07, 0.22, 0.75], WHITE] },
    Ball {
        centre: DVec3::new(6.6, -4.6, -6.0),
        radius: 2.2,
        colours: [[0.9, 0.68, 0.06], [0.35, 0.03, 0.03]],
    },
    Ball { centre: DVec3::new(6.2, 7.0, -6.8), radius: 2.2, colours: [[0.1, 0.55, 0.14], WHITE] },
];

/// Where a ray first meets something: distance, place, normal, reflectance.
struct Hit {
    distance: f64,
    place: DVec3,
    normal: DVec3,
    reflectance: [f64; 3],
}

/// The distance at which a ray from `from` along the unit vector `along` enters `ball`.
fn entry(ball: &Ball, from: DVec3, along: DVec3) -> Option<f64> {
    let towards = ball.centre - from;
    let middle = towards.dot(along);
    let inside = ball.radius.powi(2) - (towards.length_squared() - middle * middle);
    (inside > 0.0).then(|| middle - inside.sqrt()).filter(|d| *d > 0.0)
}

/// Of the balls and the floor, what a ray meets first; rays go down.
fn meet(from: DVec3, along: DVec3) -> Hit {
    let distance = (-FLOOR - from.z) / along.z;
    let place = from + distance * along;
    let tile = (place.truncate() / TILE).floor();
    let reflectance = if (tile.x + tile.y).rem_euclid(2.0) < 1.0 { WHITE } else { GRAY };
    let mut first = Hit { distance, place, normal: DVec3::Z, reflectance };
    for ball in &BALLS {
        let Some(distance) = entry(ball, from, along).filter(|d| *d < first.distance) else { continue };
        let place = from + distance * along;
        let normal = (place - ball.centre) / ball.radius;
        let around = (normal.y.atan2(normal.x) * 4.0 / std::f64::consts::PI).floor();
        let stripe = usize::from(around.rem_euclid(2.0) >= 1.0);
        first = Hit { distance, place, normal, reflectance: ball.colours[stripe] };
    }
    first
}

/// From the tub's axes to the camera's: x right, y down, z away.
fn to_camera(v: DVec3) -> DVec3 {
    let (s, c) = TILT.sin_cos();
    DVec3::new(v.x, -c * v.y - s * v.z, s * v.y - c * v.z)
}

/// The scene, `side` x `side` px, and the media of its channels.
///
/// # Errors
/// None but those of constants out of range.
pub fn scene(side: usize) -> Result<(LitScene, Vec<Medium>)> {
    let (s, c) = TILT.sin_cos();
    let along = DVec3::new(0.0, s, -c);
    let pitch = WIDTH / side as f64;
    // The central ray meets the surface at the origin of the tub's axes.
    let origin = |x: usize, y: usize| {
        let at = (DVec2::new(x as f64, y as f64) + 0.5) * pitch - WIDTH / 2.0;
        DVec3::new(at.x, -c * at.y, -s * at.y) - DISTANCE * along
    };
    let hit = |x: usize, y: usize| meet(origin(x, y), along);
    let towards_light = -LIGHT.normalize();
    let lit = |hit: &Hit| {
        let shadowed = BALLS.iter().any(|b| entry(b, hit.place + 1e-6 * hit.normal, towards_light).is_some());
        if shadowed { 0.0 } else { hit.normal.dot(towards_light).max(0.0) }
    };
    let image = |value: &dyn Fn(usize, usize) -> f64| Image::from_fn(side, side, |x, y| value(x, y) as f32);
    let colour = |i: usize| Channel {
        name: ["R", "G", "B"][i].into(),
        image: image(&|x, y| hit(x, y).reflectance[i]),
    };
    let mean = (0..3).map(|i| (WHITE[i] + GRAY[i]) / 2.0);
    let scene = Scene {
        path: PathBuf::from("figure 8"),
        files: Vec::new(),
        object: (0..3).map(colour).collect(),
        object_noise: None,
        cautions: Vec::new(),
        behind: vec![Vec::new(); 3],
        geometry: Geometry {
            width: side,
            height: side,
            camera: Camera::orthographic(pitch)?,
            depth: Field::Map(image(&|x, y| hit(x, y).distance)),
            behind: Vec::new(),
            surface: Field::Map(image(&|x, y| -origin(x, y).z / along.z)),
        },
        depth_error: 0.0,
        sampling: Sampling::Pixel,
        sampling_is_known: true,
        border: Border::Clamp,
        view: View::whole(side, side),
        medium: Vec::new(),
        fit: Vec::new(),
    };
    scene.geometry.check()?;
    let shading = Some(Shading::Map(image(&|x, y| lit(&hit(x, y)))));
    let illumination = Illumination::Parallel {
        sun: Sun::new(to_camera(LIGHT), to_camera(DVec3::Z))?,
        irradiance: IRRADIANCE.to_vec(),
        bottom: mean.map(|reflectance| Bottom::new(FLOOR, reflectance)).collect::<Result<_>>()?,
    };
    let media = MEDIA.map(|[sigma_s, sigma_a, b]| Medium::gaussian(sigma_s, sigma_a, b));
    Ok((LitScene { scene, shading, illumination }, media.into_iter().collect::<Result<_>>()?))
}

/// Side of the image, px.
pub fn side(effort: Effort) -> usize {
    match effort {
        Effort::Full => 512,
        Effort::Quick => 72,
    }
}

/// The picture of `scene` by each of [`MODELS`] and the paper's filter, its eq. 29.
///
/// # Errors
/// As [`synthesize`].
pub fn pictures(scene: &LitScene, media: &[Medium]) -> Result<Vec<(Model, Synthesis)>> {
    let by = |model| Ok((model, synthesize(scene, media, model, Filter::Eq29, Backend::Cpu)?));
    MODELS.into_iter().map(by).collect()
}

/// The light of one channel by one model.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// The model.
    pub model: Model,
    /// The channel.
    pub channel: String,
    /// Mean radiance of the object in clear air.
    pub clear: f64,
    /// Means of the parts of the picture: direct, scattered, veil.
    pub parts: [f64; 3],
    /// Root mean square difference of the picture from that of the last of [`MODELS`], over the root mean square of that.
    pub difference: f64,
}

/// What `pictures` hold, model by model and channel by channel.
pub fn light(pictures: &[(Model, Synthesis)]) -> Vec<Light> {
    let Some((_, best)) = pictures.last() else { return Vec::new() };
    let best = best.total();
    let of = |(model, made): &(Model, Synthesis)| -> Vec<Light> {
        let total = made.total();
        let channel = |i: usize| {
            let pairs = total[i].image.data.iter().zip(&best[i].image.data);
            let [apart, all] = pairs.fold([0.0; 2], |[apart, all], (a, b)| {
                [apart + f64::from(a - b).powi(2), all + f64::from(*b).powi(2)]
            });
            Light {
                model: *model,
                channel: total[i].name.clone(),
                clear: made.clear[i].image.mean(),
                parts: [&made.direct, &made.scattered, &made.veil].map(|part| part[i].image.mean()),
                difference: (apart / all).sqrt(),
            }
        };
        (0..total.len()).map(channel).collect()
    };
    pictures.iter().flat_map(of).collect()
}
