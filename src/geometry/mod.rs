//! Where things are: the camera, distances along its rays, and the length of a pixel at each of them.
//!
//! Axes: x to the right, y down (as rows of an image), z away from the camera. Distances are measured along the
//! ray from the camera; the medium fills the space between `surface` and the object, so a ray's path length in it
//! is z = depth - surface. This is the only place where pixels become lengths.

mod camera;
mod path_lengths;

pub use camera::Camera;
pub use path_lengths::{PathLengths, path_lengths};

use crate::error::{Error, Result, in_range};
use crate::image::Image;
use glam::DVec3;

/// A number for the whole image, or one for each pixel.
#[derive(Debug, Clone, PartialEq)]
pub enum Field {
    /// One value everywhere.
    Uniform(f64),
    /// One value per pixel.
    Map(Image),
}

impl Field {
    /// The value at pixel (`x`, `y`).
    pub fn at(&self, x: usize, y: usize) -> f64 {
        match self {
            Field::Uniform(v) => *v,
            Field::Map(image) => f64::from(image.at(x, y)),
        }
    }

    /// The value at pixel (`x`, `y`) as the distance (length) of what is there, or `None` where nothing is: 0,
    /// negative, infinite or above [`FARTHEST`]; in a map also [`LARGEST_HALF`].
    pub fn distance(&self, x: usize, y: usize) -> Option<f64> {
        let nothing = |d: f64| matches!(self, Field::Map(_)) && d == LARGEST_HALF;
        Some(self.at(x, y)).filter(|&d| d > 0.0 && d <= FARTHEST && !nothing(d))
    }
}

/// Step of the depth between neighbouring pixels, in pixel lengths, above which they belong to two surfaces with an
/// edge between them: the slope of 76 degrees.
pub const EDGE_PITCHES: f64 = 4.0;

/// The farthest distance at which an object is taken to be there (contract: beyond, a pixel is empty).
pub const FARTHEST: f64 = 1e9;

/// The shortest path length that is computed with, and the shortest as a share of the longest of a scene: polynomials over
/// all of them know no shorter one.
const LEAST_PATH: f64 = 1e-15;
const LEAST_SHARE: f64 = 1e-9;

/// The largest number of 16-bit EXR files, which renderers write where they see nothing.
pub const LARGEST_HALF: f64 = 65504.0;

/// Relative distance by which a layer may lie before the one in front of it and still count as repeating it: two f32
/// distances of one surface, each rounded a few times.
const REPEATED: f64 = 4.0 * f32::EPSILON as f64;

/// Camera, object distance and medium surface of a scene, over the object image.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// Width of the object image, px.
    pub width: usize,
    /// Height of the object image, px.
    pub height: usize,
    /// The projection.
    pub camera: Camera,
    /// Distance from the camera to the object along the ray; empty pixels are 0, negative, infinite or > 1e9.
    pub depth: Field,
    /// The same for the further layers, known surfaces behind it, nearest first.
    pub behind: Vec<Field>,
    /// Distance from the camera to the medium's surface along the ray.
    pub surface: Field,
}

impl Geometry {
    /// One plane seen by parallel rays `pixel_pitch` apart, behind a path `z` of medium.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless pitch and `z` are finite and above 0.
    pub fn planar(width: usize, height: usize, pixel_pitch: f64, z: f64) -> Result<Self> {
        in_range("depth", z, z.is_finite() && z > 0.0, "finite and above 0 (length)")?;
        Ok(Self {
            width,
            height,
            camera: Camera::orthographic(pixel_pitch)?,
            depth: Field::Uniform(z),
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        })
    }

    /// Distance to the object at pixel (`x`, `y`), or `None` where there is none.
    pub fn object_distance(&self, x: usize, y: usize) -> Option<f64> {
        self.depth.distance(x, y)
    }

    /// Path length z in the medium at pixel (`x`, `y`), or `None` where there is no object.
    pub fn path_length(&self, x: usize, y: usize) -> Option<f64> {
        self.object_distance(x, y).map(|d| d - self.surface.at(x, y))
    }

    /// A length (depth, path) along the ray of pixel (`x`, `y`), projected on the camera's axis. Maps hold f32, so in a
    /// perspective view the result is rounded to one part in a million, so that a flat wall has one depth.
    pub fn along_axis(&self, x: usize, y: usize, length: f64) -> f64 {
        match self.camera {
            Camera::Orthographic { .. } => length,
            Camera::Perspective { .. } => {
                let along = length * self.cos_off_axis(x, y);
                let step = (20.0 - along.abs().log2().ceil()).exp2();
                if step.is_finite() && step > 0.0 { (along * step).round() / step } else { along }
            }
        }
    }

    /// Length of a pixel on the plane at `depth` along the camera's axis: constant for parallel rays, growing with the
    /// depth in a perspective view.
    pub fn pixel_pitch(&self, depth: f64) -> f64 {
        match self.camera {
            Camera::Orthographic { pixel_pitch } => pixel_pitch,
            Camera::Perspective { .. } => self.pitch_per_depth() * depth,
        }
    }

