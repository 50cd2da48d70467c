//! Image files of all formats in, and out.

use super::made::{codes, jpeg_with_exif, png, png_chunk, tiff16};
use narrowbeam::Error;
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::picture::{Embedded, Format, Picture, size, write};
use std::path::{Path, PathBuf};

fn file(dir: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = dir.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn values(path: &Path) -> Vec<Vec<f32>> {
    Picture::read(path).unwrap().file.all().iter().map(|c| c.image.data.clone()).collect()
}

#[test]
fn codes_of_png_and_tiff_are_read_exactly() {
    let dir = tempfile::tempdir().unwrap();
    let grey8 = file(dir.path(), "a.png", &png(2, 2, 1, &codes(&[0, 1, 128, 255]), &[]));
    assert_eq!(values(&grey8), [[0.0, 1.0, 128.0, 255.0]]);
    let of = |c: u16| [c, c + 1, c + 2];
    let all: Vec<u16> = [of(7), of(65_000), of(256), of(0)].concat();
    let expected = [[7.0, 65_000.0, 256.0, 0.0], [8.0, 65_001.0, 257.0, 1.0], [9.0, 65_002.0, 258.0, 2.0]];
    let rgb16 = file(dir.path(), "b.png", &png(2, 2, 3, &all, &[]));
    assert_eq!(values(&rgb16), expected);
    let tiff = file(dir.path(), "c.tif", &tiff16(2, 2, 3, &all));
    assert_eq!(values(&tiff), expected);
    let read = Picture::read(&tiff).unwrap();
    assert_eq!(read.codes.unwrap().in_words(), "16-bit TIFF");
    let names: Vec<String> = read.file.all().iter().map(|c| c.name.clone()).collect();
    assert_eq!(names, ["R", "G", "B"]);
}

#[test]
fn what_is_written_is_read_again() {
    let dir = tempfile::tempdir().unwrap();
    let image = |factor: f32| Image::from_fn(5, 3, |x, y| factor * (0.1 + x as f32 + 7.5 * y as f32));
    let grey = vec![Channel { name: "Y".into(), image: image(0.3) }];
    let colour: Vec<Channel> = [("R", 0.3), ("G", 1.7), ("B", 40.0)]
        .map(|(name, factor)| Channel { name: name.into(), image: image(factor) })
        .to_vec();
    for channels in [&grey, &colour] {
        for name in ["a.tif", "a.pfm", "a.exr"] {
            let path = dir.path().join(name);
            write(&path, channels, &[]).unwrap();
            let read = Picture::read(&path).unwrap();
            assert!(read.codes.is_none());
            for channel in channels {
                assert_eq!(read.file.named(&channel.name).unwrap().image, channel.image, "{name}");
            }
        }
        let path = dir.path().join("a.hdr");
        write(&path, channels, &[]).unwrap();
        for (written, read) in channels.iter().zip(Picture::read(&path).unwrap().file.all()) {
            for (a, b) in written.image.data.iter().zip(&read.image.data) {
                // Eight bits below the largest of three colours: of the darkest here a hundredth of that.
                let bound = colour[2].image.data.iter().fold(0.0_f32, |m, v| m.max(*v)) / 128.0;
                assert!((a - b).abs() < if channels.len() == 1 { a / 100.0 } else { bound }, "{a} {b}");
            }
        }
    }
    assert!(matches!(write(&dir.path().join("a.jpg"), &grey, &[]), Err(Error::Write { .. })));
    assert!(!dir.path().join("a.jpg").exists());
}

#[test]
fn exposures_of_radiance_files_are_divided_out() {
    let dir = tempfile::tempdir().unwrap();
    let head = |lines: &str, size: &str| {
        let text = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{lines}\n{size}\n");
        [text.as_bytes(), &[128, 64, 32, 129].repeat(2)].concat()
    };
    let plain = values(&file(dir.path(), "a.hdr", &head("", "-Y 1 +X 2")));
    let exposed = values(&file(dir.path(), "b.hdr", &head("EXPOSURE=2\nEXPOSURE=4\n", "-Y 1 +X 2")));
    assert_eq!(plain[0], [1.0, 1.0]);
    assert_eq!(exposed[0], [0.125, 0.125]);
    let refused = |bytes: &[u8]| Picture::read(&file(dir.path(), "c.hdr", bytes)).unwrap_err().to_string();
    assert!(refused(&head("", "+X 2 -Y 1")).contains("not stored from the top"));
    assert!(refused(&head("PIXASPECT=2\n", "-Y 1 +X 2")).contains("PIXASPECT"));
    assert!(refused(&head("EXPOSURE=0\n", "-Y 1 +X 2")).contains("EXPOSURE"));
}

#[test]
fn orientation_is_honoured_in_size_and_pixels() {
    let dir = tempfile::tempdir().unwrap();
    // A JPEG of 16x8 px, white on its left half, that is to be turned by a quarter to the right.
    let path = file(dir.path(), "a.jpg", &jpeg_with_exif(16, 8, |x, _| if x < 8 { 255 } else { 0 }, 6));
    assert_eq!(size(&path).unwrap(), (8, 16));
    let picture = Picture::read(&path).unwrap();
    let image = &picture.file.all()[0].image;
    assert_eq!((image.width, image.height), (8, 16));
    assert_eq!((image.at(4, 0), image.at(4, 15)), (255.0, 0.0));
    assert_eq!(picture.codes.unwrap().embedded, Some((Embedded::Srgb, "Exif colour space")));
}

#[test]
fn alpha_is_dropped_where_all_is_opaque_and_refused_elsewhere() {
    let dir = tempfile::tempdir().unwrap();
    let opaque = file(dir.path(), "a.png", &png(2, 1, 4, &codes(&[1, 2, 3, 255, 4, 5, 6, 255]), &[]));
    assert_eq!(values(&opaque), [[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]]);
    let clear = file(dir.path(), "b.png", &png(2, 1, 4, &codes(&[1, 2, 3, 255, 4, 5, 6, 254]), &[]));
    let message = Picture::read(&clear).unwrap_err().to_string();
    assert!(message.contains("b.png") && message.contains("(1, 0)") && message.contains("mask"), "{message}");
}

#[test]
fn what_a_png_says_of_its_curve_is_found() {
    let dir = tempfile::tempdir().unwrap();
    let embedded = |chunk: Vec<u8>| {
        let path = file(dir.path(), "a.png", &png(1, 1, 1, &codes(&[9]), &chunk));
        Picture::read(&path).unwrap().codes.unwrap().embedded
    };
    assert_eq!(embedded(Vec::new()), None);
    assert_eq!(embedded(png_chunk(b"sRGB", &[0])), Some((Embedded::Srgb, "sRGB chunk")));
    let gamma = |v: u32| embedded(png_chunk(b"gAMA", &v.to_be_bytes()));
    assert_eq!(gamma(100_000), Some((Embedded::Linear, "gAMA chunk")));
    let Some((Embedded::Gamma(power), _)) = gamma(45_455) else { panic!("a power") };
    assert!((power - 2.2).abs() < 1e-3);
}

#[test]
fn files_that_are_no_images_say_what_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let refused = |name: &str, bytes: &[u8]| {
        let error = Picture::read(&file(dir.path(), name, bytes)).unwrap_err();
        assert!(matches!(error, Error::Read { .. }));
        error.to_string()
    };
    assert!(refused("a.cr2", b"II*\0\x10\0\0\0CR\x02\0").contains("dcraw"));
    assert!(refused("a.heic", b"\0\0\0\x18ftypheic").contains("HEIF"));
    assert!(refused("a.webp", b"RIFF\0\0\0\0WEBPVP8 ").contains("WebP"));
    assert!(refused("a.png", b"plain text").contains("a.png"));
}

