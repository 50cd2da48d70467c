//! Pictures of the kernels: density, encircled energy, transfer function.

use super::Setting;
use super::curves::{Curve, Errors, Grid};
use crate::error::Result;
use crate::plots::{Axis, LineChart, Series};
use std::f64::consts::PI;
use std::path::Path;

/// A traced curve shows one of this many points.
const POINT_EVERY: usize = 2;

/// One picture.
struct Chart {
    file: &'static str,
    title: &'static str,
    x: &'static str,
    y: &'static str,
    y_log: bool,
    values: fn(&Curve) -> &[f64],
    errors: fn(&Errors) -> &[f64],
    /// What values and errors at `x` are multiplied by.
    factor: fn(f64) -> f64,
}

const CHARTS: [Chart; 3] = [
    Chart {
        file: "kernel.png",
        title: "Scattered light per radius",
        x: "r (length)",
        y: "2πr·psf (share of all light per length)",
        y_log: true,
        values: |c| &c.psf,
        errors: |e| &e.psf,
        factor: |r| 2.0 * PI * r,
    },
    Chart {
        file: "encircled_energy.png",
        title: "Scattered light within r",
        x: "r (length)",
        y: "encircled energy (share of all light)",
        y_log: false,
        values: |c| &c.encircled,
        errors: |e| &e.encircled,
        factor: |_| 1.0,
    },
    Chart {
        file: "mtf.png",
        title: "Transfer function",
        x: "k (rad/length)",
        y: "M(k), direct light included (share of all light)",
        y_log: false,
        values: |c| &c.mtf,
        errors: |e| &e.mtf,
        factor: |_| 1.0,
    },
];

/// Writes `kernel.png`, `encircled_energy.png` and `mtf.png` into `dir`.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write) with the path.
pub(super) fn write(dir: &Path, setting: &Setting, grid: &Grid, curves: &[Curve]) -> Result<()> {
    for chart in &CHARTS {
        let places = if chart.file == "mtf.png" { &grid.frequencies } else { &grid.radii };
        chart.write(dir, setting, places, curves)?;
    }
    Ok(())
}

impl Chart {
    fn write(&self, dir: &Path, setting: &Setting, places: &[f64], curves: &[Curve]) -> Result<()> {
        let Setting { medium, z } = setting;
        let title = {
            let (sigma_s, sigma_a, phase) = (medium.sigma_s(), medium.sigma_a(), medium.phase());
            format!("{}: σs {sigma_s}, σa {sigma_a}, {phase}, depth {z}", self.title)
        };
        let series = curves.iter().map(|curve| self.series(curve, places)).collect();
        let axis = |label: &str, log: bool| Axis { label: label.into(), log };
        let chart = LineChart { title, x: axis(self.x, true), y: axis(self.y, self.y_log), series };
        chart.write_png(&dir.join(self.file))
    }

    fn series(&self, curve: &Curve, places: &[f64]) -> Series {
        // Frequency 0 has no place on a logarithmic axis.
        let scaled = |values: &[f64]| -> Vec<(f64, f64)> {
            let all = places.iter().zip(values).map(|(&x, v)| (x, (self.factor)(x) * v));
            all.filter(|p| p.0 > 0.0).collect()
        };
        let points = scaled((self.values)(curve));
        // It stays in the legend, so that a model has one colour in all pictures.
        let dark = self.y_log && points.iter().all(|p| p.1 <= 0.0);
        let name = if dark { format!("{} (none)", curve.name) } else { curve.name.to_string() };
        match &curve.errors {
            None => Series::line(name, points),
            Some(errors) => {
                let errors = scaled((self.errors)(errors)).into_iter().map(|p| p.1);
                let points = points.into_iter().step_by(POINT_EVERY).collect();
                Series::measured(name, points, errors.step_by(POINT_EVERY).collect())
            }
        }
    }
}
