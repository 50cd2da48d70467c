//! The definition: eq. 29 summed pixel by pixel in real space, in f64.

use super::per_depth::{pixels_by_node, pixels_by_obliquity};
use super::pixel_weights::PixelWeights;
use super::{Optics, Target};
use crate::error::{Error, Result};
use crate::image::Border;
use rayon::prelude::*;

/// Largest side of an image that is summed directly, px; above, [`super::per_depth`] serves.
pub const LARGEST: usize = 128;

/// The image through the medium over the target's view, row-major: each object pixel spreads its own light with the
/// kernel of its own depth and of the obliquity of the ray that sees it, plus the direct light.
///
/// With a clamped or mirrored border the object image is continued by one image size on each side.
///
/// # Errors
/// [`Error::OutOfRange`] for an image larger than [`LARGEST`]; as [`Optics::kernel`] otherwise.
pub fn render(target: &Target, optics: &Optics) -> Result<Vec<f64>> {
    let (width, height, view) = (target.radiance.width, target.radiance.height, target.view);
    let side = width.max(height);
    if side > LARGEST {
        return Err(Error::OutOfRange {
            name: "image side, px".into(),
            value: side as f64,
            allowed: "at most 128",
        });
    }
    let around = if target.border == Border::Zero { 0 } else { side as i64 };
    let (groups, obliquities) = (pixels_by_node(target), pixels_by_obliquity(target));
    let pairs: Vec<_> = groups.iter().flat_map(|group| obliquities.iter().map(move |o| (group, o))).collect();
    let images = pairs
        .par_iter()
        .map(|((node, pixels), (obliquity, seen))| {
            let node = obliquity.scaled(*node);
            let kernel = optics.kernel(node.z)?;
            let weights =
                PixelWeights::new(&*kernel, node.pitch, side + around as usize + 2, target.sampling);
            let mut image = vec![0.0; view.pixels()];
            for &(x, y, light) in &sources(target, pixels, around) {
                for &i in seen {
                    let dx = ((view.x + i % view.width) as i64).abs_diff(x) as usize;
                    let dy = ((view.y + i / view.width) as i64).abs_diff(y) as usize;
                    let unscattered = if dx == 0 && dy == 0 { kernel.direct().value } else { 0.0 };
                    image[i] += (unscattered + weights.at(dx, dy)) * light;
                }
            }
            Ok(image)
        })
        .collect::<Result<Vec<_>>>()?;
    let mut sum = vec![0.0; view.pixels()];
    for image in images {
        sum.iter_mut().zip(image).for_each(|(s, v)| *s += v);
    }
    Ok(sum)
}

/// Position and radiance of every source: the given pixels, and their copies up to `around` pixels outside.
fn sources(target: &Target, pixels: &[(usize, usize)], around: i64) -> Vec<(i64, i64, f64)> {
    let (width, height) = (target.radiance.width, target.radiance.height);
    let mut found = Vec::new();
    for j in -around..height as i64 + around {
        for i in -around..width as i64 + around {
            let (x, y) = (target.border.index(i, width), target.border.index(j, height));
            if let (Some(x), Some(y)) = (x, y)
                && pixels.binary_search(&(y, x)).is_ok()
            {
                found.push((i, j, f64::from(target.radiance.at(x, y))));
            }
        }
    }
    found
}
