//! Sweeps along which the camera is not as the scene says: where it looked, how sharp, how bright, how clean.

use super::{NOISE, Sweeps};
use crate::error::Result;
use crate::filter::moved;
use crate::filter::spline::{Waves, sampled};
use crate::fit::noise::with_noise;
use crate::image::Image;
use crate::imaging::Places;
use crate::lab::study::setting::Setting;
use crate::lab::study::trial::Trial;
use crate::scene::Gain;

impl Sweeps<'_> {
    /// All of them.
    pub(super) fn camera(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for px in [0.02, 0.05, 0.1, 0.3, 0.5, 1.0, 2.0] {
            trials.extend(self.seen("shift (px)", px, &moved(clean, [0.6 * px, 0.8 * px])?)?);
        }
        for degrees in [0.02, 0.1, 0.5, 2.0] {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let turned = resampled(clean, |[x, y]| [cos * x + sin * y, cos * y - sin * x]);
            trials.extend(self.seen("rotation (degrees)", degrees, &turned)?);
        }
        for change in [0.001, 0.003, 0.01, 0.03] {
            let scaled = resampled(clean, |place| place.map(|c| c / (1.0 + change)));
            trials.extend(self.seen("scale", change, &scaled)?);
        }
        for px in [0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
            trials.extend(self.seen("blur (px)", px, &blurred(clean, px))?);
        }
        let mean = clean.mean();
        for share in [0.001, 0.003, 0.01, 0.03, 0.1] {
            let veiled = by_place(clean, |[x, _], v| v + share * mean * x);
            trials.extend(self.seen("veil gradient", share, &veiled)?);
        }
        for share in [0.003, 0.01, 0.03, 0.1] {
            let darker = by_place(clean, |[x, y], v| v * (1.0 - share * (x * x + y * y)));
            trials.extend(self.seen("vignetting", share, &darker)?);
        }
        for gamma in [1.01, 1.03, 1.05, 1.1] {
            let bent = by_place(clean, |_, v| mean * (v.max(0.0) / mean).powf(gamma));
            trials.extend(self.seen("gamma", gamma, &bent)?);
        }
        trials.extend(self.cropped()?);
        trials.extend(self.noisy_object(clean)?);
        trials.extend(self.without_a_fault(clean)?);
        Ok(trials)
    }

    /// Fits of `image`, with the usual noise, seen in the base setting.
    fn seen(&self, sweep: &'static str, level: f64, image: &Image) -> Result<Vec<Trial>> {
        Ok(self.fits_of_camera(sweep, level, &self.noisy(&self.base, image)?))
    }

    /// A clear image no larger than the view, though the object goes on for some pixels.
    fn cropped(&self) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for px in [4, 16] {
            let whole = Setting { side: self.base.side + 2 * px, ..self.base };
            let inner =
                crate::image::View::centred((whole.side, whole.side), (self.base.side, self.base.side));
            let image = self.trace(&whole)?.crop(inner);
            let mut scene = self.noisy(&self.base, &image)?;
            scene.scene.object[0].image = whole.texture.image(whole.side).crop(inner);
            trials.extend(self.fits_of_camera("object beyond the frame (px)", px as f64, &scene));
        }
        Ok(trials)
    }

    /// A clear image that is noisy.
    fn noisy_object(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut trials = Vec::new();
        for share in [0.003, 0.01, 0.03] {
            let mut scene = self.noisy(&self.base, clean)?;
            let object = &mut scene.scene.object[0].image;
            *object = with_noise(object, share * object.mean(), self.seed + 7);
            object.data.iter_mut().for_each(|v| *v = v.max(0.0));
            trials.extend(self.fits_of_camera("noise of the clear image", share, &scene));
        }
        Ok(trials)
    }

    /// What is no fault: a gain that is free, noise that neighbours share, texture finer than a pixel.
    fn without_a_fault(&self, clean: &Image) -> Result<Vec<Trial>> {
        let mut scene = self.noisy(&self.base, clean)?;
        scene.observation.gain = Gain::Free;
        let mut trials = self.fits_of_camera("free gain", 1.0, &scene);
        for px in [0.3, 0.5, 0.7] {
            let still = Image::filled(clean.width, clean.height, 0.0);
            let white = with_noise(&still, NOISE * clean.mean(), self.seed);
            let noise = blurred(&white, px);
            let data = clean.data.iter().zip(&noise.data).map(|(v, n)| v + n).collect();
            let scene = self.base.scene(Image { data, ..*clean }, None)?;
            trials.extend(self.fits_of_camera("noise filtered by (px)", px, &scene));
        }
        let fine =
            Setting { side: 2 * self.base.side, pixel_pitch: 0.5 * self.base.pixel_pitch, ..self.base };
        let mut scene = self.noisy(&self.base, &binned(&self.trace(&fine)?))?;
        scene.scene.object[0].image = binned(&fine.texture.image(fine.side));
        scene.scene.sampling_is_known = false;
        trials.extend(self.fits_of_camera("texels a pixel", 2.0, &scene));
        Ok(trials)
    }
}

