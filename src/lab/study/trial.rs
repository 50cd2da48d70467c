//! Fits along sweeps, and how many of them fail silently or carry a needless warning.

use super::Setting;
use super::stability::{Method, Outcome};

/// A place on a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Name of the sweep.
    pub sweep: &'static str,
    /// Where on it.
    pub level: f64,
    /// The same in words, where a number is not enough.
    pub label: String,
}

impl Place {
    /// A place given by a number.
    pub fn at(sweep: &'static str, level: f64) -> Self {
        Self { sweep, level, label: String::new() }
    }
}

/// One fit.
#[derive(Debug, Clone)]
pub struct Trial {
    /// Its place on a sweep.
    pub place: Place,
    /// The plane and its medium.
    pub setting: Setting,
    /// How it was fitted.
    pub method: Method,
    /// How that ended.
    pub outcome: Outcome,
}

/// Sweeps along which the scene file is wrong about the scene: a warning is never needless there.
const FAULTY: [&str; 14] = [
    "depth error",
    "gain error",
    "Henyey-Greenstein g",
    "varying sigma_s",
    "saturated share",
    "shift (px)",
    "rotation (degrees)",
    "scale",
    "blur (px)",
    "veil gradient",
    "vignetting",
    "gamma",
    "object beyond the frame (px)",
    "noise of the clear image",
];

impl Trial {
    /// Whether the scene file is right about the scene.
    pub fn is_sound(&self) -> bool {
        !FAULTY.contains(&self.place.sweep)
    }
}

/// How many of the trials failed silently, and how many raised a false alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tally {
    /// All fits.
    pub fits: usize,
    /// Those that were wrong without a warning.
    pub silent: usize,
    /// Those with a sound scene file that are right, inside the model's range.
    pub right: usize,
    /// Those among them that carry a warning.
    pub false_alarms: usize,
}

impl Tally {
    /// Counts `trials`.
    pub fn of(trials: &[Trial]) -> Self {
        let count = |f: &dyn Fn(&Trial) -> bool| trials.iter().filter(|t| f(t)).count();
        let false_alarm = |t: &Trial| t.is_sound() && t.outcome.is_false_alarm();
        Self {
            fits: trials.len(),
            silent: count(&|t| t.outcome.is_silent_failure()),
            right: count(&|t| {
                t.is_sound()
                    && t.outcome.is_right()
                    && (t.outcome.warnings.is_empty() || t.outcome.is_false_alarm())
            }),
            false_alarms: count(&false_alarm),
        }
    }
}
