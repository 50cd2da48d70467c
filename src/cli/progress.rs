//! A progress bar on stderr for work that takes longer than a second.
//!
//! It is fed with increments from any number of threads, stays hidden where stderr is no terminal, and vanishes
//! when it is dropped.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Redraws per second.
const REFRESH_HZ: u8 = 8;

/// Counts finished units of work and shows them once a second has passed.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
    wanted: bool,
    shown: AtomicBool,
}

impl Progress {
    /// A bar for `total` units of work, with a word for what is done (`tracing`, say) and one for the unit.
    pub fn new(task: &str, unit: &str, total: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let template = format!("{task} {{wide_bar}} {{percent}} % of {{human_len}} {unit}, {{eta}} left");
        // The template is fixed except for the two words; braces in them would at worst show the plain style.
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        let wanted = std::io::stderr().is_terminal();
        Self { bar, start: Instant::now(), wanted, shown: AtomicBool::new(false) }
    }

    /// Time running, for work that cannot be counted.
    pub fn uncounted(task: &str) -> Self {
        let progress = Self::new(task, "", 1);
        let template = format!("{task} {{spinner}} {{elapsed}}");
        let style =
            ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_spinner());
        progress.bar.set_style(style);
        if progress.wanted {
            let bar = progress.bar.clone();
            std::thread::spawn(move || {
                std::thread::sleep(PATIENCE);
                if !bar.is_finished() {
                    bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(REFRESH_HZ));
                    bar.enable_steady_tick(PATIENCE / u32::from(REFRESH_HZ));
                }
            });
        }
        progress
    }

    /// Adds `units` finished units; may be called from several threads.
    pub fn add(&self, units: u64) {
        let due = self.wanted && self.start.elapsed() >= PATIENCE;
        if due && !self.shown.swap(true, Ordering::Relaxed) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(REFRESH_HZ));
        }
        self.bar.inc(units);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn increments_of_several_threads_add_up() {
        let progress = Progress::new("tracing", "paths", 400);
        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| (0..100).for_each(|_| progress.add(1)));
            }
        });
        assert_eq!(progress.bar.position(), 400);
    }
}
