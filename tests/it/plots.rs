//! The pictures: they are written, have the size they should have, and show what they should.
//! `NARROWBEAM_PICTURES=DIR` keeps them, to be looked at.

use narrowbeam::image::{Channel, Image};
use narrowbeam::io::colour::{Tone, residual_scale};
use narrowbeam::plots::{
    Axis, ChartGrid, Figure, LineChart, Mark, Panel, Series, Shade, Shape, Sign, Spread,
};
use std::path::PathBuf;

fn folder() -> (Option<tempfile::TempDir>, PathBuf) {
    match std::env::var_os("NARROWBEAM_PICTURES") {
        Some(dir) => (None, dir.into()),
        None => {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().to_path_buf();
            (Some(dir), path)
        }
    }
}

fn axis(label: &str, log: bool) -> Axis {
    Axis { label: label.into(), log }
}

/// Kernels of growing width under the names that the program gives them, and measured points.
fn kernels() -> LineChart {
    let radii: Vec<f64> = (0..200).map(|i| 1e-3 * 10f64.powf(3.0 * f64::from(i) / 199.0)).collect();
    let names = ["single-scatter", "gaussian", "narrow-beam-printed", "narrow-beam", "small-angle"];
    let psf = |width: f64, r: f64| (-(r / width).powf(1.3)).exp() / (width * width);
    let mut series: Vec<Series> = names
        .iter()
        .enumerate()
        .map(|(i, name)| {
            let width = 0.02 * (1.0 + 0.6 * i as f64);
            Series::line(*name, radii.iter().map(|&r| (r, psf(width, r))).collect())
        })
        .collect();
    let traced: Vec<_> = radii.iter().step_by(14).map(|&r| (r, psf(0.05, r))).collect();
    let errors = traced.iter().map(|p| 0.3 * p.1).collect();
    series.push(Series::measured("traced", traced, errors));
    LineChart {
        title: "Kernel at depth 2, σs 0.95, σa 0.05, B 0.0049".into(),
        x: axis("radius (length)", true),
        y: axis("psf (1/length²)", true),
        series,
    }
}

#[test]
fn a_line_chart_is_drawn_in_the_colours_of_its_series() {
    let (_keep, dir) = folder();
    let chart = kernels();
    chart.write_png(&dir.join("kernels.png")).unwrap();
    chart.write_svg(&dir.join("kernels.svg")).unwrap();
    let picture = image::open(dir.join("kernels.png")).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (1200, 760));
    // Blue, the first of the palette: legend and line.
    assert!(picture.pixels().filter(|p| p.0 == [0, 114, 178]).count() > 300);
    let svg = std::fs::read_to_string(dir.join("kernels.svg")).unwrap();
    assert!(svg.contains("narrow-beam-printed") && svg.contains("radius (length)"));
}

#[test]
fn linear_axes_and_bands_are_drawn() {
    let (_keep, dir) = folder();
    let points: Vec<_> = (0..60).map(|i| (f64::from(i) * 0.5, (-0.02 * f64::from(i)).exp())).collect();
    let spread = Spread::Band(points.iter().map(|p| 0.05 + 0.002 * p.0).collect());
    let first = Series { spread, ..Series::line("small-angle", points.clone()) };
    let second = Series::line("narrow-beam", points.iter().map(|p| (p.0, 0.9 * p.1)).collect());
    let chart = LineChart {
        title: "Transfer function".into(),
        x: axis("spatial frequency k (rad/length)", false),
        y: axis("mtf", false),
        series: vec![first, second],
    };
    chart.write_png(&dir.join("mtf.png")).unwrap();
    assert_eq!(image::open(dir.join("mtf.png")).unwrap().width(), 1200);
}

