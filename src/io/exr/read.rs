//! Decoding an EXR file, whole, into f32 channels.

use super::damage::{believes_chunks, check_chunk, check_header, promise};
use crate::error::{Error, Result};
use crate::image::{Channel, Image};
use crate::io::input;
use crate::memory;
use ::exr::image::FlatSamples;
use ::exr::image::read::image::ReadLayers;
use ::exr::image::read::layers::ReadChannels;
use ::exr::meta::MetaData;
use std::io::Cursor;
use std::panic::{UnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

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
        let bytes = input::read(path, u64::MAX)?;
        let all = guarded(|| decode(&bytes)).map_err(|refusal| match refusal {
            Refusal::Damaged(reason) => Error::Read { path: path.to_path_buf(), reason },
            Refusal::TooLarge(error) => input::in_file(error, path),
        })?;
        Ok(Self { path: path.to_path_buf(), all })
    }
}

/// Width and height of the first part of an EXR file, px, without reading its pixels.
///
/// # Errors
/// [`Error::Read`] with the path if the file cannot be opened or its header is damaged.
pub fn size(path: &Path) -> Result<(usize, usize)> {
    let failed = |reason: String| Error::Read { path: path.to_path_buf(), reason };
    let file = input::open(path)?;
    let meta = guarded(|| MetaData::read_from_unbuffered(&file, false).map_err(reason)).map_err(failed)?;
    let header = meta.headers.first().ok_or_else(|| failed("it has no image".into()))?;
    Ok((header.layer_size.0, header.layer_size.1))
}

/// Runs the decoder. Damaged bytes are not known to make it panic; if they ever do, it is still the file's fault.
fn guarded<T, E: From<String>>(
    decode: impl FnOnce() -> std::result::Result<T, E> + UnwindSafe,
) -> std::result::Result<T, E> {
    catch_unwind(decode).unwrap_or_else(|_| Err("the decoder gave up on it".to_string().into()))
}

/// Why a file is not decoded.
enum Refusal {
    Damaged(String),
    TooLarge(Error),
}

impl From<String> for Refusal {
    fn from(reason: String) -> Self {
        Self::Damaged(reason)
    }
}

/// What the decoder's error means to the file's owner.
fn reason(error: ::exr::error::Error) -> String {
    match error {
        ::exr::error::Error::Invalid(what) => format!("no EXR file, or truncated or damaged ({what})"),
        other => other.to_string(),
    }
}

fn decode(bytes: &[u8]) -> std::result::Result<Vec<Channel>, Refusal> {
    let chunks = || ::exr::block::read(Cursor::new(bytes), false).map_err(reason);
    let image = chunks()?;
    let headers = image.headers();
    let mut needed = bytes.len() as u64;
    for header in headers {
        needed = needed.saturating_add(check_header(header, bytes.len())?);
    }
    let _held = memory::reserve(|| promise(headers), needed).map_err(Refusal::TooLarge)?;
    if headers.iter().any(believes_chunks) {
        for chunk in chunks()?.all_chunks(false).map_err(reason)? {
            check_chunk(headers, &chunk.map_err(reason)?)?;
        }
    }
    // One thread: a panic in another one could not be caught, and the images are small.
    let layers = ::exr::image::read::read().no_deep_data().largest_resolution_level();
    let reader = layers.all_channels().all_layers().all_attributes().non_parallel();
    let image = reader.from_chunks(image).map_err(reason)?;
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

fn to_f32(samples: FlatSamples) -> Vec<f32> {
    match samples {
        FlatSamples::F32(values) => values,
        other => other.values_as_f32().collect(),
    }
}
