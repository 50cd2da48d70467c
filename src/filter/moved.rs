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
    let (width, height) = (2 * image.width, 2 * image.height);
    let index = |i: usize, n: usize| Border::Mirror.index(i as i64, n).unwrap_or(0);
    let mirrored =
        Image::from_fn(width, height, |x, y| image.at(index(x, image.width), index(y, image.height)));
    let fft = Fft2::<f32>::new(width, height);
    let data = Shift::new(&fft, shift_px)?.moved(&fft, mirrored.data);
    let whole = Image { width, height, data };
    Ok(Image::from_fn(image.width, image.height, |x, y| whole.at(x, y)))
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
    }
}
