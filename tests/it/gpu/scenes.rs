//! Scenes that between them take every path through the shaders.

use crate::common::texture;
use narrowbeam::filter::{Filter, Target};
use narrowbeam::geometry::{Camera, Field, Geometry};
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::relief::Relief;

/// Length of a pixel, and the depth about which a [`Scene::slope`] lies.
pub const PITCH: f64 = 0.002;
pub const MEAN_DEPTH: f64 = 2.0;

pub struct Scene {
    pub name: &'static str,
    radiance: Image,
    behind: Vec<Image>,
    geometry: Geometry,
    border: Border,
    view: View,
    relief: Option<Relief>,
}

impl Scene {
    pub fn new(name: &'static str, size: (usize, usize), depth: impl Fn(usize, usize) -> f64) -> Self {
        let geometry = Geometry {
            width: size.0,
            height: size.1,
            camera: Camera::orthographic(PITCH).unwrap(),
            depth: map(size, depth),
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        };
        Self {
            name,
            radiance: texture(size.0, size.1),
            behind: Vec::new(),
            border: Border::Zero,
            view: View::whole(size.0, size.1),
            relief: None,
            geometry,
        }
    }

    /// A slope of 15 degrees in `steps` steps.
    pub fn slope(size: (usize, usize), steps: usize) -> Self {
        let across = PITCH * 15.0_f64.to_radians().tan() * size.0 as f64;
        let step = move |x: usize| (x * steps / size.0) as f64 + 0.5;
        Self::new("slope", size, move |x, _| MEAN_DEPTH + across * (step(x) / steps as f64 - 0.5))
    }

    pub fn border(self, border: Border) -> Self {
        Self { border, ..self }
    }

    pub fn view(self, x: usize, y: usize, width: usize, height: usize) -> Self {
        Self { view: View { x, y, width, height }, ..self }
    }

    /// With a layer behind, and the relief that follows.
    pub fn before(mut self, depth: impl Fn(usize, usize) -> f64) -> Self {
        let (width, height) = (self.geometry.width, self.geometry.height);
        self.geometry.behind.push(map((width, height), depth));
        let other = texture(width + 3, height + 2);
        self.behind.push(Image::from_fn(width, height, |x, y| other.at(x + 3, y + 2)));
        self.composite()
    }

    pub fn composite(mut self) -> Self {
        self.relief = Filter::Composite.relief(&self.geometry);
        self
    }

    pub fn perspective(mut self, fov_x_deg: f64) -> Self {
        self.geometry.camera = Camera::perspective(fov_x_deg).unwrap();
        self
    }

    pub fn surface(mut self, distance: impl Fn(usize, usize) -> f64) -> Self {
        self.geometry.surface = map((self.geometry.width, self.geometry.height), distance);
        self
    }

    pub fn target(&self) -> Target<'_> {
        Target {
            radiance: &self.radiance,
            behind: &self.behind,
            geometry: &self.geometry,
            border: self.border,
            sampling: Sampling::Pixel,
            view: self.view,
            relief: self.relief.as_ref(),
        }
    }
}

fn map(size: (usize, usize), depth: impl Fn(usize, usize) -> f64) -> Field {
    Field::Map(Image::from_fn(size.0, size.1, |x, y| depth(x, y) as f32))
}

const SIZE: (usize, usize) = (40, 28);

fn slope(x: usize, y: usize) -> f64 {
    1.5 + 0.0012 * x as f64 + 0.0004 * y as f64
}

/// A box in front of a slope.
fn hidden_slope(x: usize, y: usize) -> f64 {
    if (12..24).contains(&x) && (8..20).contains(&y) { 0.9 } else { slope(x, y) }
}

fn gap(x: usize, y: usize) -> f64 {
    if (5..9).contains(&x) { 0.0 } else { slope(x, y) }
}

pub fn all() -> Vec<Scene> {
    vec![
        Scene::new("plane", SIZE, |_, _| 2.0),
        Scene::new("plane, clamp", SIZE, |_, _| 2.0).border(Border::Clamp),
        Scene::new("plane, mirror, view", SIZE, |_, _| 2.0).border(Border::Mirror).view(5, 3, 20, 17),
        Scene::new("prime sides, mirror", (37, 23), slope).border(Border::Mirror),
        Scene::new("two depths", SIZE, |x, _| if x < 20 { 1.0 } else { 1.3 }),
        Scene::new("slope, view", SIZE, slope).view(3, 2, 30, 20),
        Scene::new("slope, clamp, with a gap", SIZE, gap).border(Border::Clamp),
        Scene::new("slope, composite", SIZE, slope).composite(),
        Scene::new("slope, composite, clamp", SIZE, slope).border(Border::Clamp).composite(),
        Scene::new("slope, composite, mirror", SIZE, slope).border(Border::Mirror).composite(),
        Scene::new("box, composite", SIZE, hidden_slope).composite(),
        Scene::new("box and layer, mirror", SIZE, hidden_slope).border(Border::Mirror).before(slope),
        Scene::new("perspective plane", SIZE, |_, _| 2.0).perspective(50.0),
        Scene::new("perspective slope", SIZE, slope).perspective(50.0).composite(),
        Scene::new("perspective box", SIZE, hidden_slope).perspective(40.0).before(slope),
        Scene::new("perspective, uneven surface", SIZE, |_, _| 2.0)
            .perspective(40.0)
            .surface(|x, y| 0.3 + 0.01 * ((x + 2 * y) % 9) as f64),
    ]
}
