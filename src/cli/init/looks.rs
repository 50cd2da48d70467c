//! What two photographs look like before they are fitted, and what may be expected of a fit.

use crate::cli::aligned;
use crate::error::Result;
use crate::filter::{Filter, coarse_shift};
use crate::fit::{Plan, Settings, forecast};
use crate::image::Image;
use crate::medium::Medium;
use crate::scene::{ObservedScene, Scene};

/// The medium that is expected where nothing is known: scattering depth 1, a tenth of it absorbed, spread angle 8°.
const TAU: f64 = 1.0;
const ABSORBED: f64 = 0.1;
const B: f64 = 0.00487;
/// Contrast, standard deviation over mean, below which a photograph shows too little.
const LEAST_CONTRAST: f64 = 0.05;
/// Share of saturated pixels above which the exposure is too long.
const MOST_SATURATED: f64 = 0.01;
/// Shift in px from which on photographs do not lie on each other.
const MOVED: f64 = 0.05;
/// The median of the magnitude of a normal number, in standard deviations.
const MEDIAN: f64 = 0.6745;
/// Pixels up to which the expected errors are computed at once: a few seconds.
const QUICK: usize = 1 << 20;

/// What was seen in each channel.
pub(super) struct Looks {
    channels: Vec<Channel>,
    saturated: f64,
    /// Rows of the table of expected errors; `None` for large photographs.
    expected: Option<Vec<Vec<String>>>,
}

struct Channel {
    name: String,
    contrast: [f64; 2],
    noise: f64,
    mean: f64,
    shift_px: [f64; 2],
}

impl Looks {
    /// At the photographs of a scene.
    ///
    /// # Errors
    /// Those of [`forecast`].
    pub(super) fn at(seen: &ObservedScene) -> Result<Self> {
        let ObservedScene { scene, observation } = seen;
        let mask = observation.mask.as_ref();
        let channel = |(object, observed): (&crate::image::Channel, &crate::image::Channel)| {
            let clear = object.image.crop(scene.view);
            Channel {
                name: object.name.clone(),
                contrast: [contrast(&clear), contrast(&observed.image)],
                noise: noise(&observed.image),
                mean: observed.image.mean(),
                shift_px: coarse_shift(&clear, &observed.image, mask),
            }
        };
        let channels: Vec<Channel> = scene.object.iter().zip(&observation.image).map(channel).collect();
        let expected = (scene.view.pixels() <= QUICK).then(|| expected(scene, &channels)).transpose()?;
        let saturated = observation.saturated_pixels as f64 / scene.view.pixels() as f64;
        Ok(Self { channels, saturated, expected })
    }

    /// All of it for people.
    pub(super) fn lines(&self, seen: &ObservedScene) -> String {
        let ObservedScene { scene, observation } = seen;
        let (g, view) = (&scene.geometry, scene.view);
        let mut text =
            format!("clear: {}x{} px; turbid: {}x{} px\n", g.width, g.height, view.width, view.height);
        let mut wrong = Vec::new();
        if self.saturated > 0.0 {
            text += &format!("saturated: {:.2} % of the pixels are left out\n", 100.0 * self.saturated);
        }
        if self.saturated > MOST_SATURATED {
            wrong.push("many pixels are saturated: expose for a shorter time".to_string());
        }
        for channel in &self.channels {
            let Channel { name, contrast: [clear, turbid], noise, mean, shift_px: [x, y] } = channel;
            text += &format!(
                "{name}: contrast {clear:.3} clear, {turbid:.3} turbid; noise at most {noise:.2e}, {:.1} % of the mean; shifted by {x:+.2} px to \
                 the right, {y:+.2} px down\n",
                100.0 * noise / mean
            );
            if *clear < LEAST_CONTRAST {
                wrong.push(format!(
                    "{name}: the clear photograph shows next to nothing: take an object with edges"
                ));
            }
            if *turbid < 2.0 * noise / mean {
                wrong.push(format!(
                    "{name}: the turbid photograph shows little more than noise: go nearer, or expose longer"
                ));
            }
            if x.abs().max(y.abs()) > MOVED {
                text +=
                    &format!("{name}: the camera has moved; registration = \"shift\" takes care of that\n");
            }
        }
        if (g.width, g.height) == (view.width, view.height) {
            wrong.push(
                "the clear photograph is no larger than the turbid one: light from outside the frame is guessed; take a larger one, or crop the \
                 turbid one"
                    .to_string(),
            );
        }
        let cautions = scene.cautions.iter().chain(&observation.cautions);
        wrong.extend(cautions.map(|caution| caution.message.clone()));
        wrong.push(
            "the exposure is not known: sigma_a remains undetermined; state gain, if it is".to_string(),
        );
        wrong.iter().for_each(|line| text += &format!("note: {line}\n"));
        match &self.expected {
            None => text += "expected errors: run narrowbeam forecast\n",
            Some(rows) => {
                text += "\nexpected of a fit, if the medium has a scattering depth of 1 and a spread angle of 8°:\n";
                text += &aligned(rows);
            }
        }
        text
    }
}

/// The errors to expect in a medium that is neither thin nor thick.
fn expected(scene: &Scene, channels: &[Channel]) -> Result<Vec<Vec<String>>> {
    let z = crate::geometry::path_lengths(&[(&scene.geometry, &scene.object[0].image)]).median;
    let medium = Medium::gaussian(TAU / z, ABSORBED * TAU / z, B)?;
    let noise = channels.iter().map(|channel| channel.noise).fold(f64::MIN_POSITIVE, f64::max);
    let plan = Plan { noise, free_gain: true, free_veil: true };
    let media = vec![medium; scene.object.len()];
    let fit = forecast(std::slice::from_ref(scene), &media, &plan, &Settings::default(), Filter::Auto)?;
    Ok(fit.report.table("1/length"))
}

/// Standard deviation over mean.
fn contrast(image: &Image) -> f64 {
    let mean = image.mean();
    let square =
        image.data.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / image.data.len() as f64;
    square.sqrt() / mean.abs().max(f64::MIN_POSITIVE)
}

/// Standard deviation of a pixel's noise by the Laplacian, of which white noise has 20 times its variance; the median leaves out edges.
fn noise(image: &Image) -> f64 {
    let inner = |n: usize| 1..n.saturating_sub(1);
    let at = |x: usize, y: usize| f64::from(image.at(x, y));
    let laplacian =
        |x: usize, y: usize| 4.0 * at(x, y) - at(x - 1, y) - at(x + 1, y) - at(x, y - 1) - at(x, y + 1);
    let rows = inner(image.height).flat_map(|y| inner(image.width).map(move |x| (x, y)));
    let mut magnitudes: Vec<f64> = rows.map(|(x, y)| laplacian(x, y).abs()).collect();
    if magnitudes.is_empty() {
        return 0.0;
    }
    let middle = magnitudes.len() / 2;
    *magnitudes.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN / 20_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::noise::with_noise;

    #[test]
    fn noise_is_found_beside_edges() {
        let edges = Image::from_fn(96, 96, |x, y| if (x / 24 + y / 24) % 2 == 0 { 0.2 } else { 0.7 });
        let found = noise(&with_noise(&edges, 0.01, 3));
        assert!((found / 0.01 - 1.0).abs() < 0.15, "{found}");
    }
}
