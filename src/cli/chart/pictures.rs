//! The charts: one panel per dataset.

use super::points::{Clock, Points};
use crate::error::Result;
use crate::filter::{Backend, Filter};
use crate::lab::study::chart::{Charted, Way};
use crate::phase::{Phase, PhaseFunction};
use crate::plots::{Axis, ChartGrid, LineChart, Mark, Series, Shape, Sign};
use crate::spread::Model;
use std::path::Path;

/// The files that [`write`] makes.
pub(super) const FILES: [&str; 4] = ["renders.png", "renders.svg", "fits.png", "fits.svg"];

/// Panels in a row.
const COLUMNS: usize = 3;
/// Colour of everything but models.
const OTHER: usize = Model::ALL.len();

/// Draws `charted`; `adapter` is the graphics adapter.
pub(super) fn write(dir: &Path, charted: &[Charted], clock: Clock, adapter: Option<&str>) -> Result<()> {
    let adapter = adapter.map_or(String::new(), |adapter| format!("; gpu: {adapter}"));
    let renders = grid(format!("Renders in the true medium{adapter}"), charted, |c| render_panel(c, clock));
    renders.write_png(&dir.join(FILES[0]))?;
    renders.write_svg(&dir.join(FILES[1]))?;
    let fits = grid(format!("Fits of sigma_s, sigma_a and B{adapter}"), charted, |c| fit_panel(c, clock));
    fits.write_png(&dir.join(FILES[2]))?;
    fits.write_svg(&dir.join(FILES[3]))
}

fn grid(title: String, charted: &[Charted], panel: impl Fn(&Charted) -> LineChart) -> ChartGrid {
    let rows = charted.chunks(COLUMNS).map(|row| row.iter().map(&panel).collect()).collect();
    ChartGrid { title, rows }
}

fn round(filled: bool) -> Sign {
    Sign { shape: Shape::Round, filled }
}

fn signs(name: &str, sign: Sign, place: Option<usize>, points: Vec<(f64, f64)>) -> Series {
    Series { mark: Mark::Signs(sign, place), ..Series::line(name, points) }
}

fn place(model: Model) -> usize {
    Model::ALL.iter().position(|&m| m == model).expect("all are in there")
}

/// The line of the front, and that of the floor over the same times as all points.
fn lines(points: &Points, floor: &str) -> [Series; 2] {
    let times = || points.all.iter().flatten().map(|p| p.0);
    let ends = [times().fold(f64::INFINITY, f64::min), times().fold(0.0, f64::max)];
    let level = points.floor.map_or(Vec::new(), |floor| ends.map(|time| (time, floor)).to_vec());
    let thin =
        |name: &str, dashed, points| Series { mark: Mark::Thin { dashed }, ..Series::line(name, points) };
    [thin("Pareto front", false, points.steps()), thin(floor, true, level)]
}

/// Legend entries that say what signs mean.
fn key(entries: &[(&str, Sign)]) -> Vec<Series> {
    entries.iter().map(|&(name, sign)| signs(name, sign, None, Vec::new())).collect()
}

fn title(charted: &Charted) -> String {
    let truth = charted.dataset.truth[0];
    let phase = match truth.phase() {
        Phase::Gaussian(phase) => format!("{:.0}°", phase.spread_angle().to_degrees()),
        Phase::HenyeyGreenstein(phase) => format!("g {}", phase.parameter()),
    };
    format!("{}: tau {:.1}, {phase}", charted.dataset.name, truth.tau(charted.dataset.z))
}

fn render_panel(charted: &Charted, clock: Clock) -> LineChart {
    let points = Points::of_renders(charted, clock).percent();
    let reliefs =
        charted.renders.iter().any(|t| matches!(t.way, Way::Filter { filter: Filter::Composite, .. }));
    let at = |wanted: &dyn Fn(&Way, &str) -> bool| -> Vec<(f64, f64)> {
        let trials = charted.renders.iter().zip(&points.all);
        trials.filter(|(t, _)| wanted(&t.way, t.backend)).filter_map(|(_, point)| *point).collect()
    };
    let cpu = Backend::Cpu.name();
    let mut series: Vec<Series> = Model::ALL
        .iter()
        .enumerate()
        .map(|(m, model)| signs(model.name(), round(true), Some(m), Vec::new()))
        .collect();
    let traced = at(&|way, _| matches!(way, Way::Trace { .. }));
    series.push(Series::line("tracer, more and more paths", traced.clone()));
    series.push(signs("", round(true), Some(OTHER), traced));
    for (shape, ours) in [(Shape::Triangle, Filter::Eq29), (Shape::Round, Filter::Composite)] {
        for filled in [false, true] {
            for &model in &Model::ALL {
                let found = at(&|way, backend| match *way {
                    Way::Filter { model: m, filter, .. } => {
                        let drawn_as = if reliefs { filter } else { Filter::Composite };
                        m == model && drawn_as == ours && (backend == cpu) == filled
                    }
                    Way::Trace { .. } => false,
                });
                series.push(signs("", Sign { shape, filled }, Some(place(model)), found));
            }
        }
    }
    let triangle = Sign { shape: Shape::Triangle, filled: true };
    series.extend(key(&[
        ("filled: on the CPU", round(true)),
        ("open: on the gpu", round(false)),
        ("eq29 where composite differs", triangle),
    ]));
    series.extend(lines(&points, "floor: noise of the truth"));
    LineChart {
        title: title(charted),
        x: Axis { label: format!("render, prepared ({})", clock.unit()), log: true },
        y: Axis { label: "rms error of the image (%)".into(), log: true },
        series,
    }
}

fn fit_panel(charted: &Charted, clock: Clock) -> LineChart {
    let points = Points::of_fits(charted, clock).percent();
    let at = |model: Option<Model>, on_cpu: bool| -> Vec<(f64, f64)> {
        let wanted = |backend: &str| (backend == Backend::Cpu.name()) == on_cpu;
        let trials = charted.fits.iter().zip(&points.all);
        let ours = trials.filter(|(t, _)| t.method.model == model && wanted(t.backend));
        ours.filter_map(|(_, point)| *point).collect()
    };
    let diamond = |filled: bool| Sign { shape: Shape::Diamond, filled };
    let mut series: Vec<Series> = Model::ALL
        .iter()
        .enumerate()
        .map(|(m, model)| signs(model.name(), round(true), Some(m), Vec::new()))
        .collect();
    let way = charted.peer.iter().map(|step| (clock.of_step(step), 100.0 * step.error)).collect();
    series.push(Series { mark: Mark::Broad, ..Series::line("peer: Mitsuba, step by step", way) });
    series.push(signs("auto", diamond(true), None, at(None, true)));
    series.push(signs("", diamond(false), None, at(None, false)));
    for filled in [false, true] {
        series.extend(
            Model::ALL
                .iter()
                .enumerate()
                .map(|(m, &model)| signs("", round(filled), Some(m), at(Some(model), filled))),
        );
    }
    series.extend(key(&[("filled: on the CPU", round(true)), ("open: on the gpu", round(false))]));
    series.extend(lines(&points, "floor: standard error of auto"));
    LineChart {
        title: title(charted),
        x: Axis { label: format!("whole fit ({})", clock.unit()), log: true },
        y: Axis { label: "largest error of a parameter (%)".into(), log: true },
        series,
    }
}
