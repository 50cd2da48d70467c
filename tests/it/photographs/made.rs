//! Small image files, byte by byte where writers hide what is tested.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::io::Cursor;
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::{Gray16, RGB16};

/// 8-bit codes as the maker of PNG files takes them.
pub fn codes(values: &[u8]) -> Vec<u16> {
    values.iter().map(|v| u16::from(*v)).collect()
}

/// A chunk with its checksum.
pub fn png_chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [&kind[..], data].concat();
    let crc = body.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { 0xedb8_8320 ^ (c >> 1) } else { c >> 1 })
    });
    [&(data.len() as u32).to_be_bytes()[..], &body, &(!crc).to_be_bytes()].concat()
}

/// A PNG file of 1 to 4 samples a pixel, of 16 bits if some value needs them, with `more` chunks after the header.
pub fn png(width: u32, height: u32, samples: usize, values: &[u16], more: &[u8]) -> Vec<u8> {
    use png::{BitDepth, ColorType, Encoder};
    let is_wide = values.iter().any(|v| *v > 255);
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(match samples {
        1 => ColorType::Grayscale,
        2 => ColorType::GrayscaleAlpha,
        3 => ColorType::Rgb,
        _ => ColorType::Rgba,
    });
    encoder.set_depth(if is_wide { BitDepth::Sixteen } else { BitDepth::Eight });
    let data: Vec<u8> = if is_wide {
        values.iter().flat_map(|v| v.to_be_bytes()).collect()
    } else {
        values.iter().map(|v| *v as u8).collect()
    };
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    // Signature and header take 33 bytes.
    [&bytes[..33], more, &bytes[33..]].concat()
}

/// A 16-bit TIFF file.
pub fn tiff16(width: u32, height: u32, samples: usize, values: &[u16]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
    if samples == 1 {
        encoder.write_image::<Gray16>(width, height, values).unwrap();
    } else {
        encoder.write_image::<RGB16>(width, height, values).unwrap();
    }
    bytes.into_inner()
}

/// A grey JPEG with an Exif block that states this orientation and sRGB.
pub fn jpeg_with_exif(width: u32, height: u32, value: impl Fn(u32, u32) -> u8, orientation: u8) -> Vec<u8> {
    let data: Vec<u8> = (0..width * height).map(|i| value(i % width, i / width)).collect();
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, 95);
    encoder.write_image(&data, width, height, ExtendedColorType::L8).unwrap();
    let entry = |tag: u16, kind: u16, value: [u8; 4]| {
        [&tag.to_be_bytes()[..], &kind.to_be_bytes(), &1_u32.to_be_bytes(), &value].concat()
    };
    let exif = [
        &b"Exif\0\0MM\0*\0\0\0\x08\0\x02"[..],
        &entry(0x0112, 3, [0, orientation, 0, 0]),
        &entry(0x8769, 4, 38_u32.to_be_bytes()),
        &[0; 4],
        &[0, 1],
        &entry(0xa001, 3, [0, 1, 0, 0]),
        &[0; 4],
    ]
    .concat();
    let length = (exif.len() as u16 + 2).to_be_bytes();
    [&bytes[..2], &[0xff, 0xe1], &length, &exif, &bytes[2..]].concat()
}
