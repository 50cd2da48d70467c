//! Radiance HDR: RGB with a shared exponent.
//!
//! The decoder reads pixels only. What the header says of them is read here: exposures divide the numbers, and pictures that are
//! not stored row by row from the top, not of square pixels or not of RGB are refused.

use super::opened::{Header, Numbers, Opened};
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