    /// Length of a pixel per unit of depth in a perspective view: how rays diverge; 0 for parallel ones.
    pub fn pitch_per_depth(&self) -> f64 {
        self.camera.pitch_per_depth(self.width)
    }

    /// Cosine of the angle between the ray through the centre of pixel (`x`, `y`) and the camera's axis.
    pub fn cos_off_axis(&self, x: usize, y: usize) -> f64 {
        match self.camera {
            Camera::Orthographic { .. } => 1.0,
            Camera::Perspective { .. } => self.ray_direction(x, y).z,
        }
    }

    /// Unit vector from the camera along the ray through the centre of pixel (`x`, `y`).
    pub fn ray_direction(&self, x: usize, y: usize) -> DVec3 {
        self.camera.ray(x as f64 + 0.5, y as f64 + 0.5, (self.width, self.height)).1
    }

    /// The path lengths of all pixels that show an object; a single one for a flat scene.
    pub fn path_lengths(&self) -> Vec<f64> {
        self.over_pixels(&[&self.depth, &self.surface], |x, y| self.path_length(x, y))
    }

    /// The same with the object farther away by the share `share`, the medium's surface where it is.
    pub(crate) fn deeper(&self, share: f64) -> Self {
        let mut deeper = self.clone();
        for field in std::iter::once(&mut deeper.depth).chain(&mut deeper.behind) {
            match field {
                Field::Uniform(depth) => *depth *= 1.0 + share,
                Field::Map(map) => map.data.iter_mut().for_each(|depth| *depth *= 1.0 + share as f32),
            }
        }
        deeper
    }

    /// Median length of a pixel at the object.
    pub fn median_pixel_pitch(&self) -> f64 {
        let shown = |x, y| self.object_distance(x, y).map(|d| self.pixel_pitch(d * self.cos_off_axis(x, y)));
        let flat = matches!(self.camera, Camera::Orthographic { .. });
        let on: &[&Field] = if flat { &[] } else { &[&self.depth] };
        median(self.over_pixels(on, shown))
    }

    /// `f` of every pixel where it is defined; of the first such pixel only if none of the fields `on` which it depends
    /// varies.
    fn over_pixels(&self, on: &[&Field], f: impl Fn(usize, usize) -> Option<f64>) -> Vec<f64> {
        let constant = on.iter().all(|field| matches!(field, Field::Uniform(_)));
        let all = (0..self.width * self.height).filter_map(|i| f(i % self.width, i / self.width));
        all.take(if constant { 1 } else { usize::MAX }).collect()
    }

    /// Refuses an object before the medium's surface, a scene without any object, and what
    /// [`Geometry::check_behind`] refuses.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] that names the pixel; [`Error::NothingToFit`] if every pixel is empty.
    pub fn check(&self) -> Result<()> {
        let pixels = || (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        let shown = || pixels().filter_map(|(x, y)| Some((x, y, self.path_length(x, y)?)));
        let longest = shown().map(|(_, _, z)| z).fold(0.0, f64::max);
        let least = LEAST_PATH.max(LEAST_SHARE * longest);
        for (x, y, z) in shown() {
            let name = || format!("depth - surface at pixel ({x}, {y})");
            in_range(&name(), z, z > 0.0, "above 0: the object lies before the medium's surface")?;
            in_range(&name(), z, z >= least, "at least 1e-15 and a billionth of the longest of all pixels")?;
        }
        if shown().next().is_none() {
            return Err(Error::NothingToFit("no pixel of the depth map shows an object".into()));
        }
        (0..self.behind.len()).try_for_each(|i| self.check_behind(i))
    }

    /// Refuses further layer `i` (from 0) where it lies before the medium's surface or before what is in front of it
    /// at the same pixel.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] that names the layer, counted from 1 as in scene files, and the pixel.
    pub fn check_behind(&self, i: usize) -> Result<()> {
        for (x, y) in (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y))) {
            let Some(d) = self.behind[i].distance(x, y) else { continue };
            let name = |what| format!("[[object.layer]] {}: {what} at pixel ({x}, {y})", i + 1);
            let z = d - self.surface.at(x, y);
            let ok = z > 0.0 && z.is_finite();
            in_range(&name("depth - surface"), z, ok, "above 0: it lies before the medium's surface")?;
            let mut in_front = self.behind[..i].iter().rev().chain([&self.depth]);
            let nearest = in_front.find_map(|field| field.distance(x, y)).unwrap_or(0.0);
            let ok = d >= nearest * (1.0 - REPEATED);
            in_range(&name("depth"), d, ok, "at least that of what is in front of it there")?;
        }
        Ok(())
    }
}

/// The upper median of `values`, of which there is at least one.
pub(crate) fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
