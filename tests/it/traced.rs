//! The model `traced`: replayed paths against fresh ones, and what it recovers from images that it did not make, or made of
//! other paths; of planes behind thick media more in `traced_planes`. That it agrees with the tracer is the agreement of a
//! program with itself: Mitsuba is the witness.

use crate::common::bundled::dataset;
use crate::common::edge_and_slope;
use crate::common::recovery::assert_recovered;
use crate::common::report::fit_scenes;
use crate::common::report::read;
use narrowbeam::filter::{Filter, Target};
use narrowbeam::fit::{ChannelFit, Observation, Settings, fit_channel};
use narrowbeam::forward::Tracing;
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::{Family, Gaussian, HenyeyGreenstein, PhaseFunction, b_of_spread_angle};
use narrowbeam::scene::{FitOptions, ObservedScene, read_truth};
use narrowbeam::spread::Model;
use narrowbeam::trace::{BATCHES, Hits, ImageConfig, Likelihood, Replay, trace_image};
use std::process::Command;

/// A checkerboard of unequal cells.
fn object(side: usize) -> Image {
    Image::from_fn(side, side, |x, y| if (x / 5 + y / 7) % 2 == 0 { 0.9 } else { 0.2 })
}

struct Setting {
    object: Image,
    geometry: Geometry,
}

impl Setting {
    fn config<P>(&self, medium: Medium<P>, samples: u32, seed: u64) -> ImageConfig<'_, P> {
        let (geometry, radiance) = (&self.geometry, &self.object);
        let view = View::whole(radiance.width, radiance.height);
        ImageConfig { geometry, radiance, behind: &[], border: Border::Mirror, view, medium, samples, seed }
    }

    fn traced(&self, medium: Medium<impl PhaseFunction + Copy>, samples: u32) -> Image {
        trace_image(&self.config(medium, samples, 1001), &|_| ()).unwrap().mean
    }

    fn fit(&self, observed: &Image, family: Family, paths: u64) -> ChannelFit {
        let relief = Filter::Auto.relief(&self.geometry);
        let view = View::whole(observed.width, observed.height);
        let target = Target {
            radiance: &self.object,
            behind: &[],
            geometry: &self.geometry,
            border: Border::Mirror,
            sampling: Sampling::Pixel,
            view,
            relief: relief.as_ref(),
        };
        let options = FitOptions { family, ..FitOptions::default() };
        let tracing = Tracing::new(Some(paths), 7);
        let settings = Settings { model: Model::Traced, tracing, ..Settings::default() };
        fit_channel(&[Observation::plain(target, observed)], &options, &settings, &|| ()).unwrap()
    }
}

/// Mean square difference of two images over the sum of their variances.
fn excess(a: &Image, b: &Image, variance: f64) -> f64 {
    let squares = a.data.iter().zip(&b.data).map(|(a, b)| f64::from(a - b).powi(2));
    squares.sum::<f64>() / a.data.len() as f64 / variance
}

#[test]
fn reweighted_hits_are_the_image_of_the_neighbouring_medium() {
    let setting = Setting { object: object(32), geometry: edge_and_slope(32) };
    let gaussian = |d: f64| Gaussian::new(b_of_spread_angle(d.to_radians())).unwrap();
    let hg = |g: f64| HenyeyGreenstein::new(g).unwrap();
    check_neighbour(&setting, gaussian(25.0), gaussian(29.0));
    check_neighbour(&setting, hg(0.9), hg(0.87));
}

fn check_neighbour<P: Likelihood>(setting: &Setting, from: P, to: P) {
    let (here, medium) = (Medium::new(0.8, 0.1, from).unwrap(), Medium::new(1.0, 0.3, to).unwrap());
    let hits = Hits::trace(&setting.config(here, 256, 5), &|_| ()).unwrap();
    let all = hits.image(&medium, 0..BATCHES).unwrap();
    let batches: Vec<Image> =
        (0..BATCHES).map(|b| hits.image(&medium, b..b + 1).unwrap().into_iter().next().unwrap()).collect();
    let n = BATCHES as f64;
    let own = batches.iter().map(|b| excess(b, &all[0], 1.0)).sum::<f64>() / (n * (n - 1.0));
    let fresh = trace_image(&setting.config(medium, 256, 6), &|_| ()).unwrap();
    let ratio = excess(&all[0], &fresh.mean, own + fresh.variance.mean());
    let stale = hits.image(hits.medium(), 0..BATCHES).unwrap();
    let unweighted = excess(&stale[0], &fresh.mean, own + fresh.variance.mean());
    println!("{from:?}: {ratio:.3} of what noise makes, without weights {unweighted:.1}");
    // chi² over 1024 pixels has the standard deviation .044; both variances are themselves estimates.
    assert!((ratio - 1.0).abs() < 0.25 && unweighted > 3.0, "{ratio} {unweighted}");
    assert!(hits.relative_sample_size(&medium) > 0.3);
    assert!((hits.relative_sample_size(hits.medium()) - 1.0).abs() < 1e-6);
}

