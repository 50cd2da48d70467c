//! The maps and curves of the stability study.

use crate::error::Result;
use crate::image::Image;
use crate::lab::study::grid::{Extent, METHODS};
use crate::lab::study::stability::OutcomeKind;
use crate::lab::study::trial::Trial;
use crate::phase::PhaseFunction;
use crate::plots::{Axis, ChartGrid, LineChart, Map, MapGrid, MapRow, Series, Shade};
use std::path::Path;

/// The files that [`write`] makes.
pub(super) const FILES: [&str; 6] = [
    "stability_error.png",
    "stability_error.svg",
    "stability_verdict.png",
    "stability_verdict.svg",
    "stability_sweeps.png",
    "stability_sweeps.svg",
];

/// The kinds of outcomes in their order, in colours that all can tell apart (Okabe and Ito 2008).
const VERDICTS: [(&str, [u8; 3]); 6] = [
    (OutcomeKind::Right.name(), [0, 158, 115]),
    (OutcomeKind::FalseAlarm.name(), [86, 180, 233]),
    (OutcomeKind::Undetermined.name(), [240, 228, 66]),
    (OutcomeKind::Warned.name(), [230, 159, 0]),
    (OutcomeKind::Refused.name(), [190, 190, 190]),
    (OutcomeKind::Silent.name(), [213, 94, 0]),
];

/// Maps in a row.
const COLUMNS: usize = 5;

pub(super) fn write(dir: &Path, trials: &[Trial], extent: &Extent) -> Result<()> {
    let errors = Shown {
        title: "Worst error of sigma_s, sigma_a z and B against traced images; outlined: where the program gives no warning",
        shade: Shade::Bands { max: 100.0, decades: 4, per_decade: 1 },
        label: "worst error (%), gray: nothing determined",
        value: |t| 100.0 * t.outcome.worst().unwrap_or(f64::NAN),
    };
    let errors = errors.maps(trials, extent);
    errors.write_png(&dir.join(FILES[0]))?;
    errors.write_svg(&dir.join(FILES[1]))?;
    let kinds = Shown {
        title: "What the program reports of its own fits to traced images; outlined: within the stated errors, no warning",
        shade: Shade::Categories(&VERDICTS),
        label: "",
        value: |t| f64::from(t.outcome.kind() as u8),
    };
    let kinds = kinds.maps(trials, extent);
    kinds.write_png(&dir.join(FILES[2]))?;
    kinds.write_svg(&dir.join(FILES[3]))?;
    let sweeps = curves(trials);
    sweeps.write_png(&dir.join(FILES[4]))?;
    sweeps.write_svg(&dir.join(FILES[5]))
}

/// What the maps over the grid show.
struct Shown {
    title: &'static str,
    shade: Shade,
    /// What the numbers are.
    label: &'static str,
    value: fn(&Trial) -> f64,
}

impl Shown {
    /// A map for each method.
    fn maps(&self, trials: &[Trial], extent: &Extent) -> MapGrid {
        let (width, height) = (extent.tau.len(), extent.spread_angle_deg.len());
        let map = |(m, name): (usize, String)| {
            let at = |x: usize, y: usize| &trials[(x * height + y) * METHODS.len() + m];
            let quiet = |i: usize| at(i % width, i / width).outcome.kind() == OutcomeKind::Right;
            Map {
                title: name,
                values: Image::from_fn(width, height, |x, y| (self.value)(at(x, y)) as f32),
                region: (0..width * height).map(quiet).collect(),
            }
        };
        let names: Vec<(usize, String)> = METHODS.iter().map(|m| m.name()).enumerate().collect();
        let row = |names: &[(usize, String)]| MapRow {
            label: "spread angle (degrees)".into(),
            maps: names.iter().cloned().map(map).collect(),
        };
        MapGrid {
            title: self.title.into(),
            rows: names.chunks(COLUMNS).map(row).collect(),
            x_label: "tau".into(),
            x: cells(&extent.tau),
            y: cells(&extent.spread_angle_deg),
            log: true,
            parted_at: None,
            shade: self.shade,
            value_label: self.label.into(),
        }
    }
}

