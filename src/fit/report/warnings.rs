//! What a fit warns its user of.

use super::diagnosis::severity;
use super::number::significant;
use super::{Regime, Severity, Warning, WarningCode};
use crate::filter::CUT;
use crate::fit::channel::MISFIT;
use crate::fit::inference::{ChannelFit, Status};
use crate::forward::Quantity;
use crate::spread::{Model, SMALL_ANGLE_LIMIT, small_angle_error};

/// Width of the kernel in views above which the image does not show its shape: phase functions of Henyey and Greenstein of
/// g = 0.8 then pass for a Gaussian with 20 % less scattering (docs/stability.md).
const WIDE_KERNEL: f64 = 0.5;
/// Standard errors by which the data must want a parameter beyond its bound before that is no accident.
const PRESSED: f64 = 3.0;
/// tau up to which fits by `traced` are known to come back (tests/it/traced_planes.rs), with a margin for the estimate's error.
const THICKEST: f64 = 16.0;
/// Reduced chi² above which an image contradicts its scene, if the residual is not noise.
const CONTRADICTED: f64 = 3.0;
/// Predicted error of a logarithm, or of sigma_a z, above which a model is said to be the wrong one.
const LARGE_MODEL_ERROR: f64 = 0.1;

/// A fit of one channel, whose names end in a suffix.
struct Case<'a> {
    suffix: &'a str,
    fit: &'a ChannelFit,
    model: Model,
}

/// The warnings of one channel, whose names end in `suffix`.
pub(super) fn warnings(suffix: &str, fit: &ChannelFit, model: Model) -> Vec<Warning> {
    let case = Case { suffix, fit, model };
    let rules: [fn(&Case) -> Option<Warning>; 12] = [
        not_converged,
        undetermined,
        kernel_cut,
        not_settled,
        hidden_light,
        misfit,
        structure,
        wide_kernel,
        at_bound,
        model_error,
        wide_angles,
        thick,
    ];
    rules.iter().filter_map(|rule| rule(&case)).collect()
}

fn not_converged(&Case { suffix, fit, .. }: &Case) -> Option<Warning> {
    let message = || format!("the fit{suffix} stopped before its optimum: {}", fit.stop);
    (!fit.converged).then(|| Warning::new(WarningCode::NotConverged, message()))
}

fn undetermined(case: &Case) -> Option<Warning> {
    let Case { suffix, fit, .. } = case;
    let lost = fit.parameters.iter().filter(|(id, _)| fit.covariance.status(*id) == Status::Undetermined);
    let names: Vec<String> = lost.map(|(_, p)| format!("{}{suffix}", p.name())).collect();
    let message = || format!("the data do not determine {}: {}", names.join(" and "), why(case));
    (!names.is_empty()).then(|| Warning::new(WarningCode::Undetermined, message()))
}

