//! One contender on one scene: what is written down.

use crate::methods::{Method, Work};

/// Times and errors.
#[derive(Debug, Clone, Copy)]
pub struct Timing {
    /// Seconds, once a fit.
    pub prepare: f64,
    /// Seconds, each image.
    pub render: f64,
    /// Relative L2 distance from the reference.
    pub l2: f64,
    /// Relative error of the image's sum.
    pub energy: f64,
    /// Times run.
    pub repeats: usize,
}

/// What became of one contender on one scene.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    pub method: Method,
    /// Side of the image, px.
    pub n: usize,
    /// Kernel width at the mean depth, px.
    pub width_px: f64,
    pub slope: bool,
    /// None if it was only counted.
    pub timing: Option<Timing>,
    /// Of preparation and render.
    pub work: [Work; 2],
}

impl Row {
    /// For people, with times in ms.
    pub fn line(&self) -> String {
        let Row { method, n, width_px, .. } = self;
        let depths = if self.slope { "slope" } else { "plane" };
        let [prepare, render] = self.work;
        let counted = format!(
            "{:.3} + {:.3} Gflop, {:.0} + {:.0} MB",
            1e-9 * prepare.flops,
            1e-9 * render.flops,
            1e-6 * prepare.bytes,
            1e-6 * render.bytes
        );
        let timed = self.timing.map_or("not timed".into(), |t| {
            let [prepare, render] = [t.prepare, t.render].map(|s| 1e3 * s);
            format!("{prepare:.1} + {render:.1} ms, error {:.1e}, energy {:.1e}", t.l2, t.energy)
        });
        format!("{depths} {n:4} px, width {width_px:5} px, {:22} {timed}; {counted}", method.to_string())
    }

    /// Seconds measured for a whole frame, and its error.
    pub fn frame(&self) -> Option<(f64, f64)> {
        self.timing.map(|t| (t.prepare + t.render, t.l2))
    }
}

/// All rows; times and errors are empty where nothing was timed.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "method,setting,depths,size_px,width_px,repeats,prepare_ms,render_ms,error_l2,error_energy,prepare_gflop,\
         prepare_mb,prepare_dispatches,prepare_counted_ms,render_gflop,render_mb,render_dispatches,render_counted_ms\n",
    );
    for row in rows {
        let timed = row.timing.map_or(",,,,".into(), |t| {
            let [prepare, render] = [t.prepare, t.render].map(|s| 1e3 * s);
            format!("{},{prepare:.3},{render:.3},{:.2e},{:.2e}", t.repeats, t.l2, t.energy)
        });
        let counted = row.work.map(|w| {
            let [gflop, mb, ms] = [1e-9 * w.flops, 1e-6 * w.bytes, 1e3 * w.seconds()];
            format!("{gflop:.5},{mb:.3},{},{ms:.4}", w.dispatches)
        });
        let depths = if row.slope { "slope" } else { "plane" };
        let (name, setting) = (row.method.name(), row.method.setting());
        text +=
            &format!("{name},{setting},{depths},{},{},{timed},{}\n", row.n, row.width_px, counted.join(","));
    }
    text
}
