//! What is on a chart: time and error of every way that gave a result, and which of them no other beats.

use crate::lab::study::chart::{Charted, RenderTrial, Step, Timing, front};
use clap::ValueEnum;

/// Which time is charted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Clock {
    /// Wall-clock time
    Wall,
    /// Time of all cores together: for a machine that does other work as well
    Cpu,
}

impl Clock {
    /// Seconds of `timing`.
    pub fn of(self, timing: Timing) -> f64 {
        match self {
            Self::Wall => timing.seconds,
            Self::Cpu => timing.cpu_seconds,
        }
    }

    /// Seconds until `step`.
    pub fn of_step(self, step: &Step) -> f64 {
        match self {
            Self::Wall => step.seconds,
            Self::Cpu => step.cpu_seconds,
        }
    }

    /// Its unit on an axis.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Wall => "s",
            Self::Cpu => "s of all cores together",
        }
    }
}

/// Times and errors, in the order of the trials; `None` where there is no result. Errors below the floor are moved to the
/// floor: below it they cannot be distinguished.
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
    pub fn of_renders(charted: &Charted, clock: Clock) -> Self {
        let point = |t: &RenderTrial| t.outcome.as_ref().ok().map(|r| (clock.of(r.render), r.error.value));
        Self::new(charted.renders.iter().map(point).collect(), Some(charted.dataset.floor()))
    }

    /// Of fits; where the peer ended is the last point.
    pub fn of_fits(charted: &Charted, clock: Clock) -> Self {
        let mut all: Vec<_> = charted
            .fits
            .iter()
            .map(|t| Some((clock.of(t.time?), t.outcome.as_ref().ok()?.error())))
            .collect();
        all.push(charted.peer.last().map(|step| (clock.of_step(step), step.error)));
        Self::new(all, charted.fit_floor())
    }

    fn new(all: Vec<Option<(f64, f64)>>, floor: Option<f64>) -> Self {
        let raise = |(time, error): (f64, f64)| (time, error.max(floor.unwrap_or(0.0)));
        let all: Vec<_> = all.into_iter().map(|point| point.map(raise)).collect();
        let finite: Vec<_> = all.iter().map(|point| point.unwrap_or((f64::NAN, f64::NAN))).collect();
        Self { front: front(&finite), all, floor }
    }

    /// The same with errors in percent.
    pub fn percent(mut self) -> Self {
        self.all.iter_mut().flatten().for_each(|point| point.1 *= 100.0);
        self.floor = self.floor.map(|floor| 100.0 * floor);
        self
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
