//! EXR files: what is written comes back, other writers' files are understood, damaged ones are refused by name.

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Layer, LayerAttributes, WritableImage, f16,
};
use narrowbeam::Error;
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::exr::{ExrFile, size, write};
use proptest::prelude::{ProptestConfig, any, proptest};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

fn channel(name: &str, image: Image) -> Channel {
    Channel { name: name.into(), image }
}

fn texture(width: usize, height: usize) -> Image {
    Image::from_fn(width, height, |x, y| ((x * 7 + y * 13) % 31) as f32 / 31.0 + 1e-3 * x as f32)
}

fn file_in(dir: &Path, bytes: &[u8]) -> PathBuf {
    let path = dir.join("damaged.exr");
    // A file that is written over is flushed to the disk first.
    let _ = std::fs::remove_file(&path);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// A small file of three channels, as written here.
static SOUND: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let channels = ["R", "G", "B"].map(|name| channel(name, texture(8, 20)));
    write(&path, &channels, &[("software".into(), "narrowbeam".into())]).unwrap();
    std::fs::read(path).unwrap()
});

/// Reads all that can be read of `path`; a panic fails the test that calls this.
fn read_everything(path: &Path) -> Result<(), Error> {
    let _ = size(path);
    let file = ExrFile::read(path)?;
    let _ = (file.radiance(), file.depth(), file.single());
    Ok(())
}

#[test]
fn floats_come_back_bit_for_bit_with_their_provenance() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let channels = [channel("Y", texture(33, 17)), channel("Y.variance", Image::filled(33, 17, 1e-12))];
    let provenance = [("software", "narrowbeam"), ("version", "0.1.0"), ("command", "narrowbeam σ")];
    let provenance = provenance.map(|(key, value)| (key.to_string(), value.to_string()));
    write(&path, &channels, &provenance).unwrap();

    let file = ExrFile::read(&path).unwrap();
    assert_eq!(file.radiance().unwrap(), channels[..1]);
    assert_eq!(file.named("Y.variance").unwrap(), channels[1]);
    assert_eq!(size(&path).unwrap(), (33, 17));
    let meta = exr::meta::MetaData::read_from_file(&path, true).unwrap();
    let attributes = &meta.headers[0].own_attributes;
    let text = |key: &str| format!("{:?}", attributes.other[&exr::prelude::Text::from(key)]);
    assert_eq!(attributes.software_name.as_ref().unwrap().to_string(), "narrowbeam");
    assert!(
        text("narrowbeam:version").contains("0.1.0") && text("narrowbeam:command").contains("narrowbeam ?")
    );
}

#[test]
fn half_floats_and_integers_are_understood() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let halves = FlatSamples::F16(vec![f16::from_f32(0.25), f16::INFINITY]);
    let list = [AnyChannel::new("Z", halves), AnyChannel::new("id", FlatSamples::U32(vec![3, 4_000_000]))];
    let channels = AnyChannels::sort(list.into_iter().collect());
    let layer = Layer::new((2, 1), LayerAttributes::named("main"), Encoding::FAST_LOSSLESS, channels);
    exr::prelude::Image::from_layer(layer).write().to_file(&path).unwrap();

    let file = ExrFile::read(&path).unwrap();
    assert_eq!(file.depth().unwrap().image.data, [0.25, f32::INFINITY]);
    assert_eq!(file.named("id").unwrap().image.data, [3.0, 4e6]);
}

#[test]
fn several_parts_are_told_apart_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.exr");
    let part = |name: &str, value: f32| {
        let channels =
            AnyChannels::sort([AnyChannel::new("Y", FlatSamples::F32(vec![value]))].into_iter().collect());
        Layer::new((1, 1), LayerAttributes::named(name), Encoding::UNCOMPRESSED, channels)
    };
    let attributes = exr::meta::header::ImageAttributes::with_size((1, 1));
    let parts = [part("depth", 2.0), part("light", 0.5)];
    exr::prelude::Image::empty(attributes)
        .with_layer(parts[0].clone())
        .with_layer(parts[1].clone())
        .write()
        .to_file(&path)
        .unwrap();

    let file = ExrFile::read(&path).unwrap();
    assert_eq!(file.radiance().unwrap()[0].image.at(0, 0), 0.5);
    assert_eq!(file.depth().unwrap().image.at(0, 0), 2.0);
}

#[test]
fn a_truncated_file_is_refused_at_every_length() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = &*SOUND;
    for length in 0..bytes.len() {
        let path = file_in(dir.path(), &bytes[..length]);
        let error = read_everything(&path).expect_err("a truncated file");
        assert!(matches!(error, Error::Read { .. }), "{length}: {error}");
        assert!(error.to_string().starts_with(&path.display().to_string()), "{error}");
    }
}

#[test]
fn every_single_flipped_byte_is_survived() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = &*SOUND;
    for i in 0..bytes.len() {
        for flip in [0x01, 0x80] {
            let mut damaged = bytes.clone();
            damaged[i] ^= flip;
            let _ = read_everything(&file_in(dir.path(), &damaged));
        }
    }
}

#[test]
fn a_file_that_is_no_exr_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let error = ExrFile::read(&file_in(dir.path(), b"not an image at all")).unwrap_err();
    assert!(error.to_string().contains("damaged.exr: cannot be read"), "{error}");
}

#[test]
fn a_header_that_promises_more_than_the_file_can_hold_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let mut bytes = SOUND.clone();
    // The data window is the box of four i32 behind its name, type and length; the last two are the far corner.
    let name = b"dataWindow\0box2i\0";
    let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4 + 8;
    bytes[at..at + 4].copy_from_slice(&1_000_000_i32.to_le_bytes());
    bytes[at + 4..at + 8].copy_from_slice(&1_000_000_i32.to_le_bytes());
    let error = ExrFile::read(&file_in(dir.path(), &bytes)).unwrap_err();
    assert!(matches!(error, Error::Read { .. }), "{error}");
}

#[test]
fn a_directory_that_cannot_be_written_is_named() {
    let error = write(Path::new("/no/such/folder/a.exr"), &[channel("Y", texture(2, 2))], &[]).unwrap_err();
    assert!(error.to_string().starts_with("/no/such/folder/a.exr: cannot be written"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_damage_never_panics(
        seeds in proptest::collection::vec((any::<u16>(), any::<u8>()), 1..12),
        cut in proptest::option::of(any::<u16>()),
    ) {
        let mut bytes = SOUND.clone();
        let n = bytes.len();
        for (place, value) in seeds {
            bytes[place as usize % n] = value;
        }
        bytes.truncate(cut.map_or(n, |c| c as usize % n));
        let dir = tempfile::tempdir().unwrap();
        let _ = read_everything(&file_in(dir.path(), &bytes));
    }
}