#[test]
fn signs_have_the_colour_of_their_place_and_a_nameless_series_no_legend() {
    let (_keep, dir) = folder();
    let sign = |shape, filled, place, x: f64| Series {
        mark: Mark::Signs(Sign { shape, filled }, place),
        ..Series::line("", vec![(x, 1.0), (2.0 * x, 3.0)])
    };
    let level =
        Series { mark: Mark::Thin { dashed: true }, ..Series::line("level", vec![(1.0, 2.0), (20.0, 2.0)]) };
    let mut series = vec![level];
    for (i, shape) in [Shape::Round, Shape::Triangle, Shape::Diamond].into_iter().enumerate() {
        series.push(sign(shape, true, Some(8), 1.0 + i as f64));
        series.push(sign(shape, false, None, 5.0 + i as f64));
    }
    let chart = LineChart { title: "Signs".into(), x: axis("x", true), y: axis("y", true), series };
    let grid = ChartGrid { title: "Signs".into(), rows: vec![vec![chart.clone(), chart]] };
    grid.write_png(&dir.join("signs.png")).unwrap();
    let picture = image::open(dir.join("signs.png")).unwrap().into_rgb8();
    let violet = picture.enumerate_pixels().filter(|(.., p)| p.0 == [112, 48, 160]).map(|(_, y, _)| y);
    let rows: Vec<u32> = violet.collect();
    // Two panels of six filled signs of some 80 px; above the panels, in the legend, none.
    assert!(rows.len() > 500 && rows.iter().all(|&y| y > 90), "{}", rows.len());
}

#[test]
fn a_chart_without_points_is_empty_but_drawn() {
    let (_keep, dir) = folder();
    let chart = LineChart { series: vec![Series::line("none", vec![(0.0, f64::NAN)])], ..kernels() };
    chart.write_png(&dir.join("empty.png")).unwrap();
}

#[test]
fn a_figure_shows_each_panel_with_its_bar() {
    let (_keep, dir) = folder();
    let channel = |image: Image| vec![Channel { name: "Y".into(), image }];
    let wave = |x: usize, y: usize| (1.0 + (x as f32 * 0.4).sin() * (y as f32 * 0.3).cos()) / 2.0;
    let object = channel(Image::from_fn(96, 96, wave));
    let observed = channel(Image::from_fn(64, 64, |x, y| 0.1 + 0.2 * wave(x + 16, y + 16)));
    let residual = channel(Image::from_fn(64, 64, |x, y| 1e-3 * ((x * 31 + y * 17) % 23) as f32 - 0.011));
    let tone = Tone::of(&observed);
    let panel = |title: &str, channels: &[Channel], shade| Panel {
        title: title.into(),
        channels: channels.to_vec(),
        shade,
    };
    let row = |cells: [&str; 4]| cells.map(String::from).to_vec();
    let figure = Figure {
        title: "Fit of a slanted plane, model small-angle, filter eq29".into(),
        panels: vec![
            panel("object (radiance)", &object, Shade::Radiance(Tone::of(&object))),
            panel("observed (radiance)", &observed, Shade::Radiance(tone)),
            panel("render (radiance)", &observed, Shade::Radiance(tone)),
            panel("residual (radiance)", &residual, Shade::Diverging { scale: residual_scale(&residual) }),
        ],
        columns: 4,
        table: vec![
            row(["parameter", "value", "std. error", "status"]),
            row(["σs (1/length)", "0.951", "± 0.002", "free"]),
            row(["σa (1/length)", "0.051", "± 0.001", "free"]),
            row(["B (rad²)", "0.00490", "± 0.00001", "free"]),
        ],
        notes: vec!["reduced χ² 1.02 over 4096 px, 9 iterations".into()],
    };
    figure.write_png(&dir.join("fit.png")).unwrap();
    let picture = image::open(dir.join("fit.png")).unwrap().into_rgb8();
    assert!(picture.width() > 1200 && picture.height() > 400, "{:?}", picture.dimensions());
    let rgb = |name: &'static str, i: usize| Channel {
        name: name.into(),
        image: object[0].image.crop(narrowbeam::image::View { x: 8 * i, y: 0, width: 64, height: 32 }),
    };
    let colour = [rgb("R", 0), rgb("G", 1), rgb("B", 2)];
    let small = Figure {
        columns: 2,
        table: vec![],
        notes: vec![],
        panels: vec![
            panel("colour", &colour, Shade::Radiance(Tone::of(&colour))),
            panel("residual", &residual, Shade::Diverging { scale: 0.02 }),
            panel("third", &observed, Shade::Radiance(tone)),
            panel("sequential", &observed, Shade::from_zero(&observed)),
        ],
        ..figure
    };
    small.write_png(&dir.join("grid.png")).unwrap();
}
