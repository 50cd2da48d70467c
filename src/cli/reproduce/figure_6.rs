//! Figure 6 as a picture and tables.

use super::errors::{rows, text, write_csv};
use crate::error::Result;
use crate::io::atomic;
use crate::lab::paper::Rings;
use crate::plots::{Axis, ChartGrid, LineChart, Series};
use std::path::Path;

/// The files of this figure.
pub(super) const FILES: [&str; 4] = ["fig6.png", "fig6.svg", "fig6.csv", "fig6_errors.csv"];

/// Radii up to this many depths are drawn; beyond, there is almost no light.
const DRAWN: f64 = 1.5;

/// Writes picture and tables into `dir` and returns the errors for people.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write) with the path.
pub(super) fn write(dir: &Path, rings: &[Rings]) -> Result<String> {
    atomic::write(&dir.join(FILES[2]), profiles(rings).as_bytes())?;
    write_csv(&dir.join(FILES[3]), rings)?;
    let mut by_depth: Vec<&Rings> = rings.iter().collect();
    by_depth.sort_by(|a, b| a.z.total_cmp(&b.z));
    let charts = by_depth.chunk_by(|a, b| a.z == b.z).map(|row| row.iter().map(|r| chart(r)).collect());
    let grid = ChartGrid {
        title: "Light per radius at two albedos, spread angle 30°, σt = 1".into(),
        rows: charts.collect(),
    };
    grid.write_png(&dir.join(FILES[0]))?;
    grid.write_svg(&dir.join(FILES[1]))?;
    Ok(text(&rows(rings)?))
}

/// The light per radius of tracer and kernels, one line per ring.
pub(super) fn profiles(rings: &[Rings]) -> String {
    let mut csv = String::from("albedo,spread_angle_deg,z,r,traced,traced_std_error");
    rings.iter().take(1).flat_map(|plane| &plane.kernels).for_each(|(model, _)| csv += &format!(",{model}"));
    for plane in rings {
        for (i, traced) in plane.traced.iter().enumerate() {
            csv += &format!("\n{},{},{}", plane.albedo, plane.spread_angle_deg, plane.z);
            csv += &format!(",{:.5},{:.4e},{:.1e}", plane.radius(i), traced.value, traced.std_error);
            plane.kernels.iter().for_each(|(_, light)| csv += &format!(",{:.4e}", light[i]));
        }
    }
    csv + "\n"
}

/// The profiles at one plane: traced light with a band of one standard error to either side, and the kernels.
fn chart(plane: &Rings) -> LineChart {
    let count =
        plane.traced.iter().enumerate().take_while(|(i, _)| plane.radius(*i) < DRAWN * plane.z).count();
    let points = |values: &mut dyn Iterator<Item = f64>| -> Vec<(f64, f64)> {
        values.take(count).enumerate().map(|(i, v)| (plane.radius(i), v)).collect()
    };
    let errors = plane.traced.iter().map(|t| t.std_error).take(count).collect();
    let traced = points(&mut plane.traced.iter().map(|t| t.value));
    let mut series = vec![Series::reference("traced", traced, errors)];
    for (model, light) in &plane.kernels {
        series.push(Series::line(model.name(), points(&mut light.iter().copied())));
    }
    LineChart {
        title: format!("albedo {}, z = {}", plane.albedo, plane.z),
        x: Axis { label: "r (mean free paths)".into(), log: false },
        y: Axis { label: "2πrΨ (per mean free path)".into(), log: false },
        series,
    }
}
