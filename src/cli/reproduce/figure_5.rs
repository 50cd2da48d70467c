//! Figure 5 as a picture and tables.

use super::errors::{Row, rows, text, write_csv};
use crate::error::Result;
use crate::lab::paper::Rings;
use crate::plots::{Axis, ChartGrid, LineChart, Series};
use std::path::Path;

/// The files of this figure.
pub(super) const FILES: [&str; 3] = ["fig5.png", "fig5.svg", "fig5.csv"];

/// Writes picture and table into `dir` and returns the table for people.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write) with the path.
pub(super) fn write(dir: &Path, rings: &[Rings]) -> Result<String> {
    write_csv(&dir.join(FILES[2]), rings)?;
    let rows = rows(rings)?;
    let mut depths: Vec<f64> = rings.iter().map(|plane| plane.z).collect();
    depths.sort_by(f64::total_cmp);
    depths.dedup();
    let grid = ChartGrid {
        title: "Error of the kernels against traced light, σt = 1, σs = 0.95".into(),
        rows: vec![depths.into_iter().map(|z| chart(z, &rows)).collect()],
    };
    grid.write_png(&dir.join(FILES[0]))?;
    grid.write_svg(&dir.join(FILES[1]))?;
    Ok(text(&rows))
}

/// The errors at depth `z`, and the noise of the tracing, which has been subtracted from them.
fn chart(z: f64, rows: &[Row]) -> LineChart {
    let here = || rows.iter().filter(|row| row.rings.z == z);
    let noise = here().map(|row| (row.rings.spread_angle_deg, row.errors[0].1.noise));
    let mut series = vec![Series::line("noise of tracing (subtracted)", noise.collect())];
    let models = rows.iter().take(1).flat_map(|row| &row.errors).map(|e| e.0);
    series.extend(models.enumerate().map(|(i, model)| {
        let points = here().map(|row| (row.rings.spread_angle_deg, row.errors[i].1.error.value));
        Series::line(model.name(), points.collect())
    }));
    LineChart {
        title: format!("z = {z} mean free path{}", if z == 1.0 { "" } else { "s" }),
        x: Axis { label: "spread angle sqrt(4B) (degrees)".into(), log: false },
        y: Axis { label: "relative rms error of 2πrΨ".into(), log: true },
        series,
    }
}
