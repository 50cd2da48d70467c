//! Whether a medium came back from a fit by traced paths.

use nalgebra::Vector3;
use narrowbeam::fit::ChannelFit;

/// Errors of the coordinates over what is allowed: 2 %, or three standard errors by the noise of image and paths.
fn misses(fit: &ChannelFit, truth: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| {
        let along = Vector3::ith(i, 1.0);
        let paths = fit.model_error.expect("something is determined").variance_of(&along);
        let given = fit.parameters.is_fixed(i);
        let std_error = fit.uncertainty.std_error(i);
        let std_error = if given { 0.0 } else { std_error.expect("determined").hypot(paths.sqrt()) };
        let [found, wanted] = [fit.parameters.values()[i], truth[i]].map(|v| fit.parameters.coordinate(i, v));
        let allowed = (3.0 * std_error).max(if i == 1 { 0.02 * wanted } else { 0.02 });
        println!(
            "  {} {:.5} of {:.5}, ± {std_error:.5}",
            fit.parameters.names()[i],
            fit.parameters.values()[i],
            truth[i]
        );
        (found - wanted).abs() / allowed
    })
}

/// Fails unless the fit is settled and holds `truth`, and would refuse another.
pub fn assert_recovered(name: &str, fit: &ChannelFit, truth: [f64; 3]) {
    let (paths, share) = fit.paths.unwrap();
    println!(
        "{name}: {paths} paths, {share:.3} effective, {} evaluations, chi² {:.3}",
        fit.evaluations, fit.reduced_chi2
    );
    assert!(fit.converged && fit.settled, "{name}: {}", fit.stop);
    assert!(share > 0.9, "{name}: {share}");
    assert!(misses(fit, truth).into_iter().all(|m| m < 1.0), "{name}");
    // A medium that scatters and absorbs 15 % more is refused.
    let wrong = misses(fit, [1.15 * truth[0], 1.15 * truth[1], truth[2]]);
    assert!(wrong[0].max(wrong[1]) > 1.0, "{name}: {wrong:?}");
}
