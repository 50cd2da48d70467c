//! Fits by Gram matrices against renders: the images that the matrices are made of, and the answers.

use crate::common::estimates::compare_all;
use crate::common::{bundled, pixels, sloping, texture, with_noise};
use narrowbeam::filter::basis::Basis;
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Filter, Optics, Target};
use narrowbeam::fit::{ChannelFit, NoiseTerm, Observation, Settings, VeilTerm, fit_channel};
use narrowbeam::geometry::{Field, Geometry};
use narrowbeam::image::{Border, Image, View};
use narrowbeam::imaging::VeilField;
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::scene::{FitOptions, Gain};
use narrowbeam::spread::Model;

/// The render of a basis' target by its images, or for `part` 1 to 3 a derivative.
fn by_basis(basis: &Basis, view: View, optics: &Optics, part: usize) -> Image {
    let weights = basis.weights(optics).unwrap();
    let weight = |c: usize| if part == 0 { weights[c].value } else { weights[c].gradient[part - 1] };
    let images = basis.images();
    let mut sum = Image::filled(view.width, view.height, 0.0);
    for strip in images.strips() {
        images.blocks(&strip, 16, |columns, block| {
            for (c, image) in block.iter().enumerate() {
                for (x, lane) in columns.clone().zip(image) {
                    for (y, v) in strip.clone().zip(lane) {
                        sum.data[y * view.width + x] += weight(c) as f32 * v;
                    }
                }
            }
        });
    }
    sum
}

#[test]
fn the_images_of_the_basis_add_up_to_renders() {
    let (z, b) = (2.0, 0.004_f64);
    let phase = Gaussian::new(b).unwrap();
    let object = texture(72, 60);
    let view = View { x: 7, y: 3, width: 45, height: 50 };
    println!("L2 from renders over that of the image: image, and derivatives times sigma_s, sigma_a, B");
    let compare = |border: Border, model: Model, width_px: f64, tau: f64| -> [f64; 4] {
        let geometry = Geometry::planar(72, 60, z * b.sqrt() / width_px, z).unwrap();
        let target = Target::plain(&object, &geometry, border, view);
        let basis = Basis::new(target).unwrap().unwrap();
        let optics = Optics { model, medium: Medium::new(tau / z, 0.1, phase.into()).unwrap() };
        let filter = CpuFilter::new(target, &optics, 1.0).unwrap();
        let render = filter.render_with_gradient(&optics).unwrap();
        let [s, a, d] = render.gradient.unwrap();
        let all = [(1.0, render.image), (tau / z, s), (0.1, a), (b, d)];
        let length = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
        let error = |part: usize| {
            let (scale, image) = &all[part];
            let found = by_basis(&basis, view, &optics, part);
            let mut off = pixels(&found).zip(pixels(image)).map(|(a, b)| scale * (a - b));
            length(&mut off) / length(&mut pixels(&all[0].1))
        };
        let errors: [f64; 4] = std::array::from_fn(error);
        let text = errors.map(|e| format!("{e:8.1e}")).join(" ");
        println!("{border:?} {model} {width_px} px, tau {tau}: {text}");
        errors
    };
    let mut worst = [0.0_f64; 4];
    for model in Model::ALL.into_iter().filter(|m| m.spreads()) {
        for (tau, widths) in [(0.3, [0.05, 0.7, 12.0, 200.0]), (4.0, [0.2, 3.0, 40.0, 100.0])] {
            for width_px in widths {
                let errors = compare(Border::Mirror, model, width_px, tau);
                worst = std::array::from_fn(|i| worst[i].max(errors[i]));
            }
        }
    }
    for border in [Border::Zero, Border::Clamp] {
        for width_px in [0.7, 12.0] {
            let errors = compare(border, Model::SmallAngle, width_px, 1.0);
            worst = std::array::from_fn(|i| worst[i].max(errors[i]));
        }
    }
    println!("worst {}", worst.map(|e| format!("{e:8.1e}")).join(" "));
    // Widths a factor 1.3 apart leave 1e-4 of a Gaussian's transfer function, at a few frequencies, and less of others'.
    assert!(worst[0] < 3e-5 && worst[2] < 3e-5 && worst[1] < 3e-4 && worst[3] < 3e-4, "{worst:?}");
}

