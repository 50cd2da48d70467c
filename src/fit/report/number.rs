//! Numbers as people read them.

/// Five significant digits.
pub(super) fn significant(v: f64) -> String {
    if v == 0.0 {
        return "0".into();
    }
    let magnitude = v.abs().log10().floor();
    if (-4.0..6.0).contains(&magnitude) {
        format!("{v:.*}", (4.0 - magnitude).max(0.0) as usize)
    } else {
        format!("{v:.4e}")
    }
}
