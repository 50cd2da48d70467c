//! `synthesize`: object light and veil together, and what must be given.

use super::workshop::{SCENE, SIDE, Workshop, striped, texture};
use narrowbeam::image::Image;
use narrowbeam::io::exr::ExrFile;

const SUN: &str = "[illumination]\ndirection = [0.3, 0.1, 1.0]\nirradiance = 3.0\n";

fn read(shop: &Workshop, file: &str, names: &[&str]) -> Vec<Image> {
    let channels = ExrFile::read(&shop.file(file)).unwrap().channels(names).unwrap();
    channels.into_iter().map(|c| c.image).collect()
}

/// Largest difference between `a` and `b`, over the largest value of `b`.
fn worst(a: &Image, b: &Image) -> f32 {
    let most = b.data.iter().fold(0.0_f32, |m, v| m.max(v.abs()));
    a.data.iter().zip(&b.data).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) / most
}

/// The scene with a wall that only the sun lights; its reflectances of the channels `names` are put into albedo.exr.
fn reflecting(shop: &Workshop, names: &[&str]) -> String {
    let albedo = texture(0);
    let albedo = Image { data: albedo.data.iter().map(|v| 0.5 * v).collect(), ..albedo };
    shop.put("albedo.exr", &names.iter().map(|&name| (name, albedo.clone())).collect::<Vec<_>>());
    SCENE.replace("radiance = \"object.exr\"", "reflectance = \"albedo.exr\"") + SUN
}

