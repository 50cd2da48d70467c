//! Decoding an EXR file, whole, into f32 channels.

use crate::error::{Error, Result};
use crate::image::{Channel, Image};
use ::exr::image::FlatSamples;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use std::io::Cursor;
use std::panic::{UnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// A part larger than this (16384 x 16384 px) is taken to be a damaged header.
const MAX_PIXELS: usize = 1 << 28;

/// No compression of EXR shrinks its data more than this; deflate, the strongest, reaches 1032. A file that
/// promises more is damaged, and believing it could exhaust the memory.
const MAX_COMPRESSION: usize = 2000;

/// Deviation of pixelAspectRatio from 1 up to which pixels are square.
const SQUARE: f32 = 1e-3;

/// Size of the largest image that is believed whatever the length of its file, bytes.
const SMALL_BYTES: usize = 1 << 22;

/// All channels of an EXR file.
#[derive(Debug, Clone)]
pub struct ExrFile {
    /// The file.
    pub path: PathBuf,
    /// Its channels in the order of the file, with the name of their part in front if there are several parts.
    pub(super) all: Vec<Channel>,
}

impl ExrFile {
    /// The channels `all` of the file `path`, which another reader has read.
    pub(crate) fn with_channels(path: &Path, all: Vec<Channel>) -> Self {
        Self { path: path.to_path_buf(), all }
    }

    /// All its channels.
    pub fn all(&self) -> &[Channel] {
        &self.all
    }

    /// Reads every channel of `path`.
    ///
    /// # Errors
    /// [`Error::Read`] with the path if the file cannot be opened, or is truncated, damaged, deep or subsampled.
    pub fn read(path: &Path) -> Result<Self> {
        let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
        let bytes = std::fs::read(path).map_err(|e| failed(e.to_string()))?;
        let channels = guarded(|| decode(&bytes)).map_err(failed)?;
        Ok(Self { path: path.to_path_buf(), all: channels })
    }
}

/// Width and height of the first part of an EXR file, px, without reading its pixels.
///
/// # Errors
/// [`Error::Read`] with the path if the file cannot be opened or its header is damaged.
pub fn size(path: &Path) -> Result<(usize, usize)> {
    let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
    let file = std::fs::File::open(path).map_err(|e| failed(e.to_string()))?;
    let meta = guarded(|| MetaData::read_from_unbuffered(&file, false).map_err(reason)).map_err(failed)?;
    let header = meta.headers.first().ok_or_else(|| failed("it has no image".into()))?;
    Ok((header.layer_size.0, header.layer_size.1))
}

/// Runs the decoder. Damaged bytes are not known to make it panic; if they ever do, it is still the file's fault.
fn guarded<T>(
    decode: impl FnOnce() -> std::result::Result<T, String> + UnwindSafe,
) -> std::result::Result<T, String> {
    catch_unwind(decode).unwrap_or_else(|_| Err("the decoder gave up on it".into()))
}

/// What the decoder's error means to the file's owner.
fn reason(error: ::exr::error::Error) -> String {
    match error {
        ::exr::error::Error::Invalid(what) => format!("no EXR file, or truncated or damaged ({what})"),
        other => other.to_string(),
    }
}

fn decode(bytes: &[u8]) -> std::result::Result<Vec<Channel>, String> {
    let chunks = ::exr::block::read(Cursor::new(bytes), false).map_err(reason)?;
    for header in chunks.headers() {
        check_header(header, bytes.len())?;
    }
    // One thread: a panic in another one could not be caught, and the images are small.
    let layers = ::exr::image::read::read().no_deep_data().largest_resolution_level();
    let reader = layers.all_channels().all_layers().all_attributes().non_parallel();
    let image = reader.from_chunks(chunks).map_err(reason)?;
    let several = image.layer_data.len() > 1;
    let mut channels = Vec::new();
    for layer in image.layer_data {
        let part = layer.attributes.layer_name.filter(|_| several).map(|name| name.to_string());
        for channel in layer.channel_data.list {
            channels.push(Channel {
                name: full_name(part.as_deref(), &channel.name.to_string()),
                image: Image { width: layer.size.0, height: layer.size.1, data: to_f32(channel.sample_data) },
            });
        }
    }
    Ok(channels)
}

/// The channel's name with that of its part in front, unless it already begins so (Blender writes it twice).
fn full_name(part: Option<&str>, channel: &str) -> String {
    match part {
        Some(part) if !channel.starts_with(&format!("{part}.")) => format!("{part}.{channel}"),
        _ => channel.to_string(),
    }
}

fn check_header(header: &Header, file_bytes: usize) -> std::result::Result<(), String> {
    let (width, height) = (header.layer_size.0, header.layer_size.1);
    if header.deep {
        return Err("deep images are not supported".into());
    }
    if header.channels.list.iter().any(|c| (c.sampling.0, c.sampling.1) != (1, 1)) {
        return Err("subsampled channels are not supported".into());
    }
    check_windows(header)?;
    let pixels = width.checked_mul(height).filter(|&n| n <= MAX_PIXELS);
    let bytes = pixels.and_then(|n| n.checked_mul(header.channels.bytes_per_pixel));
    let limit = file_bytes.saturating_mul(MAX_COMPRESSION).max(SMALL_BYTES);
    match bytes {
        Some(n) if n <= limit => Ok(()),
        _ => Err(format!("its header promises {width}x{height} px, which the file cannot hold")),
    }
}

/// Refuses pixels that are not square, and images that are a part of the picture that they belong to: where they lie in it is not
/// looked at.
fn check_windows(header: &Header) -> std::result::Result<(), String> {
    let aspect = header.shared_attributes.pixel_aspect;
    if (aspect - 1.0).abs() > SQUARE {
        return Err(format!("its pixelAspectRatio is {aspect}; resample it to square pixels"));
    }
    let (display, position) = (header.shared_attributes.display_window, header.own_attributes.layer_position);
    if (position, header.layer_size) != (display.position, display.size) {
        return Err(format!(
            "its data window, {}x{} px at ({}, {}), is not its display window, {}x{} px at ({}, {}); save the whole picture, or \
             crop it so that both are the same",
            header.layer_size.0,
            header.layer_size.1,
            position.0,
            position.1,
            display.size.0,
            display.size.1,
            display.position.0,
            display.position.1
        ));
    }
    Ok(())
}

fn to_f32(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        other => other.values_as_f32().collect(),
    }
}
