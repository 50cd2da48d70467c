//! Slips of the pen that cost an afternoon are named, and only they.

use crate::cli::workshop::{SCENE, SIDE, Workshop, texture};
use narrowbeam::fit::{Severity, WarningCode, slips};
use narrowbeam::image::Image;
use narrowbeam::io::exr::ExrFile;
use narrowbeam::scene::ObservedScene;
use std::path::Path;

/// The cautions that the scene file `name` of `shop` gets.
fn found(shop: &Workshop, name: &str) -> Vec<WarningCode> {
    let scene = ObservedScene::read(&shop.file(name)).unwrap();
    let warnings = slips(&[scene]);
    assert!(warnings.iter().all(|w| w.severity == Severity::Caution && w.message.len() > 40));
    warnings.into_iter().map(|warning| warning.code).collect()
}

fn sound() -> Workshop {
    let shop = Workshop::new();
    shop.observe(SCENE);
    assert_eq!(found(&shop, "scene.toml"), []);
    shop
}

/// Replaces an image of `shop` by what `change` makes of it.
fn change(shop: &Workshop, name: &str, change: impl Fn(&Image) -> Image) {
    let image = ExrFile::read(&shop.file(name)).unwrap().radiance().unwrap().remove(0).image;
    std::fs::remove_file(shop.file(name)).unwrap();
    shop.put(name, &[("Y", change(&image))]);
}

#[test]
fn depth_and_pitch_in_two_units() {
    let shop = sound();
    for (from, to) in [("depth = 2.0", "depth = 2000.0"), ("pixel_pitch = 0.03", "pixel_pitch = 30")] {
        shop.write("scene.toml", &SCENE.replace(from, to));
        assert_eq!(found(&shop, "scene.toml"), [WarningCode::Units]);
    }
    let run = shop.run("render scene.toml --output out.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(run.stderr.contains("(units)") && run.stderr.contains("millimetres"), "{}", run.stderr);
}

#[test]
fn degrees_for_b() {
    let shop = sound();
    let run = shop.run("render scene.toml --b 8 --output out.exr");
    assert!(run.stderr.contains("spread_angle_deg"), "{}: {}", run.code, run.stderr);
    let run = shop.run("render scene.toml --b 0.1 --output out.exr");
    assert!(run.code == 0 && !run.stderr.contains("(units)"), "{}", run.stderr);
}

#[test]
fn images_in_two_units() {
    for factor in [1000.0, 1e-3] {
        let shop = sound();
        change(&shop, "observed.exr", |image| Image {
            data: image.data.iter().map(|v| factor * v).collect(),
            ..*image
        });
        assert_eq!(found(&shop, "scene.toml"), [WarningCode::Brightness]);
        let free = SCENE.replace("[medium]", "gain = \"free\"\n[medium]");
        shop.write("free.toml", &free);
        assert_eq!(found(&shop, "free.toml"), []);
    }
}

#[test]
fn images_swapped() {
    let shop = sound();
    let swapped = SCENE.replace("object.exr", "A").replace("observed.exr", "object.exr");
    let swapped = swapped.replace('A', "observed.exr");
    shop.write("swapped.toml", &swapped);
    assert!(found(&shop, "swapped.toml").contains(&WarningCode::SwappedImages), "{swapped}");
}

#[test]
fn images_flipped() {
    let flips: [fn(&Image) -> Image; 3] = [
        |i| Image::from_fn(SIDE, SIDE, |x, y| i.at(SIDE - 1 - x, y)),
        |i| Image::from_fn(SIDE, SIDE, |x, y| i.at(x, SIDE - 1 - y)),
        |i| Image::from_fn(SIDE, SIDE, |x, y| i.at(SIDE - 1 - x, SIDE - 1 - y)),
    ];
    for flip in flips {
        let shop = Workshop::new();
        shop.put("object.exr", &[("Y", uneven())]);
        shop.observe(SCENE);
        assert_eq!(found(&shop, "scene.toml"), []);
        change(&shop, "observed.exr", flip);
        assert_eq!(found(&shop, "scene.toml"), [WarningCode::FlippedImage]);
    }
}

/// The texture, brighter towards one corner.
fn uneven() -> Image {
    let texture = texture(0);
    Image::from_fn(SIDE, SIDE, |x, y| 0.2 * texture.at(x, y) + ((x + 2 * y) as f32 / SIDE as f32).powi(2))
}

#[test]
fn no_bundled_dataset_is_cautioned() {
    let datasets = Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets");
    let mut count = 0;
    for folder in std::fs::read_dir(datasets).unwrap().map(|entry| entry.unwrap().path()) {
        let files = std::fs::read_dir(&folder).into_iter().flatten().map(|entry| entry.unwrap().path());
        for path in files
            .filter(|path| path.extension().is_some_and(|e| e == "toml") && !path.ends_with("truth.toml"))
        {
            let scene = ObservedScene::read(&path).unwrap_or_else(|e| panic!("{e}"));
            let found = slips(&[scene]);
            assert!(found.is_empty(), "{}: {found:?}", path.display());
            count += 1;
        }
    }
    assert!(count >= 8, "{count} scenes");
}