/// Every shortened or altered file is refused or read, but nothing panics, and no promise of pixels is believed.
#[test]
fn damaged_files_are_refused_by_name() {
    let dir = tempfile::tempdir().unwrap();
    let image = Image::from_fn(9, 7, |x, y| (x * y) as f32 + 0.5);
    let channels = [Channel { name: "Y".into(), image }];
    let written = |name: &str| {
        let path = dir.path().join(name);
        write(&path, &channels, &[]).unwrap();
        std::fs::read(path).unwrap()
    };
    let sound = [
        ("a.png", png(9, 7, 1, &(0..63).map(|v| v * 1000).collect::<Vec<_>>(), &[])),
        ("a.tif", written("w.tif")),
        ("a.pfm", written("w.pfm")),
        ("a.hdr", written("w.hdr")),
        ("a.jpg", jpeg_with_exif(24, 16, |x, y| (x * y) as u8, 1)),
    ];
    for (name, bytes) in &sound {
        assert!(Picture::read(&file(dir.path(), name, bytes)).is_ok(), "{name}");
        for length in (0..bytes.len()).step_by(7) {
            if let Err(error) = Picture::read(&file(dir.path(), name, &bytes[..length])) {
                assert!(error.to_string().contains(name), "{error}");
            } else {
                // Of what is cut off at the very end, no pixel is missing.
                assert!(length + 24 > bytes.len(), "{name} cut to {length} of {} bytes is read", bytes.len());
            }
        }
        for at in (0..bytes.len()).step_by(3) {
            let mut bad = bytes.clone();
            bad[at] ^= 0xff;
            let path = file(dir.path(), name, &bad);
            let _ = (Picture::read(&path), size(&path));
        }
    }
    let huge = file(dir.path(), "huge.pfm", b"Pf\n99999 99999\n-1.0\n\0\0\0\0");
    assert!(
        Picture::read(&huge).unwrap_err().to_string().contains("99999x99999 px, which the file cannot hold")
    );
    let wrap = file(dir.path(), "wrap.pfm", b"PF\n4294967296 4294967296\n-1.0\n\0\0\0\0");
    assert!(Picture::read(&wrap).is_err() && size(&wrap).is_err());
}

#[test]
fn formats_follow_from_content_and_names() {
    let dir = tempfile::tempdir().unwrap();
    let misnamed = file(dir.path(), "a.exr", &png(1, 1, 1, &codes(&[9]), &[]));
    assert_eq!(Picture::read(&misnamed).unwrap().codes.unwrap().format, Format::Png);
    assert_eq!(Format::of_name(Path::new("x/IMG.TIFF")), Some(Format::Tiff));
    assert_eq!(Format::of_name(Path::new("x/tiff")), None);
}
