//! Images that cameras and editors write: PNG, TIFF, JPEG, Radiance HDR, PFM.
//!
//! A decoder gives the numbers of the file. Those of PNG, JPEG and integer TIFF are codes, which a [`Transfer`](super::transfer)
//! turns into radiance; those of the others are radiance. Images are turned as their Exif orientation says. An alpha channel is
//! dropped if every pixel is opaque; otherwise the file is refused, since what shines through is not known.
//!
//! Every file passes `admit` with the size that its header promises before anything of that size is allocated.

mod exif;
mod format;
mod hdr;
mod icc;
mod jpeg;
mod opened;
mod orientation;
mod pfm;
mod png;
mod tiff;
mod tiff_write;
mod write;

pub use format::Format;
pub use opened::Embedded;
pub use write::{OUTPUTS, is_output, write};

use super::exr::{self, ExrFile};
use super::input;
use crate::error::{Error, Result};
use crate::image::{Channel, Image};
use crate::memory;
use opened::{Header, Numbers, Opened};
use std::io::Read;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// The channels of an image file of any format.
pub type ImageFile = ExrFile;

/// An image larger than this (16384 x 16384 px) is taken to be a damaged header.
const MAX_PIXELS: usize = 1 << 28;
/// No compression of these formats shrinks its data more than this; deflate reaches 1032. A file that promises more is damaged.
const MAX_COMPRESSION: usize = 2000;
/// Bytes that a number takes while it is decoded: as it is in the file, as f32, and as f32 of a channel.
const DECODED_BYTES: usize = 16;
/// First bytes by which formats are told apart.
const START_BYTES: u64 = 32;
/// Size of the largest image that is believed whatever the length of its file, bytes.
const SMALL_BYTES: usize = 1 << 22;

/// An image file and what its numbers are.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Its channels: `Y` if it is grey, else `R`, `G`, `B`; those of an EXR file as they are called there.
    pub file: ImageFile,
    /// What the numbers are, if they are codes; `None` if they are proportional to radiance already.
    pub codes: Option<Codes>,
}

/// Numbers that are not yet radiance.
#[derive(Debug, Clone, PartialEq)]
pub struct Codes {
    /// The format.
    pub format: Format,
    /// The largest code: 255 or 65535.
    pub largest: u32,
    /// What the file says of its transfer curve, and where it says so.
    pub embedded: Option<(Embedded, &'static str)>,
}

impl Codes {
    /// What the file is, in words: `8-bit PNG`.
    pub fn in_words(&self) -> String {
        format!("{}-bit {}", if self.largest > 255 { 16 } else { 8 }, self.format.name())
    }
}

impl Picture {
    /// Reads the image file `path`, whatever its format, which its first bytes tell.
    ///
    /// # Errors
    /// [`Error::Read`] with the path and what the file is, if it cannot be opened, is damaged or of a kind that is not read.
    pub fn read(path: &Path) -> Result<Self> {
        let Some(format) = other_format(path)? else {
            return Ok(Self { file: ExrFile::read(path)?, codes: None });
        };
        let bytes = input::read(path, u64::MAX)?;
        let header = guarded(|| Ok(open(format, &bytes)?.header)).map_err(|e| of_format(path, format, &e))?;
        let (width, height) = header.size;
        let held = memory::reserve(
            || format!("its image of {width}x{height} px"),
            memory::product(&[width, height, header.samples, DECODED_BYTES]),
        );
        let _held = held.map_err(|e| input::in_file(e, path))?;
        let (channels, codes) =
            guarded(|| decode(format, &bytes)).map_err(|e| of_format(path, format, &e))?;
        Ok(Self { file: ImageFile::with_channels(path, channels), codes })
    }

