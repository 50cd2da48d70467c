//! Whether a medium came back from a fit by traced paths.

use super::estimates::{Compared, compare_all};
use narrowbeam::fit::ChannelFit;
use narrowbeam::forward::Quantity;
use narrowbeam::medium::Medium;

/// Errors of the coordinates over what is allowed: 2 %, or three standard errors by the noise of image and paths.
fn misses(fit: &ChannelFit, truth: Medium) -> [(Quantity, f64); 3] {
    let model_error = fit.model_error.as_ref().expect("something is determined");
    let miss = |found: Compared| {
        let paths = model_error.variance_of(&fit.parameters.along(found.id));
        let given = !found.parameter.is_free();
        let std_error = if given { 0.0 } else { found.std_error.expect("determined").hypot(paths.sqrt()) };
        let allowed = (3.0 * std_error).max(0.02 * found.unit());
        println!("  {} {:.5} of {:.5}, ± {std_error:.5}", found.name(), found.value(), found.truth);
        (found.quantity, found.off().abs() / allowed)
    };
    compare_all(fit, truth).map(miss)
}

/// Fails unless the fit is settled and holds `truth`, and would refuse another.
pub fn assert_recovered(name: &str, fit: &ChannelFit, truth: Medium) {
    let paths = fit.paths.unwrap();
    println!(
        "{name}: {} paths, {:.3} effective, {} evaluations, chi² {:.3}",
        paths.count, paths.relative_sample_size, fit.evaluations, fit.reduced_chi2
    );
    assert!(fit.converged && fit.settled, "{name}: {}", fit.stop);
    assert!(paths.relative_sample_size > 0.9, "{name}: {}", paths.relative_sample_size);
    assert!(misses(fit, truth).into_iter().all(|(_, miss)| miss < 1.0), "{name}");
    // A medium that scatters and absorbs 15 % more is refused.
    let more = Medium::new(1.15 * truth.sigma_s(), 1.15 * truth.sigma_a(), *truth.phase()).unwrap();
    let wrong = misses(fit, more);
    let is_refused = |(quantity, miss): &(Quantity, f64)| *quantity != Quantity::Phase && *miss > 1.0;
    assert!(wrong.iter().any(is_refused), "{name}: {wrong:?}");
}
