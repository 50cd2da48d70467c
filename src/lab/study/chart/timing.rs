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
    pub fn time<T>(&self, mut run: impl FnMut() -> Result<T>) -> Result<(T, Timing)> {
        let begin = Instant::now();
        let (mut wall, mut cpu) = (Vec::new(), Vec::new());
        let mut timed = || {
            let (clock, cpu_clock) = (Instant::now(), ProcessTime::now());
            let done = run()?;
            wall.push(clock.elapsed().as_secs_f64());
            cpu.push(cpu_clock.elapsed().as_secs_f64());
            Ok(done)
        };
        let first = timed()?;
        let mut runs = 1;
        while runs < self.runs && begin.elapsed().as_secs_f64() < self.patience {
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
    use std::thread::sleep;
    use std::time::Duration;

    #[test]
    fn the_time_is_the_median_and_the_result_the_first() {
        let effort = Effort { runs: 3, patience: 60.0, samples: Vec::new() };
        let mut run = 0;
        let (first, timing) = effort
            .time(|| {
                run += 1;
                sleep(Duration::from_millis([400, 1, 5][run - 1]));
                Ok(run)
            })
            .unwrap();
        assert_eq!((first, timing.runs), (1, 3));
        // The median sleeps 5 ms; the longest, 400.
        assert!((0.005..0.4).contains(&timing.seconds), "{timing:?}");
    }

    #[test]
    fn work_takes_time_of_a_core() {
        let effort = Effort { runs: 1, patience: 0.0, samples: Vec::new() };
        let work = || Ok((0..20_000_000_u64).fold(1.0_f64, |sum, i| sum + (i as f64).sqrt()));
        let (sum, timing) = effort.time(work).unwrap();
        // A square root takes a tenth of a nanosecond at the very least.
        assert!(sum > 1.0 && timing.cpu_seconds > 2e-3, "{timing:?}");
    }

    #[test]
    fn quick_runs_are_repeated_and_slow_ones_are_not() {
        let effort = Effort { runs: 4, patience: 0.01, samples: Vec::new() };
        assert_eq!(effort.time(|| Ok(())).unwrap().1.runs, 4);
        let slow = effort.time(|| {
            sleep(Duration::from_millis(20));
            Ok(())
        });
        assert_eq!(slow.unwrap().1.runs, 1);
    }
}