/// `f` of the place of every pixel, from the middle and in units of half the diagonal, and of its value.
fn by_place(image: &Image, f: impl Fn([f64; 2], f64) -> f64) -> Image {
    let Image { width, height, .. } = *image;
    let places = Places { width, height };
    let value = |i: usize| f(places.of(i), f64::from(image.data[i])) as f32;
    Image { width, height, data: (0..width * height).map(value).collect() }
}

/// `image` at other places: `from` tells where the value of a place comes from, both in px from the middle.
fn resampled(image: &Image, from: impl Fn([f64; 2]) -> [f64; 2] + Sync) -> Image {
    let Image { width, height, .. } = *image;
    let places = Places { width, height };
    let place = |i: usize| {
        let [u, v] = from(places.px(i));
        [u + 0.5 * width as f64 - 0.5, v + 0.5 * height as f64 - 0.5]
    };
    sampled(&[Waves::of(image).spline(0.0)], (width, height), place).remove(0).image
}

/// `image` blurred by a Gaussian of this standard deviation.
fn blurred(image: &Image, px: f64) -> Image {
    Waves::of(image).blurred(px * px)
}

/// The mean of every two by two pixels.
fn binned(image: &Image) -> Image {
    Image::from_fn(image.width / 2, image.height / 2, |x, y| {
        let sum: f32 =
            [(0, 0), (1, 0), (0, 1), (1, 1)].iter().map(|(i, j)| image.at(2 * x + i, 2 * y + j)).sum();
        0.25 * sum
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave() -> Image {
        Image::from_fn(24, 20, |x, y| (0.3 * x as f32).sin() + 0.5 * (0.2 * y as f32).cos())
    }

    #[test]
    fn a_place_moved_by_whole_pixels_shows_their_values() {
        let image = wave();
        let moved = resampled(&image, |[x, y]| [x - 2.0, y + 1.0]);
        assert!((moved.at(12, 10) - image.at(10, 11)).abs() < 1e-5);
        let still = resampled(&image, |place| place);
        assert!(still.data.iter().zip(&image.data).all(|(a, b)| (a - b).abs() < 1e-5));
    }

    #[test]
    fn a_blur_has_the_variance_that_it_is_said_to_have() {
        let mut point = Image::filled(31, 31, 0.0);
        point.data[15 * 31 + 15] = 1.0;
        for px in [0.3, 0.7, 1.3] {
            let spread = blurred(&point, px);
            let variance: f64 = (0..31)
                .flat_map(|y| (0..31).map(move |x| (x, y)))
                .map(|(x, y)| f64::from(spread.at(x, y)) * (x as f64 - 15.0).powi(2))
                .sum();
            // A narrow Gaussian has waves beyond half a cycle a pixel, which the image has not.
            assert!((variance - px * px).abs() < 1e-3, "{px}: {variance}");
        }
    }
}
