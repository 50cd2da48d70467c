//! What follows from the parameters of a fit.

use super::Gauge;
use crate::fit::ChannelFit;
use crate::medium::Medium;
use crate::phase::{Family, Phase, PhaseFunction};
use crate::spread::Model;
use nalgebra::Vector3;
use serde_json::{Value, json};

/// What follows from the parameters of one channel.
pub(super) fn derived(fit: &ChannelFit, model: Model) -> Vec<(&'static str, Value)> {
    let [sigma_s, sigma_a, shape] = fit.parameters.values();
    let phase = fit.parameters.family().phase(shape).expect("parameters stay in their range");
    let medium = Medium::new(sigma_s, sigma_a, phase).expect("parameters stay in their range");
    let error =
        |gradient: [f64; 3], scale: f64| fit.variance_of(&Vector3::from(gradient)).map(|v| v.sqrt() * scale);
    let z = fit.median_z;
    let sigma_t = json!({ "value": medium.sigma_t(), "std_error": error([sigma_s, 1.0, 0.0], 1.0) });
    let mut all = vec![("sigma_t", sigma_t)];
    if model.spreads() {
        let (name, product) = product(sigma_s, fit.parameters.family(), shape);
        all.push((name, json!({ "value": product, "std_error": error([1.0, 0.0, 1.0], product) })));
    }
    all.push(("tau", json!(medium.tau(z))));
    all.push(("optical_depth", json!(medium.sigma_t() * z)));
    all.push(("albedo", json!(medium.albedo())));
    if model.spreads() {
        if let Phase::Gaussian(phase) = phase {
            all.push(("spread_angle_deg", json!(phase.spread_angle().to_degrees())));
        }
        all.push(("g", json!(phase.mean_cosine())));
        let gauge = Gauge::of(fit).expect("parameters stay in their range");
        all.push(("validity", json!(gauge.validity)));
        all.push(("scattered_share", json!(gauge.scattered_share)));
        all.push(("kernel_width_px", json!(gauge.kernel_width_px)));
        all.push(("kernel_width_views", json!(gauge.kernel_width_views)));
        all.push(("verdict", json!(gauge.verdict())));
    }
    all.push(("z", json!(z)));
    all
}

/// What thick media show of sigma_s and the shape: sigma_s·B, or the reduced scattering coefficient sigma_s (1 - g).
fn product(sigma_s: f64, family: Family, shape: f64) -> (&'static str, f64) {
    match family {
        Family::Gaussian => ("sigma_s_b", sigma_s * shape),
        Family::HenyeyGreenstein => ("sigma_s_reduced", sigma_s * (1.0 - shape)),
    }
}
