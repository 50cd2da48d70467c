//! An image moved by a fraction of a pixel, outside any scene.

use super::fft2::Fft2;
use super::shift::Shift;
use crate::error::Result;
use crate::image::{Border, Image};

/// `image` moved by `shift_px` to the right and downwards; what comes in is its own mirror image.
///
/// # Errors
/// [`Error::OutOfRange`](crate::Error::OutOfRange) for a shift that is not finite or larger than twice the image.
pub fn moved(image: &Image, shift_px: [f64; 2]) -> Result<Image> {
    let (fft, mirrored) = mirrored(image);
    Ok(cropped(Shift::new(&fft, shift_px)?.moved(&fft, mirrored), &fft, image))
}

/// The derivatives of `image` in a shift to the right and downwards, 1/px; beyond its edges it goes on as its own mirror image.
///
/// # Errors
/// None but those of [`moved`], which a shift by 0 does not meet.
pub fn motion(image: &Image) -> Result<[Image; 2]> {
    let (fft, mirrored) = mirrored(image);
    let [_, x, y] = Shift::new(&fft, [0.0; 2])?.moved_with_motion(&fft, mirrored);
    Ok([x, y].map(|data| cropped(data, &fft, image)))
}

/// `image` beside its mirror images, twice as large, and what transforms it.
pub(super) fn mirrored(image: &Image) -> (Fft2<f32>, Vec<f32>) {
    let (width, height) = (2 * image.width, 2 * image.height);
    let index = |i: usize, n: usize| Border::Mirror.index(i as i64, n).unwrap_or(0);
    let at = |x: usize, y: usize| image.at(index(x, image.width), index(y, image.height));
    (Fft2::new(width, height), Image::from_fn(width, height, at).data)
}

/// The part of `data` that lies where `image` does.
fn cropped(data: Vec<f32>, fft: &Fft2<f32>, image: &Image) -> Image {
    let whole = Image { width: fft.width, height: fft.height, data };
    Image::from_fn(image.width, image.height, |x, y| whole.at(x, y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_image_moves_by_a_fraction_of_a_pixel_and_back() {
        let wave = |x: f64, y: f64| 0.5 + 0.3 * (0.4 * x).sin() * (0.3 * y).cos();
        let image = Image::from_fn(48, 40, |x, y| wave(x as f64, y as f64) as f32);
        let there = moved(&image, [0.3, -0.6]).unwrap();
        let off = |image: &Image| {
            let at =
                |(x, y): (usize, usize)| f64::from(image.at(x, y)) - wave(x as f64 - 0.3, y as f64 + 0.6);
            [(20, 18), (24, 20), (30, 22)].map(at).into_iter().map(f64::abs).fold(0.0, f64::max)
        };
        assert!(off(&there) < 2e-3, "{}", off(&there));
        assert!(off(&image) > 2e-2, "an image that did not move passes: {}", off(&image));
        assert!(moved(&image, [f64::NAN, 0.0]).is_err());
        let [x, y] = motion(&image).unwrap();
        let (at, step) = ((24, 20), 1e-2);
        let change = |axis: usize| {
            let along = |side: f64| {
                moved(&image, std::array::from_fn(|i| if i == axis { side * step } else { 0.0 })).unwrap()
            };
            (along(1.0).at(at.0, at.1) - along(-1.0).at(at.0, at.1)) / (2.0 * step as f32)
        };
        for (axis, motion) in [x, y].iter().enumerate() {
            assert!((motion.at(at.0, at.1) - change(axis)).abs() < 1e-4, "axis {axis}");
        }
    }
}