/// The range whose cells have `values`, evenly spaced in their logarithms, at their centres.
fn cells(values: &[f64]) -> std::ops::Range<f64> {
    let (first, last) = (values[0], values[values.len() - 1]);
    let half = (last / first).powf(0.5 / (values.len() - 1) as f64);
    first / half..last * half
}

/// The sweeps along a number, and the meaning of that number.
const CURVES: [Curve; 18] = [
    Curve { sweep: "noise", label: "noise over mean radiance", log: false },
    Curve { sweep: "kernel width", label: "kernel width z sqrt(B) (px)", log: true },
    Curve { sweep: "depth error", label: "error of the depth, stated", log: false },
    Curve { sweep: "gain error", label: "error of the gain, stated", log: false },
    Curve { sweep: "Henyey-Greenstein g", label: "g of the true medium, Henyey-Greenstein", log: false },
    Curve { sweep: "varying sigma_s", label: "relative change of sigma_s, centre to side", log: true },
    Curve { sweep: "saturated share", label: "share of saturated pixels", log: true },
    Curve { sweep: "fitted g", label: "g of the true medium, fitted as such", log: false },
    Curve { sweep: "shift (px)", label: "shift of the observation (px)", log: true },
    Curve { sweep: "rotation (degrees)", label: "rotation of the observation (degrees)", log: true },
    Curve { sweep: "scale", label: "relative scale of the observation", log: true },
    Curve { sweep: "blur (px)", label: "blur of the observation alone (px)", log: true },
    Curve { sweep: "veil gradient", label: "veil at the corner over mean radiance", log: true },
    Curve { sweep: "vignetting", label: "light lost at the corner", log: true },
    Curve { sweep: "gamma", label: "exponent of the response", log: false },
    Curve { sweep: "object beyond the frame (px)", label: "object beyond the clear image (px)", log: false },
    Curve { sweep: "noise of the clear image", label: "noise of the clear image over its mean", log: true },
    Curve { sweep: "noise filtered by (px)", label: "filter of the noise (px)", log: false },
];

struct Curve {
    sweep: &'static str,
    /// What the number is.
    label: &'static str,
    /// Whether its axis is logarithmic.
    log: bool,
}

/// The worst error along each sweep; one row per sweep, one column per medium.
fn curves(trials: &[Trial]) -> ChartGrid {
    let row = |curve: &Curve| {
        let here: Vec<&Trial> = trials.iter().filter(|t| t.place.sweep == curve.sweep).collect();
        let mut media: Vec<f64> = here.iter().map(|t| t.setting.medium.phase().parameter()).collect();
        media.dedup();
        media.into_iter().map(|b| chart(&here, b, curve)).collect()
    };
    ChartGrid {
        title: "Worst error of sigma_s, sigma_a z and B; tau 1.5, images traced".into(),
        rows: CURVES.iter().map(row).collect(),
    }
}

fn chart(trials: &[&Trial], b: f64, curve: &Curve) -> LineChart {
    let here = || trials.iter().filter(|t| t.setting.medium.phase().parameter() == b);
    let mut methods: Vec<String> = here().map(|t| t.method.name()).collect();
    methods.sort();
    methods.dedup();
    let mut series: Vec<Series> = methods
        .iter()
        .map(|name| {
            let mine = here().filter(|t| t.method.name() == *name);
            Series::line(
                name,
                mine.filter_map(|t| Some((t.place.level, 100.0 * t.outcome.worst()?))).collect(),
            )
        })
        .collect();
    let wide = here().filter(|t| t.method.name() == "wide-angle");
    let allowed = wide.filter_map(|t| Some((t.place.level, 100.0 * t.outcome.allowed()?)));
    series.push(Series::line("wide-angle: 4 standard errors + model error", allowed.collect()));
    LineChart {
        title: format!("spread angle {:.0}°", (4.0 * b).sqrt().to_degrees()),
        x: Axis { label: curve.label.into(), log: curve.log },
        y: Axis { label: "worst error (%)".into(), log: true },
        series,
    }
}
