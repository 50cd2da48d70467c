//! 8-bit PNG pictures of linear images, for viewing only: the numbers are in the EXR files.
//!
//! One channel becomes gray, three become R, G, B; see [`colour`](super::colour) for the transfer curve.

use super::atomic;
use super::colour::{Tone, diverging, residual_scale};
use crate::error::{Error, Result};
use crate::image::Channel;
use png::{ColorType, Compression, Encoder, Filter};
use std::io;
use std::path::Path;

/// Writes the picture of a radiance of one or three channels, exposed as `tone` says.
///
/// # Errors
/// [`Error::Write`] with the path.
///
/// # Panics
/// Unless there are one or three channels, all of one size.
pub fn write_picture(path: &Path, channels: &[Channel], tone: Tone) -> Result<()> {
    assert!(matches!(channels.len(), 1 | 3), "one channel or three");
    let colour = if channels.len() == 1 { ColorType::Grayscale } else { ColorType::Rgb };
    let (first, pixels) = (&channels[0].image, channels[0].image.data.len());
    let levels = |i: usize| channels.iter().map(move |c| tone.level(f64::from(c.image.data[i])));
    let bytes: Vec<u8> = (0..pixels).flat_map(levels).collect();
    write_bytes(path, &bytes, (first.width, first.height), colour)
}

/// Writes the picture of a residual in the diverging map, blue below 0 and red above, and returns the value that
/// has the full colour: `scale` if given, else the 99.5 % quantile of the magnitudes. Of three channels the mean is
/// shown. Pixels that are not a number are gray.
///
/// # Errors
/// [`Error::Write`] with the path.
///
/// # Panics
/// If there is no channel, or the channels differ in size.
pub fn write_residual(path: &Path, residual: &[Channel], scale: Option<f64>) -> Result<f64> {
    let mean = mean_of_channels(residual);
    let scale = scale.unwrap_or_else(|| residual_scale(std::slice::from_ref(&mean)));
    let image = &mean.image;
    let bytes: Vec<u8> = image.data.iter().flat_map(|&v| diverging(f64::from(v) / scale)).collect();
    write_bytes(path, &bytes, (image.width, image.height), ColorType::Rgb)?;
    Ok(scale)
}

/// Writes an RGB buffer, row by row from the top, as a PNG file, whole or not at all.
///
/// # Errors
/// [`Error::Write`] with the path.
pub fn write_rgb(path: &Path, rgb: &[u8], size: (usize, usize)) -> Result<()> {
    write_bytes(path, rgb, size, ColorType::Rgb)
}

/// The mean of all channels, pixel by pixel.
pub(crate) fn mean_of_channels(channels: &[Channel]) -> Channel {
    let mut image = channels[0].image.clone();
    for (i, value) in image.data.iter_mut().enumerate() {
        *value = channels.iter().map(|c| c.image.data[i]).sum::<f32>() / channels.len() as f32;
    }
    Channel { name: "mean".into(), image }
}

fn write_bytes(path: &Path, bytes: &[u8], size: (usize, usize), colour: ColorType) -> Result<()> {
    let file =
        encode(bytes, size, colour).map_err(|source| Error::Write { path: path.to_path_buf(), source })?;
    atomic::write(path, &file)
}

/// The PNG file of an RGB buffer.
#[cfg(feature = "plots")]
pub(crate) fn encode_rgb(rgb: &[u8], size: (usize, usize)) -> io::Result<Vec<u8>> {
    encode(rgb, size, ColorType::Rgb)
}

fn encode(bytes: &[u8], size: (usize, usize), colour: ColorType) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, size.0 as u32, size.1 as u32);
    encoder.set_color(colour);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    encoder.write_header()?.write_image_data(bytes)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    fn channel(name: &str, values: [f32; 2]) -> Channel {
        Channel { name: name.into(), image: Image { width: 2, height: 1, data: values.to_vec() } }
    }

    fn pixels(path: &Path) -> Vec<u8> {
        image::open(path).unwrap().into_rgb8().into_raw()
    }

    #[test]
    fn a_picture_has_the_transfer_curve_applied_once() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        // 0.215861 of white is the level 128.
        write_picture(&path, &[channel("Y", [0.431_721, 2.0])], Tone { white: 2.0 }).unwrap();
        assert_eq!(pixels(&path), [128, 128, 128, 255, 255, 255]);
        let rgb = [channel("R", [2.0, 0.0]), channel("G", [0.0, 2.0]), channel("B", [0.0, f32::NAN])];
        write_picture(&path, &rgb, Tone { white: 2.0 }).unwrap();
        assert_eq!(pixels(&path), [255, 0, 0, 0, 255, 0]);
    }

    #[test]
    fn a_residual_is_symmetric_and_states_its_scale() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.png");
        assert_eq!(write_residual(&path, &[channel("Y", [-0.5, 0.5])], None).unwrap(), 0.5);
        let p = pixels(&path);
        assert_eq!((&p[..3], &p[3..]), (&diverging(-1.0)[..], &diverging(1.0)[..]));
        assert_eq!(write_residual(&path, &[channel("Y", [0.0, 0.5])], Some(2.0)).unwrap(), 2.0);
        let p = pixels(&path);
        assert_eq!((&p[..3], &p[3..]), (&[255, 255, 255][..], &diverging(0.25)[..]));
    }
}
