//! Three charts, one below the other.

use super::SWEPT;
use crate::methods::Method;
use crate::row::Row;
use anyhow::Result;
use image::{GenericImage, RgbImage};
use narrowbeam::plots::{Axis, LineChart, Series};
use std::path::Path;

/// Sizes of the charts of time against width: timed and counted.
const TIMED: usize = 256;
const COUNTED: usize = 1024;

/// Writes them as one picture.
pub fn write(rows: &[Row], path: &Path) -> Result<()> {
    let folder = tempfile::tempdir()?;
    let mut whole: Option<RgbImage> = None;
    for (i, chart) in [against_error(rows), against_width(rows), counted(rows)].iter().enumerate() {
        let file = folder.path().join(format!("{i}.png"));
        chart.write_png(&file)?;
        let chart = image::open(&file)?.to_rgb8();
        let (width, height) = chart.dimensions();
        let whole = whole.get_or_insert_with(|| RgbImage::new(width, 3 * height));
        whole.copy_from(&chart, 0, i as u32 * height)?;
    }
    whole.expect("there are charts").save(path)?;
    Ok(())
}

fn log(label: impl Into<String>) -> Axis {
    Axis { label: label.into(), log: true }
}

/// The points of `rows`, by increasing x; no series without points.
fn series(name: String, rows: impl Iterator<Item = (f64, f64)>) -> Option<Series> {
    let mut points: Vec<(f64, f64)> = rows.collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    (!points.is_empty()).then(|| Series::line(name, points))
}

fn against_error(rows: &[Row]) -> LineChart {
    let (widths, n) = SWEPT;
    let swept = |width_px: f64, name: &'static str| {
        let mine = rows
            .iter()
            .filter(move |r| (r.n, r.width_px, r.slope, r.method.name()) == (n, width_px, true, name));
        series(
            format!("{name}, {width_px} px"),
            mine.filter_map(|r| r.frame().map(|(s, error)| (error, 1e3 * s))),
        )
    };
    let names = ["fft", "gather", "gaussians", "pyramid"];
    LineChart {
        title: format!("Whole frame of {n} x {n} px, software adapter: time against error"),
        x: log("error of the image, relative L2"),
        y: log("preparation and render (ms)"),
        series: names.iter().flat_map(|name| widths.map(|w| swept(w, name))).flatten().collect(),
    }
}

/// A contender's series for a whole frame, and for its render alone.
fn by_width(
    rows: &[Row],
    n: usize,
    method: Method,
    milliseconds: impl Fn(&Row) -> Option<[f64; 2]>,
) -> [Option<Series>; 2] {
    let mine: Vec<&Row> = rows.iter().filter(|r| r.n == n && r.slope && r.method == method).collect();
    let points =
        |i: usize| mine.iter().filter_map(|&r| Some((r.width_px, milliseconds(r)?[i]))).collect::<Vec<_>>();
    let name = method.name();
    [series(name.into(), points(0).into_iter()), series(format!("{name}, render"), points(1).into_iter())]
}

/// Whole frames by all contenders, then the renders of those whose preparation costs much.
fn frames_and_renders(by_width: impl Fn(Method) -> [Option<Series>; 2], names: &[&str]) -> Vec<Series> {
    let (mut frames, mut renders) = (Vec::new(), Vec::new());
    for method in Method::GRID.into_iter().filter(|m| names.contains(&m.name())) {
        let [frame, render] = by_width(method);
        frames.extend(frame);
        renders.extend(render.filter(|_| ["fft", "pyramid"].contains(&method.name())));
    }
    frames.extend(renders);
    frames
}

fn against_width(rows: &[Row]) -> LineChart {
    let timed = |r: &Row| r.timing.map(|t| [t.prepare + t.render, t.render].map(|s| 1e3 * s));
    let names = ["cpu", "fft", "gather", "gaussians", "pyramid"];
    LineChart {
        title: format!("Frame of {TIMED} x {TIMED} px, software adapter: time against width"),
        x: log("kernel width z·sqrt(B)/pitch (px)"),
        y: log("preparation and render, or render alone (ms)"),
        series: frames_and_renders(|method| by_width(rows, TIMED, method, timed), &names),
    }
}

fn counted(rows: &[Row]) -> LineChart {
    let counted = |r: &Row| {
        let [prepare, render] = r.work.map(|w| 1e3 * w.seconds());
        Some([prepare + render, render])
    };
    // The CPU filter does what `fft` does.
    let names = ["fft", "gather", "gaussians", "pyramid"];
    LineChart {
        title: format!("Frame of {COUNTED} x {COUNTED} px, counted: 10 Tflop/s, 400 GB/s, 5 µs a dispatch"),
        x: log("kernel width z·sqrt(B)/pitch (px)"),
        y: log("preparation and render, or render alone (ms)"),
        series: frames_and_renders(|method| by_width(rows, COUNTED, method, counted), &names),
    }
}
