//! Writing TIFF files of 32-bit floats.

use crate::image::Channel;
use std::io::{self, Cursor};
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::{Gray32Float, RGB32Float};

/// The file of one or three channels.
pub(super) fn encode(channels: &[Channel]) -> io::Result<Vec<u8>> {
    let image = &channels[0].image;
    let size = |side: usize| u32::try_from(side).map_err(io::Error::other);
    let (width, height) = (size(image.width)?, size(image.height)?);
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).map_err(io::Error::other)?;
    let written = if channels.len() == 1 {
        encoder.write_image::<Gray32Float>(width, height, &image.data)
    } else {
        let data: Vec<f32> =
            (0..image.data.len()).flat_map(|i| channels.iter().map(move |c| c.image.data[i])).collect();
        encoder.write_image::<RGB32Float>(width, height, &data)
    };
    written.map_err(io::Error::other)?;
    Ok(bytes.into_inner())
}
