//! The signal behind a noisy image, for its own noise.

use crate::image::Image;

/// Pixels to each side over which is averaged.
const AROUND: usize = 2;

/// The mean of each pixel's neighbours, itself left out, over those that count; the pixel's own value where none does.
///
/// A variance that is taken from the pixel's own value is small where noise has made the pixel dark: weights follow the noise, and the mean
/// that they give is too low. The neighbours' noise is independent.
pub(super) fn smoothed(image: &Image, counts: impl Fn(usize) -> bool) -> Image {
    let (width, height) = (image.width, image.height);
    Image::from_fn(width, height, |x, y| {
        let rows = y.saturating_sub(AROUND)..(y + AROUND + 1).min(height);
        let columns = x.saturating_sub(AROUND)..(x + AROUND + 1).min(width);
        let around = rows.flat_map(|v| columns.clone().map(move |u| (u, v)));
        let others = around.filter(|&(u, v)| (u, v) != (x, y) && counts(v * width + u));
        let (sum, n) =
            others.fold((0.0_f64, 0.0), |(sum, n), (u, v)| (sum + f64::from(image.at(u, v)), n + 1.0));
        if n > 0.0 { (sum / n) as f32 } else { image.at(x, y) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_that_count_are_averaged_without_the_pixel_itself() {
        let image = Image::from_fn(3, 1, |x, _| [1.0, 10.0, 5.0][x]);
        assert_eq!(smoothed(&image, |_| true).data, [7.5, 3.0, 5.5]);
        assert_eq!(smoothed(&image, |i| i != 2).data, [10.0, 1.0, 5.5]);
        assert_eq!(smoothed(&image, |_| false).data, image.data);
    }
}
