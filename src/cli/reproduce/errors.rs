//! Tables of the kernels' relative rms errors.

use crate::error::Result;
use crate::io::atomic;
use crate::lab::compare::RmsError;
use crate::lab::paper::Rings;
use crate::spread::Model;
use std::fmt::Write;
use std::path::Path;

/// Number of rings that are merged into one for the second set of errors: 300 become 60.
const MERGED: usize = 5;

/// The errors of all models at one plane.
pub(super) struct Row<'a> {
    pub rings: &'a Rings,
    pub errors: Vec<(Model, RmsError)>,
}

/// The errors at each plane.
///
/// # Errors
/// [`Error::NotFinite`](crate::Error::NotFinite) where no light was traced.
pub(super) fn rows(rings: &[Rings]) -> Result<Vec<Row<'_>>> {
    rings.iter().map(|rings| Ok(Row { rings, errors: rings.errors()? })).collect()
}

/// Writes the errors, in all rings and in rings five times as wide.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write) with the path.
pub(super) fn write_csv(path: &Path, rings: &[Rings]) -> Result<()> {
    let mut csv = String::from("model,albedo,spread_angle_deg,z,rings,rms_error,std_error,noise\n");
    for plane in rings.iter().flat_map(|rings| [rings.clone(), rings.merged(MERGED)]) {
        for (model, RmsError { error, noise }) in plane.errors()? {
            csv += &format!(
                "{model},{},{},{},{},{:.5},{:.5},{noise:.5}\n",
                plane.albedo,
                plane.spread_angle_deg,
                plane.z,
                plane.traced.len(),
                error.value,
                error.std_error
            );
        }
    }
    atomic::write(path, csv.as_bytes())
}

/// The errors as a table for people.
pub(super) fn text(rows: &[Row]) -> String {
    let mut text = String::from("relative rms error of 2πrΨ over 0 < r < 3z\nalbedo  angle  z");
    let models = || rows.iter().take(1).flat_map(|row| &row.errors);
    models().for_each(|(model, _)| text += &format!("  {:>19}", model.name()));
    for Row { rings, errors } in rows {
        // Writing to a string cannot fail.
        let _ = write!(text, "\n{:6}  {:4}°  {}", rings.albedo, rings.spread_angle_deg, rings.z);
        errors.iter().for_each(|(_, e)| {
            text += &format!("  {:>10.4} ± {:.4}", e.error.value, e.error.std_error);
        });
    }
    text + "\n"
}