/// sigma_s, sigma_a and B.
const TRUTH: (f64, f64, f64) = (0.7, 0.15, 0.004);
const NOISE: f64 = 0.003;

/// A scene that a fit is asked about.
struct Made {
    object: Image,
    geometry: Geometry,
    border: Border,
    view: View,
    observed: Image,
}

impl Made {
    fn new(geometry: Geometry, model: Model, border: Border, view: View, seed: u64) -> Self {
        let object = texture(geometry.width, geometry.height);
        let (sigma_s, sigma_a, b) = TRUTH;
        let optics = Optics { model, medium: Medium::gaussian(sigma_s, sigma_a, b).unwrap() };
        let mut made = Self { object, geometry, border, view, observed: Image::filled(1, 1, 0.0) };
        let clean = CpuFilter::new(made.target(), &optics, 1.0).unwrap().render(&optics).unwrap();
        made.observed = with_noise(&clean, NOISE, seed);
        made
    }

    fn plane(model: Model, border: Border, view: View) -> Self {
        Self::new(Geometry::planar(64, 64, 0.03, 2.0).unwrap(), model, border, view, 1)
    }

    fn target(&self) -> Target<'_> {
        let Self { object, geometry, border, view, .. } = self;
        Target::plain(object, geometry, *border, *view)
    }

    fn observation(&self) -> Observation<'_> {
        Observation::plain(self.target(), &self.observed)
    }
}

fn fit(observations: &[Observation], model: Model, gram: bool) -> ChannelFit {
    let settings = Settings { model, gram, ..Settings::default() };
    fit_channel(observations, &FitOptions::default(), &settings, &|| ()).unwrap()
}

/// Distance of `medium` from the fit's, in standard errors: the largest over what the fit determines.
fn distance(fit: &ChannelFit, medium: Medium) -> f64 {
    let in_std_errors = compare_all(fit, medium).into_iter().filter_map(|found| found.in_std_errors());
    in_std_errors.map(f64::abs).fold(0.0, f64::max)
}

/// What Gram matrices may differ by from renders, in standard errors.
const AGREED: f64 = 0.1;

/// Asserts that the Gram matrices' own answer, and the one that renders have made of it, are that of a fit by renders alone.
fn assert_agreed(what: &str, observations: &[Observation], model: Model) {
    let (fast, full) = (fit(observations, model, true), fit(observations, model, false));
    let by_gram = fast.by_gram.as_ref().expect("the scene has a Gram matrix");
    let off = [by_gram, &fast.parameters].map(|found| distance(&full, found.medium().unwrap()));
    println!(
        "{what}: Gram matrices {:.4}, confirmed {:.4} standard errors off; {} renders and {} evaluations by Gram \
         matrices, {} renders alone",
        off[0], off[1], fast.evaluations, fast.gram_evaluations, full.evaluations
    );
    assert!(full.by_gram.is_none() && fast.converged, "{what}");
    assert!(off[0] < AGREED && off[1] < AGREED, "{what}: {off:?}");
}