#[test]
fn the_parts_add_up_and_object_light_is_what_render_gives() {
    let shop = Workshop::new();
    shop.write("scene.toml", &(striped(&shop, SIDE / 2) + SUN));
    assert_eq!(shop.run("render scene.toml --output render.exr").code, 0);
    let run = shop.run("synthesize scene.toml --output all.exr --parts parts.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    let parts = read(&shop, "parts.exr", &["clear.Y", "direct.Y", "scattered.Y", "veil.Y"]);
    let sum =
        |images: &[Image]| Image::from_fn(SIDE, SIDE, |x, y| images.iter().map(|image| image.at(x, y)).sum());
    // Roundings of f32.
    assert!(worst(&sum(&parts[1..3]), &read(&shop, "render.exr", &["Y"])[0]) < 1e-6);
    assert!(worst(&sum(&parts[1..]), &read(&shop, "all.exr", &["Y"])[0]) < 1e-6);
    assert_eq!(parts[0], read(&shop, "object.exr", &["Y"])[0]);
    let direct = Image::from_fn(SIDE, SIDE, |x, y| {
        parts[0].at(x, y) * (-0.9_f32 * if x < SIDE / 2 { 1.0 } else { 2.0 }).exp()
    });
    assert!(worst(&parts[1], &direct) < 1e-6);
    // The veil is that of the path before the object: more of it where it lies deeper.
    assert!(parts[3].at(SIDE - 1, 3) > 1.2 * parts[3].at(0, 3) && parts[3].at(0, 3) > 0.0);
}

#[test]
fn a_wrong_medium_gives_another_veil() {
    let shop = Workshop::new();
    shop.write("scene.toml", &(SCENE.to_string() + SUN));
    for (medium, name) in
        [("", "a.exr"), ("--sigma-s 0.88", "b.exr"), ("--b 0.0044", "c.exr"), ("--sigma-a 0.2", "d.exr")]
    {
        let run = shop.run(&format!("synthesize scene.toml --output o.exr --parts {name} {medium}"));
        assert_eq!(run.code, 0, "{}", run.stderr);
    }
    let veil = |name: &str| read(&shop, name, &["veil.Y"])[0].clone();
    assert_eq!(worst(&veil("a.exr"), &veil("a.exr")), 0.0);
    for name in ["b.exr", "c.exr", "d.exr"] {
        assert!(worst(&veil(name), &veil("a.exr")) > 0.02, "{name}");
    }
}

#[test]
fn colours_have_their_own_light_medium_and_bottom() {
    let shop = Workshop::new();
    let scene =
        reflecting(&shop, &["R", "G", "B"]).replace("sigma_a = 0.1", "sigma_a = [0.1, 0.1, 0.3]").replace(
            "irradiance = 3.0",
            "irradiance = [3.0, 1.5, 3.0]\nbottom = 2.0\nbottom_reflectance = [0.5, 0.5, 0.5]",
        );
    shop.write("scene.toml", &scene);
    let run = shop.run("synthesize scene.toml --output all.exr --parts parts.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    for part in ["clear", "direct", "scattered", "veil"] {
        let names = ["R", "G", "B"].map(|c| format!("{part}.{c}"));
        let images = read(&shop, "parts.exr", &names.each_ref().map(String::as_str));
        let [r, g, b] = [0, 1, 2].map(|i| images[i].mean());
        assert!((g / r - 0.5).abs() < 1e-6, "{part}");
        assert!(if part == "clear" { b == r } else { b < 0.9 * r }, "{part}: {r} {b}");
    }
    assert_eq!(shop.run("synthesize scene.toml --output picture.PNG").code, 0);
    assert_eq!(image::open(shop.file("picture.PNG")).unwrap().width() as usize, SIDE);
}

#[test]
fn light_through_the_medium_is_weakened_on_its_way_in() {
    let shop = Workshop::new();
    let absorber = reflecting(&shop, &["Y"]).replace("sigma_s = 0.8", "sigma_s = 0.0");
    shop.write("scene.toml", &absorber);
    assert_eq!(shop.run("synthesize scene.toml --output o.exr --parts parts.exr").code, 0);
    let parts = read(&shop, "parts.exr", &["clear.Y", "direct.Y", "scattered.Y", "veil.Y"]);
    // Two units down along the light, of cosine 1/sqrt(1.1), and two up.
    let both_ways = (-0.1 * 2.0 * (1.0 + 1.1_f64.sqrt())).exp();
    assert!((parts[1].mean() / parts[0].mean() / both_ways - 1.0).abs() < 1e-5);
    // Roundings of f32, and nothing.
    assert!(parts[2].mean().abs() < 1e-7 && parts[3].mean() == 0.0);
}

#[test]
fn a_veil_may_be_an_image() {
    let shop = Workshop::new();
    shop.put("veil.exr", &[("Y", texture(2))]);
    shop.write("scene.toml", &(SCENE.to_string() + "[illumination]\nimage = \"veil.exr\"\n"));
    let run = shop.run("synthesize scene.toml --output all.exr --parts parts.exr");
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert_eq!(read(&shop, "parts.exr", &["veil.Y"])[0], texture(2));
}

#[test]
fn bad_input_is_refused_by_name() {
    let shop = Workshop::new();
    shop.put("small.exr", &[("Y", Image::filled(5, 5, 0.1))]);
    shop.put("two.exr", &[("Y", Image::filled(SIDE, SIDE, 2.0))]);
    shop.put("minus.exr", &[("Y", Image::filled(SIDE, SIDE, -0.1))]);
    let sunny = SCENE.to_string() + SUN;
    let lit = reflecting(&shop, &["Y"]);
    let image = |name: &str| format!("{SCENE}[illumination]\nimage = \"{name}\"\n");
    let object = |keys: &str| lit.replace("[camera]", &format!("{keys}\n[camera]"));
    for (scene, words) in [
        (SCENE.to_string(), vec!["[illumination] is missing"]),
        (sunny.replace("direction", "direktion"), vec!["`direktion`", "illumination"]),
        (sunny.replace("1.0]", "-1.0]"), vec!["[illumination] direction", "never enters"]),
        (sunny.replace("[0.3, 0.1, 1.0]", "[0, 0, 0]"), vec!["[illumination] direction"]),
        (sunny.replace("irradiance = 3.0\n", ""), vec!["[illumination] irradiance is missing"]),
        (sunny.replace("3.0\n", "-3.0\n"), vec!["[illumination] irradiance = -3"]),
        (sunny.replace("3.0\n", "[1.0, 2.0, 3.0]\n"), vec!["[illumination] irradiance", "three values"]),
        (sunny.clone() + "normal = [0, -1, 0.1]\n", vec!["[illumination]", "normal"]),
        (sunny.clone() + "bottom = 1.5\n", vec!["[illumination] bottom = 1.5", "pixel (0, 0)", "below"]),
        (sunny.clone() + "bottom = -1\n", vec!["[illumination] bottom"]),
        (sunny.clone() + "bottom = 3\nbottom_reflectance = 1.1\n", vec!["[illumination] bottom_reflectance"]),
        (sunny.clone() + "bottom_reflectance = 0.1\n", vec!["[illumination] bottom is missing"]),
        (sunny.clone() + "image = \"two.exr\"\n", vec!["[illumination] image and direction"]),
        (sunny.replace("depth = 2.0", "depth = 2.0\nsurface = 2.5"), vec!["depth - surface", "pixel (0, 0)"]),
        (image("small.exr"), vec!["small.exr", "5x5", "view"]),
        (image("minus.exr"), vec!["minus.exr", "channel Y", "-0.1"]),
        (image("none.exr"), vec!["none.exr"]),
        (image("two.exr") + "irradiance = 1.0\n", vec!["[illumination] irradiance"]),
        (
            image("two.exr").replace("radiance = \"object", "reflectance = \"albedo"),
            vec!["[illumination] image"],
        ),
        (object("radiance = \"object.exr\""), vec!["[object] radiance and reflectance"]),
        (object("shading = \"small.exr\""), vec!["small.exr", "5x5"]),
        (object("shading = \"two.exr\""), vec!["two.exr", "channel Y", "between 0 and 1"]),
        (lit.replace("albedo.exr", "two.exr"), vec!["two.exr", "reflectance"]),
        (
            sunny.replace("[camera]", "shading = \"two.exr\"\n[camera]"),
            vec!["[object] shading", "reflectance"],
        ),
    ] {
        shop.write("scene.toml", &scene);
        let run = shop.run("synthesize scene.toml --output out.exr --parts parts.exr");
        assert_eq!(run.code, 2, "{scene}: {}", run.stderr);
        assert!(words.iter().all(|word| run.stderr.contains(word)), "{words:?}: {}", run.stderr);
        assert!(!shop.file("out.exr").exists() && !shop.file("parts.exr").exists());
    }
    shop.write("scene.toml", &sunny);
    for options in ["--output out.jpg", "--output out.exr --parts out.exr", "--output none/out.exr"] {
        assert_eq!(shop.run(&format!("synthesize scene.toml {options}")).code, 2, "{options}");
        assert!(!shop.file("out.exr").exists());
    }
}

#[test]
fn other_commands_refuse_an_object_without_its_own_light() {
    let shop = Workshop::new();
    shop.write("scene.toml", &reflecting(&shop, &["Y"]));
    for command in
        ["render scene.toml --output out.exr", "trace scene.toml --output out.exr", "fit scene.toml"]
    {
        let run = shop.run(command);
        assert_eq!(run.code, 2, "{command}");
        assert!(run.stderr.contains("[object] radiance is missing"), "{}", run.stderr);
    }
}
