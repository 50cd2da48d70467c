//! Figure 4 as a picture and a table.

use crate::error::Result;
use crate::image::Image;
use crate::io::atomic;
use crate::lab::paper::Rings;
use crate::lab::paper::figure_4::{DEEPEST, FARTHEST};
use crate::plots::{Map, MapGrid, MapRow, Shade};
use std::path::Path;

/// The files of this figure.
pub(super) const FILES: [&str; 3] = ["fig4.png", "fig4.svg", "fig4.csv"];

/// Decades of the colour bar, and bands in each.
const DECADES: u8 = 3;
/// See [`DECADES`].
const PER_DECADE: u8 = 4;

/// Writes picture and table into `dir`.
///
/// # Errors
/// [`Error::Write`](crate::Error::Write) with the path.
pub(super) fn write(dir: &Path, rings: &[Rings]) -> Result<String> {
    atomic::write(&dir.join(FILES[2]), super::figure_6::profiles(rings).as_bytes())?;
    let sections: Vec<_> = rings.chunk_by(|a, b| a.spread_angle_deg == b.spread_angle_deg).collect();
    let grid = MapGrid {
        title: "Light per radius, 2πrΨ: traced on the left, kernels on the right; σt = 1, σs = 0.95".into(),
        rows: sections.iter().map(|section| row(section)).collect(),
        x_label: "r (mean free paths)".into(),
        x: -FARTHEST..FARTHEST,
        y: 0.0..DEEPEST,
        log: false,
        parted_at: Some(0.0),
        shade: Shade::Bands { max: brightest(rings), decades: DECADES, per_decade: PER_DECADE },
        value_label: "2πrΨ (share of all light per mean free path)".into(),
    };
    grid.write_png(&dir.join(FILES[0]))?;
    grid.write_svg(&dir.join(FILES[1]))?;
    Ok(String::new())
}

/// The power of ten at or above all values.
fn brightest(rings: &[Rings]) -> f64 {
    let traced = rings.iter().flat_map(|plane| plane.traced.iter().map(|t| t.value));
    let kernels = rings.iter().flat_map(|plane| plane.kernels.iter().flat_map(|k| &k.1)).copied();
    10f64.powf(traced.chain(kernels).fold(0.0, f64::max).log10().ceil())
}

/// The maps of one spread angle.
fn row(section: &[Rings]) -> MapRow {
    let map = |k: usize| {
        let count = section[0].traced.len();
        let value = |x: usize, z: usize| match x {
            x if x < count => section[z].traced[count - 1 - x].value,
            x => section[z].kernels[k].1[x - count],
        };
        Map {
            title: format!("traced | {}", section[0].kernels[k].0),
            values: Image::from_fn(2 * count, section.len(), |x, z| value(x, z) as f32),
            region: Vec::new(),
        }
    };
    MapRow {
        label: format!("{}°: z (mean free paths)", section[0].spread_angle_deg),
        maps: (0..section[0].kernels.len()).map(map).collect(),
    }
}