#[test]
fn gram_matrices_give_the_answer_of_renders() {
    let whole = View::whole(64, 64);
    for model in Model::ALL.into_iter().filter(|m| m.spreads()) {
        let made = Made::plane(model, Border::Zero, whole);
        assert_agreed(model.name(), &[made.observation()], model);
    }
    let model = Model::SmallAngle;
    for border in [Border::Clamp, Border::Mirror] {
        let made = Made::plane(model, border, whole);
        assert_agreed(&format!("{border:?}"), &[made.observation()], model);
    }
    let made = Made::plane(model, Border::Zero, View { x: 11, y: 5, width: 40, height: 35 });
    assert_agreed("part of the object", &[made.observation()], model);
    let mut made = Made::plane(model, Border::Zero, whole);
    let mask = Image::from_fn(64, 64, |x, y| f32::from(u8::from((x * x + y * y) % 7 < 4 && x + y > 30)));
    assert_agreed("mask", &[Observation { mask: Some(&mask), ..made.observation() }], model);
    let variance =
        Image::from_fn(64, 64, |x, _| NOISE as f32 * NOISE as f32 * (0.2 + x as f32 / 8.0).powi(2));
    let uneven =
        Observation { mask: Some(&mask), noise: Some(NoiseTerm::Variance(&variance)), ..made.observation() };
    assert_agreed("variances", &[uneven], model);
    assert_agreed(
        "variances and a free veil",
        &[Observation { veil: VeilTerm::Free(VeilField::Constant), ..uneven }],
        model,
    );
    made.observed.data.iter_mut().for_each(|v| *v = 1.3 * *v + 0.2);
    let exposed =
        Observation { gain: Gain::Free, veil: VeilTerm::Free(VeilField::Constant), ..made.observation() };
    assert_agreed("free gain and veil", &[exposed], model);
}

#[test]
fn so_they_do_for_several_scenes_and_depths() {
    let (model, whole) = (Model::SmallAngle, View::whole(64, 64));
    let scenes: Vec<Made> = [(1.0, 0.02), (2.0, 0.03)]
        .into_iter()
        .map(|(z, pitch)| {
            let geometry = Geometry::planar(64, 64, pitch, z).unwrap();
            Made::new(geometry, model, Border::Zero, whole, 2)
        })
        .collect();
    let observations: Vec<Observation> = scenes
        .iter()
        .map(|m| Observation { veil: VeilTerm::Free(VeilField::Constant), ..m.observation() })
        .collect();
    assert_agreed("two scenes", &observations, model);

    let depth = Field::Map(Image::from_fn(64, 64, |x, y| if (x / 16 + y / 16) % 2 == 0 { 1.5 } else { 2.5 }));
    let geometry = Geometry { depth, ..Geometry::planar(64, 64, 0.03, 2.0).unwrap() };
    let made = Made::new(geometry, model, Border::Zero, whole, 3);
    assert_agreed("two depths", &[Observation { gain: Gain::Free, ..made.observation() }], model);

    let made = Made::new(sloping(64, 64, 0.03, 2.0, 0.5), model, Border::Zero, whole, 4);
    assert!(
        fit(&[made.observation()], model, true).by_gram.is_none(),
        "a slope has more depths than Gram matrices pay for"
    );
}

#[test]
fn another_medium_is_not_taken_for_the_answer() {
    let made = Made::plane(Model::SmallAngle, Border::Zero, View::whole(64, 64));
    let fit = fit(&[made.observation()], Model::SmallAngle, true);
    for (id, moved) in fit.parameters.of_medium() {
        let error = fit.covariance.std_error(id).unwrap();
        let value = |name: &str| {
            let parameter = &fit.parameters[name];
            let step = if name == moved.name() { 0.2 * error } else { 0.0 };
            parameter.value_at(parameter.coordinate() + step)
        };
        let other = Medium::gaussian(value("sigma_s"), value("sigma_a"), value("b")).unwrap();
        assert!(distance(&fit, other) > AGREED, "{}", moved.name());
    }
    assert_eq!(distance(&fit, fit.parameters.medium().unwrap()), 0.0);
}

#[test]
fn the_report_names_the_path() {
    let path = |dataset: &str| {
        let summary = &bundled::fit(dataset, Model::SmallAngle, Filter::Auto).report.fit;
        (summary.path.clone(), summary.sum_evaluations > 0)
    };
    assert_eq!(path("mitsuba-checker"), ("sums".into(), true));
    // Its near plane is an occluder.
    assert_eq!(path("mitsuba-planes"), ("renders".into(), false));
}