#[test]
fn derivatives_of_hits_are_those_of_their_differences() {
    let setting = Setting { object: object(8), geometry: edge_and_slope(8) };
    check_derivatives(&setting, Gaussian::new(0.03).unwrap(), 0.033);
    check_derivatives(&setting, HenyeyGreenstein::new(0.9).unwrap(), 0.88);
}

fn check_derivatives<P: Likelihood>(setting: &Setting, from: P, shape: f64) {
    let medium = Medium::new(0.8, 0.1, from).unwrap();
    let hits = Hits::trace(&setting.config(medium, 64, 5), &|_| ()).unwrap();
    let at = |p: [f64; 3]| {
        let medium = Medium::new(p[0], p[1], P::of_parameter(p[2]).unwrap()).unwrap();
        hits.image(&medium, 0..BATCHES).unwrap()
    };
    let p = [0.9, 0.15, shape];
    let here = at(p);
    for i in 0..3 {
        let step = 3e-3 * p[i];
        let (mut up, mut down) = (p, p);
        up[i] += step;
        down[i] -= step;
        let (up, down) = (at(up), at(down));
        let difference = |k: usize| f64::from(up[0].data[k] - down[0].data[k]) / (2.0 * step);
        let squares = |f: &dyn Fn(usize) -> f64| (0..64).map(|k| f(k).powi(2)).sum::<f64>().sqrt();
        let off = squares(&|k| f64::from(here[1 + i].data[k]) - difference(k)) / squares(&difference);
        // The same paths on both sides: what is left is the square of the step, and rounding to f32.
        assert!(off < 2e-3, "{from:?} {i}: {off}");
    }
}

#[test]
fn what_a_path_remembers_gives_its_likelihood() {
    let gaussian = |b: f64| Gaussian::new(b).unwrap();
    let hg = |g: f64| HenyeyGreenstein::new(g).unwrap();
    check_likelihood(gaussian(0.03), gaussian(0.05), 1e-6);
    // ln(1 - g) as far off as the memory reaches, to either side: interpolation leaves some 1e-5.
    for to in [1.0 - 0.1 * 0.49_f64.exp(), 1.0 - 0.1 * (-0.49_f64).exp()] {
        check_likelihood(hg(0.9), hg(to), 1e-4);
    }
}

fn check_likelihood<P: Likelihood>(from: P, to: P, bound: f64) {
    let angles = [0.03_f32, 0.1, 0.3, 0.8, 2.5];
    let (record, mut memory) = (from.recorder(), P::Memory::default());
    angles.iter().for_each(|&angle| record(angle, &mut memory));
    let [old, new] = [(2.0, 0.1, from), (2.5, 0.3, to)]
        .map(|(sigma_s, sigma_a, phase)| Medium::new(sigma_s, sigma_a, phase).unwrap());
    let found = Replay::new(&old, &new).weight(5, 1.5, memory.as_ref()).ratio.ln();
    let turn = |&angle: &f32| (to.eval(f64::from(angle).cos()) / from.eval(f64::from(angle).cos())).ln();
    let turns = angles.iter().map(turn).sum::<f64>();
    let exact = 5.0 * 1.25_f64.ln() - 1.5 * 0.7 + turns;
    println!("{from:?} to {to:?}: {found} {exact}");
    assert!((found - exact).abs() < bound && turns.abs() > 100.0 * bound, "{from:?}: {found} {exact}");
}

#[test]
fn mitsubas_medium_comes_back_at_45_degrees() {
    let scene = ObservedScene::read(&dataset("wide-45/scene.toml")).unwrap();
    let truth = read_truth(&dataset("wide-45/truth.toml")).unwrap()[0];
    let fit = || {
        let tracing = Tracing::new(Some(1 << 18), 3);
        let settings = Settings { model: Model::Traced, tracing, ..Settings::default() };
        fit_scenes(std::slice::from_ref(&scene), &settings, Filter::Auto, &|| ()).unwrap()
    };
    let found = fit();
    assert_recovered("wide-45", &found.channels[0].1, truth);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(fit);
    assert_eq!(one.channels[0].1.parameters, found.channels[0].1.parameters);
}

