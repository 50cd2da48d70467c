//! What `narrowbeam kernel` prints: totals, second moments, validity, and agreement with traced light.

use super::Setting;
use crate::cli::options::validity;
use crate::lab::compare::{MEDIAN_RADII, worst_encircled_error};
use crate::phase::{Phase, PhaseFunction};
use crate::spread::{
    Model, SMALL_ANGLE_LIMIT, SecondMoments, SpreadKernel, second_moments, small_angle_error,
};
use crate::trace::{Estimate, RadialProfile};
use std::fmt::Write;

/// The models' kernels.
pub(super) type Kernels = [(Model, Box<dyn SpreadKernel>)];

/// The whole text.
pub(super) fn text(setting: &Setting, kernels: &Kernels, traced: Option<&RadialProfile>) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = head(&mut text, setting, traced);
    let _ = table(&mut text, kernels, traced);
    text
}

fn head(out: &mut String, setting: &Setting, traced: Option<&RadialProfile>) -> std::fmt::Result {
    let Setting { medium, z } = *setting;
    let phase = match medium.phase() {
        Phase::Gaussian(phase) => {
            format!("B {:.6e} rad² (spread angle {:.3}°)", phase.b(), phase.spread_angle().to_degrees())
        }
        phase @ Phase::HenyeyGreenstein(_) => phase.to_string(),
    };
    let (sigma_s, sigma_a) = (medium.sigma_s(), medium.sigma_a());
    writeln!(out, "sigma_s {sigma_s}, sigma_a {sigma_a} (1/length), {phase}, depth {z}")?;
    let tau = medium.tau(z);
    writeln!(out, "tau {tau:.4}, optical depth {:.4}, albedo {:.4}", medium.sigma_t() * z, medium.albedo())?;
    let validity = validity(&medium, z);
    let regime = if validity <= SMALL_ANGLE_LIMIT {
        format!("not above {SMALL_ANGLE_LIMIT}: small-angle theory holds to 1 % of the transfer function")
    } else {
        format!(
            "above {SMALL_ANGLE_LIMIT}: small-angle theory is off by {} in the transfer function",
            small_angle_error(validity)
        )
    };
    writeln!(out, "tau·{} {validity:.4}, {regime}", medium.phase().family().mean_square_angle_formula())?;

    let measured = |of: fn(&RadialProfile) -> Estimate| {
        traced.map_or(String::new(), |profile| {
            let Estimate { value, std_error } = of(profile);
            format!("; traced {} ± {std_error:.1e}", number(value))
        })
    };
    let moments = match second_moments(&medium, z) {
        Some(SecondMoments { exact, printed }) => {
            format!("{} exact, {} as printed (length²)", number(exact), number(printed))
        }
        None => "infinite at small angles".into(),
    };
    writeln!(out)?;
    writeln!(
        out,
        "direct light T     {}{}",
        number(medium.transmittance(z)),
        measured(RadialProfile::direct)
    )?;
    writeln!(out, "second moment R    {moments}{}", measured(RadialProfile::second_moment))?;
    writeln!(out)
}

fn table(out: &mut String, kernels: &Kernels, traced: Option<&RadialProfile>) -> std::fmt::Result {
    write!(out, "{:<20}  {:>20}", "model", "scattered total")?;
    match traced {
        Some(_) => writeln!(out, "  {:>32}", "worst encircled-energy error")?,
        None => writeln!(out)?,
    }
    for (model, kernel) in kernels {
        write!(out, "{:<20}  {:>20}", model.name(), number(kernel.scattered()))?;
        let worst = traced.and_then(|profile| worst_encircled_error(profile, &**kernel));
        match worst {
            Some(worst) => {
                let Estimate { value, std_error } = worst.share;
                let cell = format!("{value:.4} ± {std_error:.4} at r = {}", number(worst.radius));
                writeln!(out, "  {cell:>32}")?;
            }
            None => writeln!(out)?,
        }
    }
    if let Some(profile) = traced.filter(|p| p.scattered_paths() > 0) {
        let total = profile.scattered();
        let cell = format!("{} ± {:.1e}", number(total.value), total.std_error);
        writeln!(out, "{:<20}  {cell:>20}", "traced")?;
        writeln!(
            out,
            "Errors are shares of the traced scattered light, over radii up to {MEDIAN_RADII} median radii (r = {}); \
             ± is one standard error.",
            number(MEDIAN_RADII * profile.quantile_radius(0.5))
        )?;
    }
    Ok(())
}

/// Six digits, with an exponent where it would be hard to read without.
fn number(value: f64) -> String {
    if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) {
        format!("{value:.5e}")
    } else {
        format!("{value:.6}")
    }
}
