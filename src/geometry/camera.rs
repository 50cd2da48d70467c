//! The camera: pixels as rays.

use crate::error::{Result, in_range};
use glam::DVec3;

/// Pinhole or parallel projection.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Camera {
    /// Parallel rays, `pixel_pitch` (length) apart.
    Orthographic {
        /// Length of a pixel.
        pixel_pitch: f64,
    },
    /// Rays from one point; the object image spans `fov_x` (radians) horizontally, centred on the axis.
    Perspective {
        /// Horizontal field of view of the whole object image, radians.
        fov_x: f64,
    },
}

impl Camera {
    /// Parallel rays, `pixel_pitch` (length) apart.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless the pitch is finite and above 0.
    pub fn orthographic(pixel_pitch: f64) -> Result<Self> {
        let ok = pixel_pitch.is_finite() && pixel_pitch > 0.0;
        in_range("pixel_pitch", pixel_pitch, ok, "finite and above 0 (length)")?;
        Ok(Self::Orthographic { pixel_pitch })
    }

    /// Rays from one point, `fov_x_deg` degrees across the width of the object image.
    ///
    /// # Errors
    /// [`Error::OutOfRange`](crate::Error::OutOfRange) unless the angle is above 0 and below 180 degrees.
    pub fn perspective(fov_x_deg: f64) -> Result<Self> {
        let ok = fov_x_deg > 0.0 && fov_x_deg < 180.0;
        in_range("fov_x_deg", fov_x_deg, ok, "between 0 and 180, exclusive (degrees)")?;
        Ok(Self::Perspective { fov_x: fov_x_deg.to_radians() })
    }

    /// Origin and unit direction of the ray through image position (`x`, `y`) px of an image of `size` (width,
    /// height) px; pixel centres lie at half-integers.
    pub fn ray(&self, x: f64, y: f64, size: (usize, usize)) -> (DVec3, DVec3) {
        let (u, v) = (x - 0.5 * size.0 as f64, y - 0.5 * size.1 as f64);
        match *self {
            Camera::Orthographic { pixel_pitch } => {
                (DVec3::new(u * pixel_pitch, v * pixel_pitch, 0.0), DVec3::Z)
            }
            Camera::Perspective { .. } => {
                let slope = self.pitch_per_depth(size.0);
                (DVec3::ZERO, DVec3::new(u * slope, v * slope, 1.0).normalize())
            }
        }
    }

    /// Length of a pixel per unit of z-depth in a perspective view `width` px wide; 0 for parallel rays.
    pub(crate) fn pitch_per_depth(&self, width: usize) -> f64 {
        match *self {
            Camera::Orthographic { .. } => 0.0,
            Camera::Perspective { fov_x } => 2.0 * (0.5 * fov_x).tan() / width as f64,
        }
    }
}
