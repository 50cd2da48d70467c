//! A progress bar on stderr for work that takes longer than a second.
//!
//! It is fed with increments from any number of threads, and vanishes when it is dropped. Where stderr is no terminal, long
//! work prints a line now and then instead.

use super::console::{Level, note, tells};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Work shorter than this shows no bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Time between two lines where stderr is no terminal.
const REPORT: Duration = Duration::from_secs(30);

/// Redraws per second.
const REFRESH_HZ: u8 = 8;

/// The bar that may be on the terminal.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Clears the bar away, for a process that ends. A bar that is just being drawn is not waited for.
pub(super) fn clear() {
    if let Some(bar) = SHOWN.try_lock().ok().and_then(|mut shown| shown.take()) {
        bar.finish_and_clear();
    }
}

/// Shows `bar` from now on.
fn show(bar: &ProgressBar) {
    if let Ok(mut shown) = SHOWN.lock() {
        bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(REFRESH_HZ));
        *shown = Some(bar.clone());
    }
}

/// Counts finished units of work and shows them once a second has passed.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
    /// What is done, and in what it is counted.
    words: [String; 2],
    start: Instant,
    wanted: bool,
    shown: AtomicBool,
    /// Lines that were printed.
    lines: AtomicU64,
}

impl Progress {
    /// A bar for `total` units of work, with a word for what is done (`tracing`, say) and one for the unit.
    pub fn new(task: &str, unit: &str, total: u64) -> Self {
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let template = format!("{task} {{wide_bar}} {{percent}} % of {{human_len}} {unit}, {{eta}} left");
        // The template is fixed except for the two words; braces in them would at worst show the plain style.
        let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
        bar.set_style(style);
        let wanted = std::io::stderr().is_terminal() && tells(Level::Normal);
        Self {
            bar,
            words: [task.into(), unit.into()],
            start: Instant::now(),
            wanted,
            shown: AtomicBool::new(false),
            lines: AtomicU64::new(0),
        }
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
            let tick = move || {
                std::thread::sleep(PATIENCE);
                if !bar.is_finished() {
                    show(&bar);
                }
                while !bar.is_finished() {
                    bar.tick();
                    std::thread::sleep(PATIENCE / u32::from(REFRESH_HZ));
                }
            };
            // Where no thread can be started there is no bar.
            let _ = std::thread::Builder::new().spawn(tick);
        }
        progress
    }

    /// Adds `units` finished units; may be called from several threads.
    pub fn add(&self, units: u64) {
        let due = self.wanted && self.start.elapsed() >= PATIENCE;
        if due && !self.shown.swap(true, Ordering::Relaxed) {
            show(&self.bar);
        }
        self.bar.inc(units);
        if !self.wanted {
            self.report();
        }
    }

    /// Prints a line if the last one was long ago.
    fn report(&self) {
        let (elapsed, printed) = (self.start.elapsed(), self.lines.load(Ordering::Relaxed));
        let due = (elapsed.as_secs_f64() / REPORT.as_secs_f64()) as u64;
        let mine = || self.lines.compare_exchange(printed, due, Ordering::Relaxed, Ordering::Relaxed).is_ok();
        if due > printed && mine() {
            let ([task, unit], done) = (&self.words, self.bar.position());
            let all =
                self.bar.length().filter(|all| *all > 1).map_or(String::new(), |all| format!(" of {all}"));
            note(&format!("{task}: {done}{all} {unit} after {} s", elapsed.as_secs()));
        }
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
