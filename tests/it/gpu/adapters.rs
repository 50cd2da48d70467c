//! What may go wrong with a device: an error with advice each time, never a panic.

use super::gpu;
use super::scenes::Scene;
use crate::common::report::read;
use narrowbeam::Error;
use narrowbeam::filter::Optics;
use narrowbeam::filter::gpu::GpuFilter;
use narrowbeam::gpu::Gpu;
use narrowbeam::image::{Channel, Image};
use narrowbeam::io::exr;
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;
use std::process::Command;

fn optics(phase: &Gaussian) -> Optics {
    Optics { model: Model::SmallAngle, medium: Medium::new(0.8, 0.1, (*phase).into()).unwrap() }
}

#[test]
fn a_lost_device_is_an_error_with_advice() {
    let gpu = Gpu::open().unwrap();
    let scene = Scene::new("plane", (20, 16), |_, _| 2.0);
    let phase = Gaussian::new(1e-5).unwrap();
    let filter = GpuFilter::new(&gpu, scene.target(), &optics(&phase), 1.0).unwrap();
    filter.render(&optics(&phase)).unwrap();
    gpu.destroy();
    let error = filter.render(&optics(&phase)).unwrap_err();
    println!("{error}");
    assert!(matches!(error, Error::Gpu(_)) && error.to_string().contains("try again"), "{error}");
    assert!(!error.is_usage(), "the user is not to blame");
}

#[test]
fn a_buffer_that_cannot_be_bound_is_refused_with_both_sizes() {
    let most = gpu().adapter().most_bytes;
    let error = gpu().empty::<u8>("the object image", most as usize + 1).unwrap_err().to_string();
    println!("{error}");
    let mib = |bytes: u64| format!("{} MiB", bytes.div_ceil(1 << 20));
    assert!(
        error.contains("the object image") && error.contains(&mib(most + 1)) && error.contains(&mib(most))
    );
    assert!(gpu().empty::<u8>("a small one", 64).is_ok(), "the device goes on");
}

fn narrowbeam() -> Command {
    Command::new(env!("CARGO_BIN_EXE_narrowbeam"))
}

/// Without any driver the loader finds no adapter.
fn without_adapters(command: &mut Command) -> &mut Command {
    command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent")
}

#[test]
fn no_adapter_is_a_clear_message_for_who_asked_for_one() {
    let folder = tempfile::tempdir().unwrap();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/mitsuba-checker/scene.toml");
    let out = folder.path().join("fit");
    let mut command = narrowbeam();
    let run = |command: &mut Command| command.output().unwrap();
    let asked = run(without_adapters(command.args(["fit", scene, "--backend", "gpu", "--out"]).arg(&out)));
    let message = String::from_utf8_lossy(&asked.stderr);
    assert_eq!(asked.status.code(), Some(2), "{message}");
    assert!(message.contains("no graphics adapter") && message.contains("--backend cpu"), "{message}");
    assert!(!out.exists(), "nothing is written");
    let mut command = narrowbeam();
    let left_alone = run(without_adapters(command.args(["fit", scene, "--out"]).arg(&out)));
    assert_eq!(left_alone.status.code(), Some(0), "{}", String::from_utf8_lossy(&left_alone.stderr));
}

#[test]
fn reports_name_backend_adapter_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/mitsuba-checker/scene.toml");
    for (backend, kind) in [("gpu", "gpu"), ("cpu", "cpu"), ("auto", "cpu")] {
        let out = folder.path().join(backend);
        let output =
            narrowbeam().args(["fit", scene, "--backend", backend, "--out"]).arg(&out).output().unwrap();
        assert_eq!(output.status.code(), Some(0));
        let json = std::fs::read_to_string(out.join("fit.json")).unwrap();
        let backend = read(&json).backend;
        println!("{backend:?}");
        assert_eq!(backend.kind, kind);
        assert!(backend.reason.is_some());
        let adapter = backend.adapter.as_deref();
        assert_eq!(adapter.is_some(), kind == "gpu");
        let line = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(line.contains(adapter.unwrap_or("on cpu")), "{line}");
    }
}

/// A depth map large enough for `auto` to look for an adapter: it takes a real one, never a software one.
#[test]
fn auto_leaves_a_software_adapter_alone() {
    let folder = tempfile::tempdir().unwrap();
    let side = 420;
    let write = |name: &str, channel: &str, value: &dyn Fn(usize, usize) -> f32| {
        let channel = Channel { name: channel.into(), image: Image::from_fn(side, side, value) };
        exr::write(&folder.path().join(name), &[channel], &[]).unwrap();
    };
    let texture = crate::common::texture(side, side);
    write("object.exr", "Y", &|x, y| texture.at(x, y));
    write("observed.exr", "Y", &|x, y| 0.5 * texture.at(x, y));
    write("depth.exr", "Z", &|x, _| 2.0 + 0.001 * x as f32);
    let scene = folder.path().join("scene.toml");
    let text = "[object]\nradiance = \"object.exr\"\ndepth = \"depth.exr\"\n[camera]\npixel_pitch = 0.01\n\
                [observation]\nimage = \"observed.exr\"\n";
    std::fs::write(&scene, text).unwrap();
    let output = narrowbeam()
        .args(["fit", "--json", "--max-iterations", "1", "--out"])
        .args([&folder.path().join("fit"), &scene])
        .output()
        .unwrap();
    let backend = read(std::str::from_utf8(&output.stdout).unwrap()).backend;
    println!("{backend:?}");
    let software = gpu().adapter().software;
    assert_eq!(backend.kind, if software { "cpu" } else { "gpu" });
    assert_eq!(backend.reason.unwrap().contains("software"), software);
}

#[test]
fn a_render_on_the_device_is_the_cpus() {
    let folder = tempfile::tempdir().unwrap();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/datasets/mitsuba-slope/scene.toml");
    let render = |backend: &str| {
        let path = folder.path().join(backend).with_extension("exr");
        let medium = ["--sigma-s", "1", "--sigma-a", "0.1", "--b", "0.002"];
        let output = narrowbeam()
            .args(["render", scene, "--backend", backend])
            .args(medium)
            .arg("--output")
            .arg(&path)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        exr::ExrFile::read(&path).unwrap().all().to_vec()
    };
    let (cpu, gpu) = (render("cpu"), render("gpu"));
    let off = crate::common::relative_l2(
        crate::common::pixels(&gpu[0].image),
        crate::common::pixels(&cpu[0].image),
    );
    println!("apart by {off:.1e}");
    assert!(off > 0.0 && off < 1e-6, "{off}");
}
