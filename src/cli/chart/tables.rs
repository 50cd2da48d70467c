//! The numbers of the charts as CSV, and their fronts as a table for people.

use super::points::{Clock, Points};
use crate::error::Result;
use crate::forward::Quantity;
use crate::io::atomic;
use crate::lab::study::chart::{Charted, FitTrial, RenderTrial, Timing, Way};
use serde::Serialize;
use std::path::Path;

/// Columns of the parameters of [`Quantity::MEDIUM`].
const NAMES: [&str; 3] = ["sigma_s", "sigma_a", "b"];

/// The files that [`write`] makes.
pub(super) const FILES: [&str; 3] = ["renders.csv", "fits.csv", "peer.csv"];

pub(super) fn write(dir: &Path, charted: &[Charted], clock: Clock) -> Result<()> {
    let tables = [renders(charted, clock), fits(charted, clock), peers(charted)];
    FILES.iter().zip(tables).try_for_each(|(name, table)| atomic::write(&dir.join(name), table.as_bytes()))
}

fn quote(text: &str) -> String {
    text.replace([',', '\n'], ";")
}

fn renders(charted: &[Charted], clock: Clock) -> String {
    let mut text = String::from(
        "dataset,model,filter,backend,paths_per_pixel,prepare_seconds,prepare_cpu_seconds,seconds,cpu_seconds,runs,error,std_error,floor,pixels,on_front,why_not\n",
    );
    for c in charted {
        let front = Points::of_renders(c, clock).front;
        for (i, trial) in c.renders.iter().enumerate() {
            text += &format!("{},{},{},", c.dataset.name, way(trial), trial.backend);
            if let Way::Trace { samples } = trial.way {
                text += &samples.to_string();
            }
            text += &match &trial.outcome {
                Ok(r) => format!(
                    ",{},{},{},{:.3e},{:.1e},",
                    r.preparation.map_or(",".into(), times),
                    times(r.render),
                    r.render.runs,
                    r.error.value,
                    r.error.std_error
                ),
                Err(_) => ",,,,,,,,".into(),
            };
            let why = trial.outcome.as_ref().err().map_or(String::new(), |why| quote(why));
            text +=
                &format!("{:.1e},{},{},{why}\n", c.dataset.floor(), c.dataset.pixels(), front.contains(&i));
        }
    }
    text
}

/// By the wall clock, and of all cores.
fn times(timing: Timing) -> String {
    format!("{:.3e},{:.3e}", timing.seconds, timing.cpu_seconds)
}

/// Model and filter.
fn way(trial: &RenderTrial) -> String {
    let filter = match trial.way {
        Way::Filter { filter, .. } => filter.name(),
        Way::Trace { .. } => "",
    };
    format!("{},{filter}", trial.way.name())
}

fn fits(charted: &[Charted], clock: Clock) -> String {
    let mut text = String::from("dataset,method,model,filter,backend,seconds,cpu_seconds,runs");
    NAMES.iter().for_each(|name| text += &format!(",error_{name}"));
    text += ",error,std_error,warnings,on_front,why_not\n";
    for c in charted {
        let front = Points::of_fits(c, clock).front;
        for (i, trial) in c.fits.iter().enumerate() {
            text += &format!("{},{}\n", c.dataset.name, fit(trial, front.contains(&i)));
        }
    }
    text
}

fn fit(trial: &FitTrial, on_front: bool) -> String {
    let method = trial.method.name();
    let time = trial.time.map_or(",,".into(), |t| format!("{},{}", times(t), t.runs));
    let found = match &trial.outcome {
        Ok(fit) => {
            let each = Quantity::MEDIUM
                .map(|quantity| fit.error_of(quantity).map_or(String::new(), |e| format!("{e:.3e}")));
            let warnings: Vec<&str> = fit.warnings.iter().map(|code| code.name()).collect();
            format!("{},{:.3e},{:.1e},{}", each.join(","), fit.error(), fit.std_error, warnings.join(" "))
        }
        Err(_) => ",,,,,".into(),
    };
    let (model, filter) =
        trial.outcome.as_ref().map_or(("", ""), |fit| (fit.model.as_str(), fit.filter.as_str()));
    let why = trial.outcome.as_ref().err().map_or(String::new(), |why| quote(why));
    format!("{method},{model},{filter},{},{time},{found},{on_front},{why}", trial.backend)
}

fn peers(charted: &[Charted]) -> String {
    let mut text = String::from("dataset,seconds,cpu_seconds,error\n");
    for c in charted {
        for step in &c.peer {
            text += &format!("{},{},{},{:.3e}\n", c.dataset.name, step.seconds, step.cpu_seconds, step.error);
        }
    }
    text
}

/// A point on a front.
#[derive(Debug, Serialize)]
pub(super) struct OnFront {
    dataset: String,
    /// `render` or `fit`.
    task: &'static str,
    /// Model or method, how, and where.
    name: String,
    seconds: f64,
    error: f64,
    /// The error that the noise of the image would hide.
    floor: Option<f64>,
}

/// The points on the fronts, from fast to exact.
pub(super) fn fronts(charted: &[Charted], clock: Clock) -> Vec<OnFront> {
    let mut all = Vec::new();
    for c in charted {
        let render = |i: usize| {
            let trial = &c.renders[i];
            let how = match trial.way {
                Way::Filter { filter, .. } => filter.name().into(),
                Way::Trace { samples } => format!("{samples} paths per pixel"),
            };
            format!("{}, {how}, {}", trial.way.name(), trial.backend)
        };
        let fit = |i: usize| {
            c.fits.get(i).map_or("peer".into(), |trial| format!("{}, {}", trial.method.name(), trial.backend))
        };
        all.extend(front(&c.dataset.name, "render", &Points::of_renders(c, clock), render));
        all.extend(front(&c.dataset.name, "fit", &Points::of_fits(c, clock), fit));
    }
    all
}

fn front(dataset: &str, task: &'static str, points: &Points, name: impl Fn(usize) -> String) -> Vec<OnFront> {
    let point = |&i: &usize| {
        let (seconds, error) = points.all[i]?;
        Some(OnFront { dataset: dataset.into(), task, name: name(i), seconds, error, floor: points.floor })
    };
    points.front.iter().filter_map(point).collect()
}

/// The same as rows for people.
pub(super) fn rows(fronts: &[OnFront], clock: Clock) -> Vec<Vec<String>> {
    let head = ["dataset", "", "front, from fast to exact", clock.unit(), "error %", "floor %"];
    let percent = |v: f64| format!("{:.3}", 100.0 * v);
    let row = |p: &OnFront| {
        let floor = p.floor.map_or("-".into(), percent);
        vec![
            p.dataset.clone(),
            p.task.into(),
            p.name.clone(),
            format!("{:.2e}", p.seconds),
            percent(p.error),
            floor,
        ]
    };
    std::iter::once(head.map(String::from).to_vec()).chain(fronts.iter().map(row)).collect()
}
