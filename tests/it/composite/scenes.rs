//! Scenes with edges, slopes and layers, and what renders them.

use crate::common::{pixels, texture};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Filter, Optics, Target, composite_sum};
use narrowbeam::geometry::{Camera, Field, Geometry};
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::relief::Relief;
use narrowbeam::spread::Model;

/// Where there is nothing.
pub const EMPTY: f64 = 0.0;
/// Width of the phase function, rad²: so narrow that steps of .8 are edges even where the light spreads over a third
/// of a pixel.
pub const B: f64 = 4e-4;
/// Size of the scenes of [`Scene::all`], px.
pub const SIZE: (usize, usize) = (24, 16);

/// A textured object behind parallel rays, its further layers and its relief.
#[derive(Clone)]
pub struct Scene {
    pub geometry: Geometry,
    pub radiance: Image,
    pub behind: Vec<Image>,
    pub border: Border,
    pub relief: Relief,
}

fn field(size: (usize, usize), depth: impl Fn(usize, usize) -> f64) -> Field {
    Field::Map(Image::from_fn(size.0, size.1, |x, y| depth(x, y) as f32))
}

impl Scene {
    pub fn new(size: (usize, usize), pixel_pitch: f64, depth: impl Fn(usize, usize) -> f64) -> Self {
        let geometry = Geometry {
            width: size.0,
            height: size.1,
            camera: Camera::orthographic(pixel_pitch).unwrap(),
            depth: field(size, depth),
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        };
        let relief = Relief::new(&geometry);
        let radiance = texture(size.0, size.1);
        Self { geometry, radiance, behind: Vec::new(), border: Border::Zero, relief }
    }

    /// The scene before one more layer, textured too.
    pub fn before(mut self, depth: impl Fn(usize, usize) -> f64) -> Self {
        let size = (self.geometry.width, self.geometry.height);
        self.geometry.behind.push(field(size, depth));
        self.relief = Relief::new(&self.geometry);
        let other = texture(size.0 + 3, size.1 + 2);
        self.behind.push(Image::from_fn(size.0, size.1, |x, y| other.at(x + 3, y + 2)));
        self
    }

    /// The scene with radiance 1 everywhere and its mirror images around it.
    pub fn white(mut self) -> Self {
        for image in self.behind.iter_mut().chain([&mut self.radiance]) {
            image.data.fill(1.0);
        }
        Self { border: Border::Mirror, ..self }
    }

    /// The target for `filter`: with the relief for [`Filter::Composite`], without for [`Filter::Eq29`].
    pub fn target(&self, filter: Filter) -> Target<'_> {
        Target {
            radiance: &self.radiance,
            behind: &self.behind,
            geometry: &self.geometry,
            border: self.border,
            sampling: Sampling::Pixel,
            view: View::whole(self.geometry.width, self.geometry.height),
            relief: Some(&self.relief).filter(|_| filter == Filter::Composite),
        }
    }

    /// The image by the fast path.
    pub fn fast(&self, filter: Filter, optics: &Optics) -> Vec<f64> {
        let filter = CpuFilter::new(self.target(filter), optics, 1.0).unwrap();
        pixels(&filter.render(optics).unwrap()).collect()
    }

    /// The image by the definition.
    pub fn definition(&self, filter: Filter, optics: &Optics) -> Vec<f64> {
        composite_sum::render(&self.target(filter), optics).unwrap()
    }

    /// Scenes of depths between 1 and 3.5 with an edge each but the last, by name; pixels so large that light scattered
    /// once spreads over `width_px` of them at 2.5.
    pub fn all(width_px: f64) -> Vec<(&'static str, Self)> {
        let pitch = 2.5 * B.sqrt() / width_px;
        let of = |depth: &dyn Fn(usize, usize) -> f64| Self::new(SIZE, pitch, depth);
        let tilt = move |x: usize| 1.0 + (0.8 * pitch).min(0.04) * x as f64;
        let half = |x: usize| if x < 14 { 1.0 } else { 2.5 };
        vec![
            ("two half planes", of(&|x, _| half(x))),
            ("three nested depths", of(&nested)),
            ("tilted plane before a flat one", of(&|x, y| if x + y / 4 < 15 { tilt(y) } else { 3.0 })),
            (
                "half planes, the far one goes on",
                of(&|x, _| half(x)).before(|x, _| if x < 14 { 2.5 } else { EMPTY }),
            ),
            ("tilted plane", of(&|x, _| tilt(x))),
        ]
    }
}

/// A rod before a plate before a plane.
pub fn nested(x: usize, y: usize) -> f64 {
    match (x, y) {
        (11..=12, 3..) => 1.0,
        (6..=19, 5..=14) => 2.2,
        _ => 3.5,
    }
}

/// tau about 2 at the depth 2.5.
pub fn optics(model: Model, phase: &Gaussian) -> Optics {
    Optics { model, medium: Medium::new(0.8, 0.1, (*phase).into()).unwrap() }
}
