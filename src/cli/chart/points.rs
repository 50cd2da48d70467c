//! What is on a chart: time and error of every way that led to a result, and which of them no other beats.

use crate::study::chart::{Charted, front};

/// Times and errors, in the order of the trials; `None` where there is no result. Errors below the floor are at the floor: there
/// nothing tells them apart.
pub(super) struct Points {
    /// Seconds and relative error.
    pub all: Vec<Option<(f64, f64)>>,
    /// What the noise leaves.
    pub floor: Option<f64>,
    /// Indices of those on the Pareto front, in order of time.
    pub front: Vec<usize>,
}

impl Points {
    /// Of renders, prepared before.
    pub fn of_renders(charted: &Charted) -> Self {
        let point = |t: &crate::study::chart::RenderTrial| {
            t.outcome.as_ref().ok().map(|r| (r.render.seconds, r.error.value))
        };
        Self::new(charted.renders.iter().map(point).collect(), Some(charted.dataset.floor()))
    }

    /// Of fits; where the peer ended is the last point.
    pub fn of_fits(charted: &Charted) -> Self {
        let mut all: Vec<_> =
            charted.fits.iter().map(|t| Some((t.time?.seconds, t.outcome.as_ref().ok()?.error()))).collect();
        all.push(charted.peer.last().map(|step| (step.seconds, step.error)));
        Self::new(all, charted.fit_floor())
    }

    fn new(all: Vec<Option<(f64, f64)>>, floor: Option<f64>) -> Self {
        let raise = |(time, error): (f64, f64)| (time, error.max(floor.unwrap_or(0.0)));
        let all: Vec<_> = all.into_iter().map(|point| point.map(raise)).collect();
        let finite: Vec<_> = all.iter().map(|point| point.unwrap_or((f64::NAN, f64::NAN))).collect();
        Self { front: front(&finite), all, floor }
    }

    /// The border of what is beaten: along the front, in steps.
    pub fn steps(&self) -> Vec<(f64, f64)> {
        let corners: Vec<_> = self.front.iter().filter_map(|&i| self.all[i]).collect();
        let mut line: Vec<(f64, f64)> = Vec::new();
        for &(time, error) in &corners {
            if let Some(&(_, before)) = line.last() {
                line.push((time, before));
            }
            line.push((time, error));
        }
        line
    }
}
