//! How long something takes: the median of several runs.

use crate::error::Result;
use std::time::Instant;

/// How much work a study may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Effort {
    /// Runs of which the median is taken, at least.
    pub least: usize,
    /// At most.
    pub most: usize,
    /// Seconds after which there are no more runs than the least.
    pub patience: f64,
    /// Paths a pixel of the traced images.
    pub samples: Vec<u32>,
}

impl Effort {
    /// A few minutes for half a dozen of small datasets.
    pub fn full() -> Self {
        Self { least: 3, most: 15, patience: 1.0, samples: vec![4, 16, 64, 256, 1024] }
    }

    /// A look in seconds.
    pub fn quick() -> Self {
        Self { least: 1, most: 3, patience: 0.02, samples: vec![4, 16] }
    }

    /// What the first `run` gives, and how long it takes.
    ///
    /// # Errors
    /// Those of `run`.
    pub fn time<T>(&self, mut run: impl FnMut() -> Result<T>) -> Result<(T, Timing)> {
        let mut seconds = Vec::new();
        let begin = Instant::now();
        let mut timed = || {
            let clock = Instant::now();
            let done = run()?;
            seconds.push(clock.elapsed().as_secs_f64());
            Ok((done, seconds.len()))
        };
        let (first, mut runs) = timed()?;
        while runs < self.least || (runs < self.most && begin.elapsed().as_secs_f64() < self.patience) {
            runs = timed()?.1;
        }
        seconds.sort_by(f64::total_cmp);
        Ok((first, Timing { seconds: seconds[runs / 2], runs }))
    }
}

/// A time and what it rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timing {
    /// The median, seconds.
    pub seconds: f64,
    /// Of so many runs.
    pub runs: usize,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::thread::sleep;
    use std::time::Duration;

    #[test]
    fn the_time_is_the_median_and_the_result_the_first() {
        let effort = Effort { least: 3, most: 3, patience: 0.0, samples: Vec::new() };
        let mut run = 0;
        let (first, timing) = effort
            .time(|| {
                run += 1;
                sleep(Duration::from_millis([60, 1, 5][run - 1]));
                Ok(run)
            })
            .unwrap();
        assert_eq!((first, timing.runs), (1, 3));
        // The median sleeps 5 ms; the longest, 60.
        assert!((0.005..0.06).contains(&timing.seconds), "{timing:?}");
    }

    #[test]
    fn quick_runs_are_repeated_and_slow_ones_are_not() {
        let effort = Effort { least: 1, most: 4, patience: 0.01, samples: Vec::new() };
        assert_eq!(effort.time(|| Ok(())).unwrap().1.runs, 4);
        let slow = effort.time(|| {
            sleep(Duration::from_millis(20));
            Ok(())
        });
        assert_eq!(slow.unwrap().1.runs, 1);
    }
}