/// Why parameters are undetermined, and what is known in spite of that.
fn why(&Case { fit, model, .. }: &Case) -> String {
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

fn kernel_cut(&Case { suffix, fit, .. }: &Case) -> Option<Warning> {
    fit.cut.then(|| Warning::new(WarningCode::KernelCut, format!("{CUT}{suffix}")))
}

fn not_settled(&Case { suffix, fit, .. }: &Case) -> Option<Warning> {
    let message = "the noise of the scenes, the depth slices of the render or the medium of the traced paths did not settle";
    (!fit.settled).then(|| Warning::new(WarningCode::NotSettled, format!("{message}{suffix}")))
}

fn hidden_light(&Case { suffix, fit, .. }: &Case) -> Option<Warning> {
    let message = || {
        format!(
            "{} of {} pixels{suffix} are left out, as more than hidden_share_max of their light may be hidden \
             behind near surfaces; give what lies there as a further layer of the object, or raise hidden_share_max",
            fit.hidden_pixels,
            fit.hidden_pixels + fit.pixels
        )
    };
    (fit.hidden_pixels > fit.pixels).then(|| Warning::new(WarningCode::HiddenLight, message()))
}

fn misfit(&Case { suffix, fit, model }: &Case) -> Option<Warning> {
    let message = || {
        format!(
            "reduced chi²{suffix} is {}: the image is not what {model} makes of this scene, or the noise is more than stated{}",
            significant(fit.reduced_chi2),
            causes(fit, Severity::Note).map_or_else(String::new, |causes| format!("; {causes}"))
        )
    };
    let is_noise = !fit.lacks_fit();
    let severity = if fit.misfit > CONTRADICTED && !is_noise { Severity::Invalid } else { Severity::Caution };
    (fit.misfit > MISFIT).then(|| Warning::new(WarningCode::Misfit, message()).of(severity))
}

/// The residual holds something that moves an estimate, or that nothing explains.
fn structure(&Case { suffix, fit, .. }: &Case) -> Option<Warning> {
    if let Some(causes) = causes(fit, Severity::Caution) {
        let message = format!("the residual{suffix} is not noise: {causes}");
        let worst = fit.findings.iter().map(|finding| severity(finding, fit)).max();
        return Some(Warning::new(WarningCode::Structure, message).of(worst.unwrap_or(Severity::Caution)));
    }
    let message = || {
        format!(
            "the residual{suffix} is not noise: averaged over blocks of pixels it is {:.0} standard deviations above \
             what noise leaves, and no cause that is known here explains it; {}",
            fit.lack_of_fit,
            if fit.paths.is_some() {
                "traced paths are not asked for causes, and the intervals do not hold them"
            } else {
                "the intervals are widened by what blocks of it show"
            }
        )
    };
    let unexplained = fit.findings.iter().all(|finding| finding.cause.is_of_noise());
    (fit.lacks_fit() && unexplained).then(|| Warning::new(WarningCode::Structure, message()))
}

/// The causes that are at least so serious, in words; `None` if there are none.
fn causes(fit: &ChannelFit, least: Severity) -> Option<String> {
    let serious = fit.findings.iter().filter(|finding| severity(finding, fit) >= least);
    let words = serious.map(|finding| {
        let others: String =
            finding.alternatives.iter().map(|other| format!(", or {}", other.in_words())).collect();
        format!("{}{others} ({}: {})", finding.cause.in_words(), finding.cause, finding.cause.advice())
    });
    let words: Vec<String> = words.collect();
    (!words.is_empty()).then(|| words.join("; "))
}

fn wide_kernel(&Case { suffix, fit, model }: &Case) -> Option<Warning> {
    let regime = Regime::of(fit).filter(|r| model.spreads() && r.kernel_width_views > WIDE_KERNEL)?;
    let message = format!(
        "the kernel{suffix} is {:.1} views wide: the image shows only its core, so the estimates rest on a phase function \
         that is {}, which the residual cannot check; look at more of the scene",
        regime.kernel_width_views, regime.family
    );
    Some(Warning::new(WarningCode::WideKernel, message))
}

fn at_bound(&Case { suffix, fit, .. }: &Case) -> Option<Warning> {
    let pressed = fit.parameters.iter().filter(|(id, p)| {
        let step = fit.gauss_newton_step[id.row()].abs();
        p.is_at_bound() && fit.covariance.std_error(*id).is_some_and(|e| step > PRESSED * e)
    });
    let pressed: Vec<String> = pressed.map(|(_, p)| format!("{}{suffix}", p.name())).collect();
    let message = || {
        format!(
            "on a bound, beyond which the data want it, and where the interval is cut: {}",
            pressed.join(", ")
        )
    };
    (!pressed.is_empty()).then(|| Warning::new(WarningCode::AtBound, message()))
}

fn model_error(&Case { suffix, fit, model }: &Case) -> Option<Warning> {
    let mut free = fit.with_status(Status::Free).peekable();
    let Some(error) = &fit.model_error else {
        free.peek()?;
        let message = format!(
            "the error of {model}{suffix} is not known at this medium, beyond the range of wide-angle"
        );
        return Some(Warning::new(WarningCode::ModelErrorUnknown, message));
    };
    let in_scales = |id| error.bias_of(&fit.parameters.along(id)).abs() / fit.parameters.get(id).scale();
    let worst = free.map(in_scales).fold(0.0, f64::max);
    let message = || {
        format!(
            "{model}{suffix} is off by about {:.0} % of a parameter at this medium; let the program choose the model",
            100.0 * worst
        )
    };
    (worst > LARGE_MODEL_ERROR).then(|| Warning::new(WarningCode::ModelError, message()))
}

fn wide_angles(&Case { suffix, fit, model }: &Case) -> Option<Warning> {
    let family = fit.parameters.family();
    let angle = family.mean_square_angle(fit.parameters.value(Quantity::Phase));
    let validity = fit.parameters.value(Quantity::SigmaS) * fit.median_z * angle;
    let message = || {
        format!(
            "tau·{}{suffix} = {validity:.3} is above {SMALL_ANGLE_LIMIT}: {model} rests on small angles, whose \
             transfer function is off by {} here, which the residual does not show; the stated model error, which \
             the intervals hold, is a prediction of first order; use wide-angle, or let the program choose",
            family.mean_square_angle_formula(),
            small_angle_error(validity)
        )
    };
    (model.rests_on_small_angles() && validity > SMALL_ANGLE_LIMIT)
        .then(|| Warning::new(WarningCode::OutsideValidity, message()))
}

fn thick(&Case { suffix, fit, model }: &Case) -> Option<Warning> {
    let tau = fit.parameters.value(Quantity::SigmaS) * fit.median_z;
    let message = || {
        format!(
            "tau{suffix} = {tau:.1} is above {THICKEST}, up to which fits by {model} are tested; look through less of the medium"
        )
    };
    (model == Model::Traced && tau > THICKEST).then(|| Warning::new(WarningCode::OutsideValidity, message()))
}
