//! The ladder of Gaussians and the sums of a fit against renders.

mod common;

use common::{pixels, relative_l2, texture};
use narrowbeam::filter::basis::Basis;
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Optics, Target};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::phase::Gaussian;
use narrowbeam::spread::Model;

/// The render of `target` as a sum of the basis' images: value or, for `part` 1 to 3, a derivative.
fn by_basis(basis: &Basis, view: View, optics: &Optics, part: usize) -> Image {
    let weights = basis.weights(optics).unwrap();
    let weight = |c: usize| match part {
        0 => weights[c].value as f32,
        _ => weights[c].gradient[part - 1] as f32,
    };
    let images = basis.images();
    let mut sum = Image::filled(view.width, view.height, 0.0);
    for strip in images.strips() {
        images.blocks(&strip, 16, |columns, block| {
            for (c, image) in block.iter().enumerate() {
                for (x, lane) in columns.clone().zip(image) {
                    for (y, v) in strip.clone().zip(lane) {
                        sum.data[y * view.width + x] += weight(c) * v;
                    }
                }
            }
        });
    }
    sum
}

#[test]
fn the_ladder_makes_the_images_of_renders() {
    let (z, b) = (2.0, 0.004_f64);
    let phase = Gaussian::new(b).unwrap();
    let object = texture(96, 80);
    println!("relative L2 from renders: image, and derivatives in sigma_s, sigma_a, B");
    for border in [Border::Zero, Border::Clamp, Border::Mirror] {
        for model in Model::ALL {
            for width_px in [0.05, 0.2, 0.7, 3.0, 12.0, 40.0, 200.0] {
                let geometry = Geometry::planar(96, 80, z * b.sqrt() / width_px, z).unwrap();
                let view = View { x: 7, y: 3, width: 61, height: 50 };
                let target = Target {
                    radiance: &object,
                    behind: &[],
                    geometry: &geometry,
                    border,
                    view,
                    relief: None,
                };
                let basis = Basis::new(target).unwrap();
                for tau in [0.3, 4.0] {
                    let medium = Medium::new(tau / z, 0.1).unwrap();
                    let optics = Optics { model, medium, phase: &phase };
                    let render =
                        CpuFilter::new(target, &optics, 1.0).unwrap().render_with_gradient(&optics).unwrap();
                    let [s, a, d] = render.gradient.unwrap();
                    let all = [render.image, s, a, d];
                    let errors: Vec<f64> = all
                        .iter()
                        .enumerate()
                        .map(|(part, image)| {
                            relative_l2(pixels(&by_basis(&basis, view, &optics, part)), pixels(image))
                        })
                        .collect();
                    let text: Vec<String> = errors.iter().map(|e| format!("{e:8.1e}")).collect();
                    println!("{border:?} {model} {width_px} px, tau {tau}: {}", text.join(" "));
                }
            }
        }
    }
}