#[test]
fn mitsubas_medium_comes_back_behind_edges() {
    let mut scene = ObservedScene::read(&dataset("mitsuba-planes/layers.toml")).unwrap();
    let truth = read_truth(&dataset("mitsuba-planes/truth.toml")).unwrap()[0];
    // The middle of the view, edges and all.
    let whole = scene.scene.view;
    let part = View { x: 80, y: 80, width: 96, height: 96 };
    scene.scene.view = View { x: whole.x + part.x, y: whole.y + part.y, ..part };
    let observation = &mut scene.observation;
    observation.image.iter_mut().for_each(|channel| channel.image = channel.image.crop(part));
    observation.mask = observation.mask.as_ref().map(|mask| mask.crop(part));
    let tracing = Tracing::new(Some(1 << 21), 3);
    let settings = Settings { model: Model::Traced, tracing, ..Settings::default() };
    let fit = fit_scenes(&[scene], &settings, Filter::Auto, &|| ()).unwrap();
    assert_recovered("mitsuba-planes", &fit.channels[0].1, truth);
}

#[test]
fn henyey_greensteins_lobe_comes_back_from_a_plane_and_from_a_depth_map() {
    let plane = Geometry::planar(48, 48, 0.05, 1.0).unwrap();
    let maps = [("plane", plane, 1 << 20), ("edge and slope", edge_and_slope(48), 1 << 22)];
    for (name, geometry, paths) in maps {
        let setting = Setting { object: object(48), geometry };
        let phase = HenyeyGreenstein::new(0.85).unwrap();
        let medium = Medium::new(1.2, 0.1, phase).unwrap();
        let fit = setting.fit(&setting.traced(medium, 1024), Family::HenyeyGreenstein, paths);
        assert_recovered(name, &fit, medium.with_phase(phase.into()));
    }
}

fn narrowbeam(arguments: &[&str]) -> (Option<i32>, String) {
    let out = Command::new(env!("CARGO_BIN_EXE_narrowbeam")).args(arguments).output().unwrap();
    (out.status.code(), String::from_utf8_lossy(&out.stderr).into_owned())
}

#[test]
fn the_command_line_traces_and_says_with_what() {
    let folder = tempfile::tempdir().unwrap();
    let scene = dataset("wide-45/scene.toml").display().to_string();
    let out = folder.path().join("fit").display().to_string();
    let (code, stderr) =
        narrowbeam(&["fit", &scene, "--model", "traced", "--paths", "65536", "--seed", "5", "--out", &out]);
    assert_eq!(code, Some(0), "{stderr}");
    let text = std::fs::read_to_string(folder.path().join("fit/fit.json")).unwrap();
    let report = read(&text);
    let traced = report.fit.traced.unwrap();
    assert_eq!((report.model.as_str(), traced.seed), ("traced", 5));
    assert!(traced.effective_share > 0.9);
    assert!(report.parameters["b"].model_error.unwrap() > 0.0);
    let image = folder.path().join("render.exr").display().to_string();
    let medium = ["--sigma-s", "2", "--sigma-a", "0.2", "--spread-angle-deg", "45"];
    let render = ["render", &scene, "--model", "traced", "--paths", "65536", "--output", &image];
    let (code, stderr) = narrowbeam(&[&render[..], &medium].concat());
    assert_eq!(code, Some(0), "{stderr}");
    // Where the table ends it says what does not.
    let thick = ["--sigma-s", "20", "--sigma-a", "0.2", "--spread-angle-deg", "45"];
    let beyond = ["render", &scene, "--model", "wide-angle", "--output", &image];
    let (code, stderr) = narrowbeam(&[&beyond[..], &thick].concat());
    assert!(
        code == Some(2) && stderr.contains("between 0 and 12") && stderr.contains("model traced"),
        "{stderr}"
    );
    for (wrong, named) in [
        (vec!["fit", &scene, "--model", "traced", "--filter", "eq29"], "eq29"),
        (vec!["fit", &scene, "--paths", "65536"], "--paths"),
        (vec!["fit", &scene, "--model", "traced", "--profile"], "--profile"),
        (
            vec![
                "kernel",
                "--sigma-s",
                "1",
                "--sigma-a",
                "0",
                "--b",
                "0.1",
                "--depth",
                "1",
                "--model",
                "traced",
                "--out",
                &out,
            ],
            "traced",
        ),
    ] {
        let (code, stderr) = narrowbeam(&wrong);
        assert!(code == Some(2) && stderr.contains(named), "{wrong:?}: {stderr}");
    }
}
