//! Radiance HDR: RGB with a shared exponent.
//!
//! The decoder reads pixels only. What the header says of them is read here: exposures divide the numbers, and pictures that are
//! not stored row by row from the top, not of square pixels or not of RGB are refused.

use super::opened::{Header, Numbers, Opened};
use crate::image::Channel;
use zune_hdr::HdrDecoder;
use zune_hdr::zune_core::bytestream::ZCursor;
use zune_hdr::zune_core::options::DecoderOptions;

/// Longest header that is believed, bytes.
const HEADER_BYTES: usize = 1 << 16;

/// The header of a Radiance HDR file.
pub(super) fn open(bytes: &[u8]) -> Result<Opened<'_>, String> {
    let exposure = exposure(bytes)?;
    let options = DecoderOptions::default().set_max_width(usize::MAX).set_max_height(usize::MAX);
    let mut decoder = HdrDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| e.to_string())?;
    let size = decoder.dimensions().ok_or("has no size")?;
    let header = Header::plain(size, 3, Numbers::Radiance);
    let pixels = move || {
        let mut data = decoder.decode().map_err(|e| e.to_string())?;
        data.iter_mut().for_each(|v| *v /= exposure);
        Ok(data)
    };
    Ok(Opened { header, pixels: Box::new(pixels) })
}

/// The product of all exposures in the header.
fn exposure(bytes: &[u8]) -> Result<f32, String> {
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(HEADER_BYTES)]);
    let mut lines = header.lines();
    let mut exposure = 1.0;
    for line in lines.by_ref().take_while(|line| !line.is_empty()) {
        let Some((key, value)) = line.split_once('=').map(|(key, value)| (key.trim(), value.trim())) else {
            continue;
        };
        match key {
            "EXPOSURE" => match value.parse::<f32>() {
                Ok(v) if v.is_finite() && v > 0.0 => exposure *= v,
                _ => return Err(format!("its EXPOSURE is {value}")),
            },
            "FORMAT" if value != "32-bit_rle_rgbe" => return Err(format!("its FORMAT is {value}, not RGB")),
            "PIXASPECT" if value.parse() != Ok(1.0_f32) => {
                return Err(format!("its PIXASPECT is {value}; resample it to square pixels"));
            }
            _ => (),
        }
    }
    match lines.next() {
        Some(size) if size.starts_with("-Y ") => Ok(exposure),
        Some(size) => Err(format!(
            "its rows are not stored from the top: {}",
            size.chars().take(40).collect::<String>()
        )),
        None => Err("has no size".into()),
    }
}

/// The file of one or three channels, without compression. Grey is written as three equal colours: the format knows no other.
pub(super) fn encode(channels: &[Channel]) -> Vec<u8> {
    let image = &channels[0].image;
    let header = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", image.height, image.width);
    let mut bytes = header.into_bytes();
    for i in 0..image.data.len() {
        bytes.extend(rgbe([0, 1, 2].map(|c: usize| channels[c.min(channels.len() - 1)].image.data[i])));
    }
    bytes
}

/// Colours of 8 bits with the exponent of the largest of them; what is negative or no number is black.
fn rgbe(colours: [f32; 3]) -> [u8; 4] {
    let colours = colours.map(|v| f64::from(if v > 0.0 { v.min(1e38) } else { 0.0 }));
    let largest = colours.into_iter().fold(0.0, f64::max);
    if largest < 1e-38 {
        return [0; 4];
    }
    // The largest colour rounds to 128 to 255 in units of this power of two.
    let mut exponent = largest.log2().floor() as i32 - 7;
    if (largest * f64::from(-exponent).exp2()).round() > 255.0 {
        exponent += 1;
    }
    let [r, g, b] = colours.map(|v| (v * f64::from(-exponent).exp2()).round() as u8);
    [r, g, b, (exponent + 136).clamp(0, 255) as u8]
}
