//! Noise given as a variance image: traced images are fitted with the variance that was traced with them.

use crate::common::estimates::{compare, compare_all, std_error};
use crate::common::planes::PLANE;
use crate::common::program::write_exr;
use crate::common::report::fit_scenes;
use narrowbeam::filter::Filter;
use narrowbeam::fit::{ChannelFit, Settings};
use narrowbeam::forward::Quantity;
use narrowbeam::image::Image;
use narrowbeam::scene::ObservedScene;
use narrowbeam::spread::Model;
use tempfile::TempDir;

const SCENE: &str = "[object]
radiance = \"object.exr\"
depth = 2.0
[camera]
pixel_pitch = 0.03
[observation]
image = \"observed.exr\"
";

/// The fit of `observed`, by way of files, with what `[observation]` further says in `keys`.
fn fit(observed: &Image, variance: &[(&str, Image)], keys: &str) -> ChannelFit {
    let folder = TempDir::new().unwrap();
    let file = |name: &str| folder.path().join(name);
    write_exr(&file("object.exr"), &[("Y", PLANE.texture.image(PLANE.side))]);
    let channels: Vec<(&str, Image)> = variance
        .iter()
        .cloned()
        .chain([("Y", observed.clone())])
        .filter(|(name, _)| *name != "known")
        .collect();
    write_exr(&file("observed.exr"), &channels);
    if let Some((_, known)) = variance.iter().find(|(name, _)| *name == "known") {
        write_exr(&file("known.exr"), &[("Y", known.clone())]);
    }
    std::fs::write(file("scene.toml"), format!("{SCENE}{keys}")).unwrap();
    let scene = ObservedScene::read(&file("scene.toml")).unwrap();
    let settings = Settings { model: Model::WideAngle, ..Settings::default() };
    fit_scenes(&[scene], &settings, Filter::Auto, &|| ()).unwrap().channels.remove(0).1
}

/// Error of `quantity` in standard errors.
fn off(fit: &ChannelFit, quantity: Quantity) -> f64 {
    compare(fit, PLANE.medium, quantity).in_std_errors().unwrap()
}

const SEEDS: u64 = 6;

#[test]
fn a_traced_image_is_fitted_with_its_own_variance() {
    const SAMPLES: u32 = 64;
    let phase = *PLANE.medium.phase();
    let (mut chi2, mut trusting_bright, mut careful) = (0.0, 0.0, 0.0);
    for seed in 1..=SEEDS {
        let traced = PLANE.trace(phase, SAMPLES, seed).unwrap();
        let other = PLANE.trace(phase, SAMPLES, seed + 1000).unwrap().variance;
        let own =
            fit(&traced.mean, &[("Y.variance", traced.variance.clone())], "variance = \"observed.exr\"");
        let naive = fit(&traced.mean, &[("known", traced.variance)], "variance = \"known.exr\"");
        let independent = fit(&traced.mean, &[("known", other)], "variance = \"known.exr\"");
        chi2 += own.reduced_chi2 / SEEDS as f64;
        for found in compare_all(&own, PLANE.medium) {
            let model = own.model_error.as_ref().unwrap().of(&own.parameters.along(found.id));
            let (name, in_errors) = (found.name(), found.in_std_errors().unwrap());
            println!("seed {seed}, {name}: {in_errors:+.2} standard errors");
            // 18 normal numbers stay within 4 but once in 900 runs.
            assert!(found.off().abs() < 4.0 * found.std_error.unwrap() + model, "{name}");
        }
        let [own, naive, independent] = [own, naive, independent].map(|fit| off(&fit, Quantity::SigmaS));
        careful += (own - independent) / SEEDS as f64;
        trusting_bright += (naive - independent) / SEEDS as f64;
    }
    println!(
        "chi² {chi2:.4}; away from variances of other paths: {careful:.2}, pixel by pixel {trusting_bright:.2}"
    );
    // chi² of 6 times 2304 numbers: four times sqrt(2 / 13824), and 1/64 for variances of 64 samples each.
    assert!((chi2 - 1.0).abs() < 0.064, "{chi2}");
    // Weights that go with the noise pull the estimate, those of neighbours no more than those of other paths.
    assert!(careful.abs() < 0.2 && trusting_bright < -0.4, "{careful} {trusting_bright}");
}

#[test]
fn variances_of_few_samples_leave_the_intervals_as_they_should_be() {
    const SAMPLES: u32 = 32;
    let phase = *PLANE.medium.phase();
    let (mut held, mut all) = (0, 0);
    for seed in 101..=112 {
        let traced = PLANE.trace(phase, SAMPLES, seed).unwrap();
        let own = fit(&traced.mean, &[("Y.variance", traced.variance)], "variance = \"observed.exr\"");
        for found in compare_all(&own, PLANE.medium) {
            let model = own.model_error.as_ref().unwrap().of(&own.parameters.along(found.id));
            all += 1;
            held += u32::from(found.off().abs() < 1.96 * found.std_error.unwrap() + model);
        }
    }
    println!("{held} of {all} intervals hold the truth");
    // Of 36 at 95 %, fewer than 30 hold it once in 200 times.
    assert!(all == 36 && held >= 30, "{held} of {all}");
}

#[test]
fn one_variance_for_all_pixels_is_one_level_of_noise() {
    let phase = *PLANE.medium.phase();
    let observed = PLANE.trace(phase, 64, 1).unwrap().mean;
    let level = |noise: f64| fit(&observed, &[], &format!("noise = {noise}"));
    let variance = |v: f32| {
        fit(&observed, &[("known", Image::filled(PLANE.side, PLANE.side, v))], "variance = \"known.exr\"")
    };
    // More noise than there is: less would be found in the residual, and widen the error bars.
    let (by_level, by_variance, louder) = (level(0.1), variance(1e-2), variance(4e-2));
    for quantity in Quantity::MEDIUM {
        let error = |fit: &ChannelFit| std_error(fit, quantity);
        // Up to where the solver stops.
        assert!((off(&by_level, quantity) - off(&by_variance, quantity)).abs() < 0.02);
        assert!((error(&by_variance) / error(&by_level) - 1.0).abs() < 1e-3);
        assert!((error(&louder) / error(&by_level) - 2.0).abs() < 2e-3);
    }
    assert!((by_variance.reduced_chi2 / by_level.reduced_chi2 - 1.0).abs() < 1e-5);
    assert!((louder.reduced_chi2 / by_level.reduced_chi2 - 0.25).abs() < 1e-5);
}
