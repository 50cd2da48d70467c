//! `kernel.csv` and `mtf.csv`.

use super::curves::{Curve, Grid};
use crate::error::Result;
use crate::io::atomic;
use std::path::Path;

/// Density and encircled energy.
pub(super) const KERNEL: &str = "kernel.csv";

/// Transfer functions.
const MTF: &str = "mtf.csv";

/// Writes both tables into `dir`. They have columns of standard errors only if a curve has some; `std_error` is that
/// of `encircled_energy`, or of `mtf`.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write) with the path.
pub(super) fn write(dir: &Path, grid: &Grid, curves: &[Curve]) -> Result<()> {
    let measured = curves.iter().any(|c| c.errors.is_some());
    let mut kernel = String::from("model,r,psf,encircled_energy");
    let mut mtf = String::from("model,k,mtf");
    if measured {
        kernel += ",std_error,psf_std_error";
        mtf += ",std_error";
    }
    kernel.push('\n');
    mtf.push('\n');
    for curve in curves {
        for (i, &r) in grid.radii.iter().enumerate() {
            let errors = curve.errors.as_ref().map(|e| [e.encircled[i], e.psf[i]]);
            kernel += &row(curve.name, &[r, curve.psf[i], curve.encircled[i]], measured, errors);
        }
        for (i, &k) in grid.frequencies.iter().enumerate() {
            let errors = curve.errors.as_ref().map(|e| [e.mtf[i]]);
            mtf += &row(curve.name, &[k, curve.mtf[i]], measured, errors);
        }
    }
    atomic::write(&dir.join(KERNEL), kernel.as_bytes())?;
    atomic::write(&dir.join(MTF), mtf.as_bytes())
}

/// One line: numbers in nine digits, then `N` columns of errors if there are such columns, empty without errors.
fn row<const N: usize>(name: &str, values: &[f64], measured: bool, errors: Option<[f64; N]>) -> String {
    let mut line = name.to_string();
    values.iter().for_each(|v| line += &format!(",{v:.8e}"));
    if measured {
        let cells = errors.map_or([const { String::new() }; N], |e| e.map(|v| format!("{v:.8e}")));
        cells.iter().for_each(|cell| line += &format!(",{cell}"));
    }
    line + "\n"
}
