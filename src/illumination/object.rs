//! The radiance of a Lambertian object under the light that reaches it through the medium.

use super::PlaneParallel;
use crate::geometry::Geometry;
use crate::image::Image;
use crate::relief::surface_slopes;
use glam::DVec3;
use std::f64::consts::PI;

/// How an object lies in parallel light.
#[derive(Debug, Clone, PartialEq)]
pub enum Shading {
    /// Shaded according to the slopes of its depth map, without shadows.
    FromDepth,
    /// The share of the light's irradiance that each pixel has in clear air: the cosine, or 0 in a shadow.
    Map(Image),
}

/// Radiance reflectance/pi · E(h) of every pixel of the object, 0 where there is none.
pub fn lit_radiance(
    reflectance: &Image,
    shading: &Shading,
    geometry: &Geometry,
    light: &PlaneParallel,
) -> Image {
    let normals = normals(geometry);
    let (width, outward) = (geometry.width, light.sun().normal());
    Image::from_fn(width, geometry.height, |x, y| {
        let Some(z) = geometry.path_length(x, y) else { return 0.0 };
        let normal = normals[y * width + x];
        let share = match shading {
            Shading::FromDepth => (-normal.dot(light.sun().direction())).max(0.0),
            Shading::Map(map) => f64::from(map.at(x, y)),
        };
        let h = -z * geometry.ray_direction(x, y).dot(outward);
        (f64::from(reflectance.at(x, y)) / PI * light.irradiance(h, normal, share)) as f32
    })
}

/// Unit normals of the object's surface towards the camera, row-major, from the slopes of its depth map: with the
/// surface at P(x, y) the cross product of its tangents dP/dy and dP/dx.
fn normals(geometry: &Geometry) -> Vec<DVec3> {
    let slopes = surface_slopes(geometry);
    let normal = |i: usize| {
        let (x, y) = (i % geometry.width, i / geometry.width);
        let along = geometry.object_distance(x, y).map_or(0.0, |d| geometry.along_axis(x, y, d));
        let [slope_x, slope_y] = slopes.as_ref().map_or([0.0; 2], |s| s[i].map(f64::from));
        // P = D · axis ray (x, y, 1) in a perspective view; with parallel rays P moves sideways, by one pixel.
        let ray = geometry.ray_direction(x, y);
        let ray = ray / ray.z;
        let pitch = geometry.pixel_pitch(along);
        let right = slope_x * ray + pitch * DVec3::X;
        let down = slope_y * ray + pitch * DVec3::Y;
        down.cross(right).try_normalize().unwrap_or(DVec3::NEG_Z)
    };
    (0..geometry.width * geometry.height).map(normal).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Camera, Field};
    use crate::illumination::{Bottom, Sun};
    use crate::medium::Medium;

    /// Distances along the rays to the plane through (0, 0, `depth`) of normal `normal`.
    fn plane(camera: Camera, size: usize, depth: f64, normal: DVec3) -> Geometry {
        let distance = |x: usize, y: usize| {
            let (from, along) = camera.ray(x as f64 + 0.5, y as f64 + 0.5, (size, size));
            ((DVec3::Z * depth - from).dot(normal) / along.dot(normal)) as f32
        };
        Geometry {
            width: size,
            height: size,
            camera,
            depth: Field::Map(Image::from_fn(size, size, distance)),
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        }
    }

    #[test]
    fn normals_of_a_tilted_plane_are_its_own() {
        let wanted = DVec3::new(0.3, -0.4, -1.0).normalize();
        for camera in [Camera::orthographic(0.05).unwrap(), Camera::perspective(40.0).unwrap()] {
            let geometry = plane(camera, 24, 2.0, wanted);
            for normal in normals(&geometry) {
                // Central differences of a perspective depth, which is no linear function of the pixel.
                assert!((normal - wanted).length() < 0.02, "{camera:?}: {normal}");
            }
        }
    }

    #[test]
    fn a_wall_in_clear_air_reflects_the_cosine_and_behind_an_absorber_what_is_left() {
        let geometry = Geometry::planar(4, 4, 0.1, 2.0).unwrap();
        let sun = Sun::new(DVec3::new(0.0, 0.6, 0.8), DVec3::NEG_Z).unwrap();
        let white = Image::filled(4, 4, 0.5);
        for (sigma_a, left) in [(0.0, 1.0_f64), (0.3, (-0.3_f64 * 2.0 / 0.8).exp())] {
            let medium = Medium::gaussian(0.0, sigma_a, 0.01).unwrap();
            let light = PlaneParallel::new(sun, 3.0, Bottom::NONE, medium).unwrap();
            for (shading, share) in
                [(Shading::FromDepth, 0.8), (Shading::Map(Image::filled(4, 4, 0.25)), 0.25)]
            {
                let radiance = lit_radiance(&white, &shading, &geometry, &light);
                let wanted = 0.5 / PI * 3.0 * share * left;
                assert!((f64::from(radiance.at(1, 2)) / wanted - 1.0).abs() < 1e-6);
            }
        }
    }
}
