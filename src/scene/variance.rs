//! `[observation] variance`: the variance of each pixel, known or estimated.
//!
//! Channels of the observation's own names (`Y`, or `R`, `G`, `B`) are variances that are known. `Y.variance` and so on, as
//! `narrowbeam trace` writes them, were estimated from the samples that made the image, and are correlated with its noise: a pixel that
//! is bright by chance also has a large estimated variance. Least squares would give dark pixels too much weight, and the
//! estimate would be off by about sqrt(pixels / samples) times the skewness of a sample, in standard errors. So such an
//! estimate is replaced by the mean over the pixel's neighbours, which is independent of the pixel's own noise. Where few
//! samples met light, even that mean is too small by chance; no pixel is trusted with less than a share of the mean variance of the image.

use super::images::{Frame, as_the_object, check_pixels};
use crate::error::{Error, Result};
use crate::image::{Channel, Image};
use crate::io::picture::Picture;
use std::path::Path;

/// Largest variance that is accepted, the square of the largest radiance, and the inverse of the smallest.
const LARGEST: f32 = 1e30;

/// How far a pixel's neighbours reach.
const AROUND: usize = 2;
/// Share of the mean variance below which no pixel's is believed.
const LEAST: f64 = 0.02;

/// The variance of each pixel of the channels `names` of the observed image `observed`; 1 where the
/// mask excludes it.
pub(super) fn read(
    path: &Path,
    names: &[&str],
    observed: &Frame,
    mask: Option<&Image>,
) -> Result<Vec<Channel>> {
    let Picture { file, codes } = Picture::read(path)?;
    if let Some(codes) = codes {
        let reason =
            format!("it is {}: variances are floats, as in an EXR, TIFF or PFM file", codes.in_words());
        return Err(Error::Read { path: path.to_path_buf(), reason });
    }
    let counts = |i: usize| mask.is_none_or(|m| m.data[i] > 0.0);
    let estimated: Result<Vec<Channel>> =
        names.iter().map(|name| file.named(&format!("{name}.variance"))).collect();
    let (mut variance, are_estimates) = match estimated {
        Ok(found) => (found, true),
        Err(_) => (file.channels(names).map_err(|e| e.since(|| as_the_object(names)))?, false),
    };
    for (channel, name) in variance.iter_mut().zip(names) {
        observed.check(path, &channel.image, "the observed image")?;
        let data = &mut channel.image.data;
        data.iter_mut().enumerate().filter(|(i, _)| !counts(*i)).for_each(|(_, v)| *v = 1.0);
        if are_estimates {
            let allowed = "a variance, at least 0, where the mask does not exclude the pixel";
            check_pixels(path, channel, allowed, |v| v >= 0.0)?;
            channel.image = of_neighbours(&channel.image, counts);
        }
        let allowed = if are_estimates {
            "from 1e-30 to 1e30 in the mean over its neighbours; let the mask exclude the pixel, or trace more samples"
        } else {
            "a variance from 1e-30 to 1e30 where the mask does not exclude the pixel"
        };
        check_pixels(path, channel, allowed, |v| (1.0 / LARGEST..=LARGEST).contains(&v))?;
        channel.name = name.to_string();
    }
    Ok(variance)
}

/// Each pixel the mean of those of its 24 neighbours that count, at least [`LEAST`] of the mean of all, NaN if none does; 1 where it does
/// not count itself.
fn of_neighbours(image: &Image, counts: impl Fn(usize) -> bool) -> Image {
    let (width, height) = (image.width, image.height);
    let counted = || image.data.iter().enumerate().filter(|(i, _)| counts(*i)).map(|(_, v)| f64::from(*v));
    let least = LEAST * counted().sum::<f64>() / counted().count() as f64;
    Image::from_fn(width, height, |x, y| {
        if !counts(y * width + x) {
            return 1.0;
        }
        let rows = y.saturating_sub(AROUND)..(y + AROUND + 1).min(height);
        let around =
            rows.flat_map(|v| (x.saturating_sub(AROUND)..(x + AROUND + 1).min(width)).map(move |u| (u, v)));
        let known: Vec<f64> = around
            .filter(|&(u, v)| (u, v) != (x, y) && counts(v * width + u))
            .map(|(u, v)| f64::from(image.at(u, v)))
            .collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        if mean < least { least as f32 } else { mean as f32 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_the_neighbours_leaves_out_the_pixel_and_what_does_not_count() {
        let image = Image::from_fn(3, 3, |x, y| (3 * y + x) as f32);
        let mean = of_neighbours(&image, |i| i != 8);
        assert_eq!(mean.at(1, 1), (1 + 2 + 3 + 5 + 6 + 7) as f32 / 7.0);
        assert_eq!(mean.at(0, 0), (1 + 2 + 3 + 4 + 5 + 6 + 7) as f32 / 7.0);
        assert_eq!(mean.at(2, 2), 1.0);
        assert!(of_neighbours(&image, |i| i == 4).at(1, 1).is_nan());
        let dark = Image::from_fn(9, 9, |x, y| if (x, y) == (8, 8) { 81.0 } else { 0.0 });
        assert_eq!(of_neighbours(&dark, |_| true).at(1, 1), LEAST as f32);
    }
}
