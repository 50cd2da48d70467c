//! How long something takes: the median of several runs, by the wall clock, and summed over all cores, which does not count
//! other work of the machine.

use crate::error::Result;
use crate::geometry::median;
use cpu_time::ProcessTime;
use std::time::Instant;

/// The effort of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct Effort {
    /// Runs of which the median is taken, at most.
    pub runs: usize,
    /// Seconds after which no further run begins.
    pub patience: f64,
    /// Paths per pixel of the traced images.
    pub samples: Vec<u32>,
}

impl Effort {
    /// A few minutes for half a dozen of small datasets.
    pub fn full() -> Self {
        Self { runs: 15, patience: 2.0, samples: vec![4, 16, 64, 256, 1024] }
    }

    /// A look in seconds.
    pub fn quick() -> Self {
        Self { runs: 3, patience: 0.02, samples: vec![4, 16] }
    }

    /// The result of the first `run`, and how long a run takes.
    ///
    /// # Errors
    /// Those of `run`.
    pub fn time<T>(&self, run: impl FnMut() -> Result<T>) -> Result<(T, Timing)> {
        let begin = Instant::now();
        self.time_by(|| [begin.elapsed().as_secs_f64(), ProcessTime::now().as_duration().as_secs_f64()], run)
    }

    /// The same by a `clock` of what has passed, seconds: on the wall, and of all cores.
    fn time_by<T>(
        &self,
        clock: impl Fn() -> [f64; 2],
        mut run: impl FnMut() -> Result<T>,
    ) -> Result<(T, Timing)> {
        let [begin, _] = clock();
        let (mut wall, mut cpu) = (Vec::new(), Vec::new());
        let mut timed = || {
            let before = clock();
            let done = run()?;
            let after = clock();
            wall.push(after[0] - before[0]);
            cpu.push(after[1] - before[1]);
            Ok(done)
        };
        let first = timed()?;
        let mut runs = 1;
        while runs < self.runs && clock()[0] - begin < self.patience {
            timed()?;
            runs += 1;
        }
        Ok((first, Timing { seconds: median(wall), cpu_seconds: median(cpu), runs }))
    }
}

/// A time, and how it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// The median by the wall clock, seconds.
    pub seconds: f64,
    /// The median of the time summed over all cores, seconds.
    pub cpu_seconds: f64,
    /// Number of runs.
    pub runs: usize,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    /// Times runs that take these seconds on the wall and twice as much of the cores, and return their number.
    fn timed(effort: &Effort, seconds: &[f64]) -> (usize, Timing) {
        let (now, run) = (Cell::new(10.0), Cell::new(0));
        let work = || {
            now.set(now.get() + seconds[run.get()]);
            run.set(run.get() + 1);
            Ok(run.get())
        };
        effort.time_by(|| [now.get(), 2.0 * now.get()], work).unwrap()
    }

    #[test]
    fn the_time_is_the_median_and_the_result_the_first() {
        let effort = Effort { runs: 3, patience: 60.0, samples: Vec::new() };
        let wanted = Timing { seconds: 0.25, cpu_seconds: 0.5, runs: 3 };
        assert_eq!(timed(&effort, &[8.0, 0.125, 0.25]), (1, wanted));
    }

    #[test]
    fn work_takes_time_of_a_core() {
        let effort = Effort { runs: 1, patience: 0.0, samples: Vec::new() };
        let work = || Ok((0..20_000_000_u64).fold(1.0_f64, |sum, i| sum + (i as f64).sqrt()));
        let (sum, timing) = effort.time(work).unwrap();
        assert!(sum > 1.0 && timing.seconds > 0.0 && timing.cpu_seconds > 0.0, "{timing:?}");
    }

    #[test]
    fn quick_runs_are_repeated_and_slow_ones_are_not() {
        let effort = Effort { runs: 4, patience: 0.01, samples: Vec::new() };
        assert_eq!(timed(&effort, &[0.0; 4]).1.runs, 4);
        assert_eq!(timed(&effort, &[0.02; 4]).1.runs, 1);
    }
}
