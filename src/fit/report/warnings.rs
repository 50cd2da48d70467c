//! What a fit tells its user besides numbers.

use super::gauge::Gauge;
use super::{Warning, significant};
use crate::filter::CUT;
use crate::fit::structure::STRUCTURED;
use crate::fit::uncertainty::Status;
use crate::fit::{ChannelFit, MISFIT};
use crate::spread::{Model, SMALL_ANGLE_LIMIT, small_angle_error};
use nalgebra::Vector3;

/// Width of the kernel in views above which the image does not tell its shape: Henyey-Greenstein's lobes of g = .8 then pass
/// for a Gaussian with 20 % less scattering (docs/stability.md).
const WIDE_KERNEL: f64 = 0.5;
/// Standard errors by which the data must want a parameter beyond its bound before that is no accident.
const PRESSED: f64 = 3.0;
/// tau up to which fits by `traced` are known to come back (tests/it/traced_planes.rs), with a margin for the estimate's error.
const THICKEST: f64 = 16.0;
/// Predicted error of a logarithm, or of sigma_a z, above which a model is said to be the wrong one.
const LARGE_MODEL_ERROR: f64 = 0.1;

/// The warnings of one channel, whose names end in `suffix`.
pub(super) fn warnings(suffix: &str, fit: &ChannelFit, model: Model) -> Vec<Warning> {
    let mut all = Vec::new();
    let (names, family) = (fit.parameters.names(), fit.parameters.family());
    let mut warn = |code, message| all.push(Warning { code, message });
    if !fit.converged {
        warn("not_converged", format!("the fit{suffix} stopped before its optimum: {}", fit.stop));
    }
    let lost: Vec<usize> = (0..3).filter(|&i| fit.uncertainty.status(i) == Status::Undetermined).collect();
    if !lost.is_empty() {
        let names: Vec<String> = lost.iter().map(|&i| format!("{}{suffix}", names[i])).collect();
        warn(
            "undetermined",
            format!("the data do not determine {}: {}", names.join(" and "), why(fit, model)),
        );
    }
    if fit.cut {
        warn("kernel_cut", format!("{CUT}{suffix}"));
    }
    if !fit.settled {
        let message = "the noise of the scenes, the depth slices of the render or the medium of the traced paths did not settle";
        warn("not_settled", format!("{message}{suffix}"));
    }
    if fit.hidden_pixels > fit.pixels {
        warn(
            "hidden_light",
            format!(
                "{} of {} pixels{suffix} are left out, as more than hidden_share_max of their light may be hidden \
                 behind near surfaces; give what lies there as [[object.layer]], or raise [observation] \
                 hidden_share_max",
                fit.hidden_pixels,
                fit.hidden_pixels + fit.pixels
            ),
        );
    }
    if fit.reduced_chi2 > MISFIT {
        warn(
            "misfit",
            format!(
                "reduced chi²{suffix} is {}: the image is not what {model} makes of this scene; the noise may be \
                 more than stated, the geometry or the object wrong, or the scenes' media different",
                significant(fit.reduced_chi2)
            ),
        );
    }
    if fit.structure > STRUCTURED {
        warn(
            "structure",
            format!(
                "the residual{suffix} is not noise: averaged over blocks of pixels it is {:.0} standard deviations above \
                 what noise leaves; the lobe may not be {family}, the medium not homogeneous, gain, veil or depth wrong, \
                 pixels saturated; the intervals do not hold that",
                fit.structure
            ),
        );
    }
    if let Some(gauge) = Gauge::of(fit).filter(|g| model.spreads() && g.kernel_width_views > WIDE_KERNEL) {
        warn(
            "wide_kernel",
            format!(
                "the kernel{suffix} is {:.1} views wide: the image shows only its core, so the estimates rest on a lobe that \
                 is {family}, which the residual cannot tell; look at more of the scene",
                gauge.kernel_width_views
            ),
        );
    }
    let pressed = |&i: &usize| fit.uncertainty.std_error(i).is_some_and(|e| fit.pull[i].abs() > PRESSED * e);
    let pressed: Vec<String> = fit
        .parameters
        .at_bound()
        .into_iter()
        .filter(pressed)
        .map(|i| format!("{}{suffix}", names[i]))
        .collect();
    if !pressed.is_empty() {
        warn(
            "at_bound",
            format!(
                "on a bound, beyond which the data want it, and where the interval is cut: {}",
                pressed.join(", ")
            ),
        );
    }
    let free = |i: &usize| fit.uncertainty.status(*i) == Status::Free;
    match &fit.model_error {
        None if (0..3).any(|i| free(&i)) => warn(
            "model_error_unknown",
            format!(
                "the error of {model}{suffix} is not known at this medium, beyond the range of wide-angle"
            ),
        ),
        Some(error) => {
            let share = |i: usize| {
                let bias = error.bias_of(&Vector3::ith(i, 1.0)).abs();
                if i == 1 { bias * fit.median_z } else { bias }
            };
            let worst = (0..3).filter(free).map(share).fold(0.0, f64::max);
            if worst > LARGE_MODEL_ERROR {
                let message = format!(
                    "{model}{suffix} is off by about {:.0} % of a parameter at this medium; use --model auto",
                    100.0 * worst
                );
                warn("model_error", message);
            }
        }
        None => (),
    }
    let [sigma_s, _, shape] = fit.parameters.values();
    let (validity, square) =
        (sigma_s * fit.median_z * family.square_angle(shape), family.square_angle_formula());
    if model.rests_on_small_angles() && validity > SMALL_ANGLE_LIMIT {
        warn(
            "outside_validity",
            format!(
                "tau·{square}{suffix} = {validity:.3} is above {SMALL_ANGLE_LIMIT}: {model} rests on small angles, whose \
                 transfer function is off by {} here, which the residual does not show; the stated model error, which \
                 the intervals hold, is a prediction of first order; use --model wide-angle or auto",
                small_angle_error(validity)
            ),
        );
    }
    let tau = sigma_s * fit.median_z;
    if model == Model::Traced && tau > THICKEST {
        warn(
            "outside_validity",
            format!(
                "tau{suffix} = {tau:.1} is above {THICKEST}, up to which fits by {model} are tested; look through less of the medium"
            ),
        );
    }
    all
}

/// Why parameters are undetermined, and what is known all the same.
fn why(fit: &ChannelFit, model: Model) -> String {
    if !model.spreads() {
        return "direct light alone shows only sigma_t; fix sigma_s or sigma_a, or use a model that spreads light".into();
    }
    let known: Vec<String> = fit
        .determined
        .iter()
        .map(|c| format!("{} = {} ± {}", c.combination, significant(c.value), significant(c.std_error)))
        .collect();
    if known.is_empty() {
        "the noise allows almost any value".into()
    } else {
        format!("only {}", known.join(", "))
    }
}