    /// Its only channel of interest. Grey that is stored in three equal colours is one channel.
    ///
    /// # Errors
    /// As [`ImageFile::single`].
    pub fn single(&self) -> Result<Channel> {
        match self.file.all() {
            [red, green, blue] if red.image == green.image && red.image == blue.image => {
                Ok(Channel { name: "Y".into(), image: red.image.clone() })
            }
            _ => self.file.single(),
        }
    }
}

fn failed(path: &Path, reason: String) -> Error {
    Error::Read { path: path.to_path_buf(), reason }
}

fn of_format(path: &Path, format: Format, reason: &str) -> Error {
    failed(path, format!("{} file: {reason}", format.name()))
}

/// The format of the file `path`, if it is none that the reader of EXR files is to judge.
fn other_format(path: &Path) -> Result<Option<Format>> {
    let mut start = Vec::new();
    let file = input::open(path)?;
    file.take(START_BYTES).read_to_end(&mut start).map_err(|e| failed(path, e.to_string()))?;
    let format = Format::of_bytes(&start).map_err(|reason| failed(path, reason))?;
    Ok(format.filter(|format| *format != Format::Exr))
}

/// Width and height of the image in `path`, px, as it stands upright, without reading its pixels.
///
/// # Errors
/// [`Error::Read`] as [`Picture::read`].
pub fn size(path: &Path) -> Result<(usize, usize)> {
    let Some(format) = other_format(path)? else { return exr::size(path) };
    let bytes = input::read(path, u64::MAX)?;
    guarded(|| Ok(open(format, &bytes)?.header.upright_size())).map_err(|e| of_format(path, format, &e))
}

/// Runs a decoder. Damaged bytes are not known to make one panic; if they ever do, it is still the file's fault.
fn guarded<T>(decode: impl FnOnce() -> std::result::Result<T, String>) -> std::result::Result<T, String> {
    catch_unwind(AssertUnwindSafe(decode)).unwrap_or_else(|_| Err("the decoder gave up on it".into()))
}

fn open(format: Format, bytes: &[u8]) -> std::result::Result<Opened<'_>, String> {
    let opened = match format {
        Format::Png => png::open(bytes),
        Format::Tiff => tiff::open(bytes),
        Format::Jpeg => jpeg::open(bytes),
        Format::Hdr => hdr::open(bytes),
        Format::Pfm => pfm::open(bytes),
        Format::Exr => Err("has a reader of its own".into()),
    }?;
    admit(&opened.header, bytes.len())?;
    Ok(opened)
}

/// Refuses an image that the file, `file_bytes` long, cannot hold or that is too large to be decoded.
fn admit(header: &Header, file_bytes: usize) -> std::result::Result<(), String> {
    let (width, height) = header.size;
    let pixels = width.checked_mul(height).filter(|&n| n > 0 && n <= MAX_PIXELS);
    let bytes = pixels.and_then(|n| n.checked_mul(header.pixel_bytes()));
    match bytes {
        Some(n) if n <= file_bytes.saturating_mul(MAX_COMPRESSION).max(SMALL_BYTES) => Ok(()),
        _ => Err(format!("its header promises {width}x{height} px, which the file cannot hold")),
    }
}

fn decode(format: Format, bytes: &[u8]) -> std::result::Result<(Vec<Channel>, Option<Codes>), String> {
    let Opened { header, pixels } = open(format, bytes)?;
    let values = pixels()?;
    let (width, height) = header.size;
    if values.len() != width * height * header.samples {
        return Err("has fewer pixels than its header promises".into());
    }
    let plane = |c: usize| Image {
        width,
        height,
        data: values.iter().skip(c).step_by(header.samples).copied().collect(),
    };
    let (colours, names): (usize, &[&str]) =
        if header.samples < 3 { (1, &["Y"]) } else { (3, &["R", "G", "B"]) };
    if header.samples > colours {
        check_opaque(&plane(colours), header.numbers)?;
    }
    let upright = |c: usize| orientation::upright(plane(c), header.orientation);
    let channels =
        names.iter().enumerate().map(|(c, name)| Channel { name: (*name).into(), image: upright(c) });
    let codes = match header.numbers {
        Numbers::Radiance => None,
        Numbers::Codes { largest } => Some(Codes { format, largest, embedded: header.embedded }),
    };
    Ok((channels.collect(), codes))
}

/// Refuses a pixel through which something shines.
fn check_opaque(alpha: &Image, numbers: Numbers) -> std::result::Result<(), String> {
    let opaque = match numbers {
        Numbers::Codes { largest } => largest as f32,
        Numbers::Radiance => 1.0,
    };
    match alpha.data.iter().position(|&a| a != opaque) {
        None => Ok(()),
        Some(i) => Err(format!(
            "its pixel ({}, {}) is not opaque: flatten the image, and give the transparent part as a mask",
            i % alpha.width,
            i / alpha.width
        )),
    }
}
