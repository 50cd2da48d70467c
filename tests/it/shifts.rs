//! Renders moved by a fraction of a pixel: what a shift is, on the CPU against the f64 implementation, and its derivatives.

use crate::common::{pixels, relative_l2, sloping, texture};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Backend, Filter, Optics, Prepared, Target, direct_sum, per_depth};
use narrowbeam::geometry::{Camera, Field, Geometry};
use narrowbeam::image::{Border, Image, Sampling, View};
use narrowbeam::medium::Medium;
use narrowbeam::relief::Relief;
use narrowbeam::spread::Model;

const B: f64 = 0.004;

fn optics(b: f64) -> Optics {
    Optics { model: Model::SmallAngle, medium: Medium::gaussian(0.9, 0.1, b).unwrap() }
}

/// A texture before a geometry, of which the view shows a part.
struct Scene {
    radiance: Image,
    geometry: Geometry,
    border: Border,
    view: View,
    relief: Option<Relief>,
}

impl Scene {
    fn new(geometry: Geometry, border: Border) -> Self {
        let (width, height) = (geometry.width, geometry.height);
        let view = View { x: 6, y: 4, width: width - 12, height: height - 8 };
        Self { radiance: texture(width, height), geometry, border, view, relief: None }
    }

    /// A plane at the depth 1.5 whose kernel is about 1.2 px wide.
    fn plane(size: [usize; 2], border: Border) -> Self {
        Self::new(Geometry::planar(size[0], size[1], 0.08, 1.5).unwrap(), border)
    }

    fn slope(border: Border) -> Self {
        Self::new(sloping(40, 32, 0.1, 1.5, 0.3), border)
    }

    /// With blobs in its middle instead, which have no frequencies above pi and nothing at the border.
    fn smooth(self) -> Self {
        let [x, y] = [self.radiance.width, self.radiance.height].map(|n| 0.5 * n as f32);
        let blob = |x: f32, y: f32, width: f32| (-(x * x + y * y) / (2.0 * width * width)).exp();
        let radiance = Image::from_fn(self.radiance.width, self.radiance.height, |i, j| {
            let (u, v) = (i as f32 - x, j as f32 - y);
            blob(u + 4.0, v - 1.0, 2.0) + 0.6 * blob(u - 3.0, v + 2.0, 2.2)
        });
        Self { radiance, ..self }
    }

    /// Seen under 40 degrees; the view is not in the middle.
    fn perspective(border: Border) -> Self {
        let (width, height) = (36, 30);
        let camera = Camera::perspective(40.0).unwrap();
        let flat = Geometry {
            width,
            height,
            camera,
            depth: Field::Uniform(2.0),
            behind: Vec::new(),
            surface: Field::Uniform(0.0),
        };
        let depth = Image::from_fn(width, height, |x, y| (2.0 / flat.cos_off_axis(x, y)) as f32);
        let view = View { x: 1, y: 3, width: 28, height: 20 };
        Self { view, ..Self::new(Geometry { depth: Field::Map(depth), ..flat }, border) }
    }

    /// A half plane before a slope.
    fn edge(border: Border) -> Self {
        let geometry = crate::common::edge_and_slope(40);
        let relief = Filter::Composite.relief(&geometry);
        Self { relief, ..Self::new(geometry, border) }
    }

    fn target(&self) -> Target<'_> {
        Target {
            radiance: &self.radiance,
            behind: &[],
            geometry: &self.geometry,
            border: self.border,
            sampling: Sampling::Pixel,
            view: self.view,
            relief: self.relief.as_ref(),
        }
    }

    fn filter(&self) -> CpuFilter<'_> {
        CpuFilter::new(self.target(), &optics(B), 1.0).unwrap()
    }

    fn shifted(&self, shift_px: [f64; 2]) -> Vec<f64> {
        pixels(&self.filter().render_shifted(&optics(B), shift_px).unwrap()).collect()
    }
}

const BORDERS: [Border; 3] = [Border::Zero, Border::Clamp, Border::Mirror];

#[test]
fn no_shift_changes_nothing() {
    for scene in
        [Scene::plane([40, 32], Border::Zero), Scene::perspective(Border::Mirror), Scene::edge(Border::Clamp)]
    {
        let filter = scene.filter();
        let plain = filter.render_with_gradient(&optics(B)).unwrap();
        let shifted = filter.render_shifted_with_gradient(&optics(B), [0.0; 2]).unwrap();
        assert!(plain.motion.is_none() && shifted.motion.is_some());
        let image = filter.render_shifted(&optics(B), [0.0; 2]).unwrap();
        assert_eq!(image, shifted.image);
        let gradients = shifted.gradient.unwrap().into_iter().zip(plain.gradient.unwrap());
        for (a, b) in std::iter::once((shifted.image, plain.image)).chain(gradients) {
            let off = relative_l2(pixels(&a), pixels(&b));
            assert!(off < 3e-7, "f32 there and back: {off:.1e}");
        }
    }
}

#[test]
fn whole_pixels_translate_the_render() {
    for border in BORDERS {
        let scene = Scene::plane([40, 32], border);
        let whole = Scene { view: View::whole(40, 32), ..Scene::plane([40, 32], border) };
        let wide = whole.filter().render(&optics(B)).unwrap();
        let View { x, y, width, height } = scene.view;
        // The view lies 6 and 4 px within the image, so this brings in nothing but the image.
        let (dx, dy) = (-5, 3);
        let translated = Image::from_fn(width, height, |i, j| {
            wide.at((x + i).wrapping_add_signed(-dx), (y + j).wrapping_add_signed(-dy))
        });
        let off = relative_l2(scene.shifted([dx as f64, dy as f64]), pixels(&translated));
        assert!(off < 3e-7, "{border:?}: {off:.1e}");
        assert!(relative_l2(scene.shifted([5.0, -3.0]), pixels(&translated)) > 0.1, "the other way");
    }
}

#[test]
fn a_mirrored_border_comes_in_mirrored() {
    let scene = Scene { view: View::whole(40, 32), ..Scene::plane([40, 32], Border::Mirror) };
    let image = scene.filter().render(&optics(B)).unwrap();
    let at = |i: i64, n: usize| Border::Mirror.index(i, n).unwrap();
    let mirrored = Image::from_fn(40, 32, |x, y| image.at(at(x as i64 - 9, 40), at(y as i64 + 7, 32)));
    let off = relative_l2(scene.shifted([9.0, -7.0]), pixels(&mirrored));
    assert!(off < 3e-7, "{off:.1e}");
}

#[test]
fn whole_pixels_translate_the_definition() {
    for border in BORDERS {
        let scene = Scene::plane([30, 26], border);
        let View { x, y, width, height } = scene.view;
        let moved = Target { view: View { x: x + 2, y: y - 3, width, height }, ..scene.target() };
        let definition = direct_sum::render(&moved, &optics(B)).unwrap();
        let second = per_depth::render_shifted(&scene.target(), &optics(B), [-2.0, 3.0]).unwrap();
        let off = relative_l2(second, definition);
        // The bound of the second implementation, tests/filter_implementations.rs: a shift by whole pixels adds nothing to it.
        assert!(off < 2e-5, "{border:?}: {off:.1e}");
    }
}

/// As for images that stand still, tests/filter_implementations.rs: a shift adds the roundings of two transforms.
const FAST_RUNG: f64 = 1e-4;

/// How far the CPU's render moved by `shift_px` is from that of the f64 implementation moved by `exact_px`.
fn from_f64(scene: &Scene, shift_px: [f64; 2], exact_px: [f64; 2]) -> f64 {
    let second = per_depth::render_shifted(&scene.target(), &optics(B), exact_px).unwrap();
    relative_l2(scene.shifted(shift_px), second)
}

#[test]
fn shifts_agree_with_the_f64_implementation() {
    // Edges of the texture have the highest frequency too, of which a shift makes waves over all of the canvas. The implementations
    // pad alike only where the border is mirrored.
    let mirrored = [Scene::plane, |_, border| Scene::slope(border), |_, border| Scene::perspective(border)];
    for scene in mirrored.map(|scene| scene([40, 32], Border::Mirror)) {
        let off = from_f64(&scene, [-2.6, 3.45], [-2.6, 3.45]);
        println!("{:?}: {off:.1e}", scene.view);
        assert!(off < FAST_RUNG, "{off:.1e}");
    }
    for border in BORDERS {
        for scene in [Scene::plane([40, 32], border).smooth(), Scene::slope(border).smooth()] {
            for shift_px in [[0.3, -0.2], [-2.6, 3.45]] {
                let off = from_f64(&scene, shift_px, shift_px);
                println!("{border:?}, {shift_px:?}: {off:.1e}");
                assert!(off < FAST_RUNG, "{border:?}, {shift_px:?}: {off:.1e}");
            }
        }
    }
    let off = from_f64(&Scene::perspective(Border::Clamp).smooth(), [0.3, -0.2], [0.3, -0.2]);
    assert!(off < FAST_RUNG, "{off:.1e}");
}

#[test]
fn a_hundredth_of_a_pixel_is_told_apart() {
    for scene in [Scene::plane([40, 32], Border::Mirror), Scene::slope(Border::Zero).smooth()] {
        for wrong in [[0.31, -0.2], [0.3, -0.21]] {
            assert!(from_f64(&scene, wrong, [0.3, -0.2]) > 5.0 * FAST_RUNG);
        }
    }
}

#[test]
fn derivatives_are_those_of_the_shifted_image() {
    let shift_px = [0.35, -0.6];
    for scene in [Scene::slope(Border::Zero), Scene::perspective(Border::Clamp), Scene::edge(Border::Mirror)]
    {
        let filter = scene.filter();
        let rendering = filter.render_shifted_with_gradient(&optics(B), shift_px).unwrap();
        let of = |sigma_s: f64, sigma_a: f64, b: f64, shift_px: [f64; 2]| -> Vec<f64> {
            let optics = Optics { medium: Medium::gaussian(sigma_s, sigma_a, b).unwrap(), ..optics(b) };
            pixels(&filter.render_shifted(&optics, shift_px).unwrap()).collect()
        };
        let at = |step: [f64; 5]| {
            let [s, a, b, x, y] = step;
            of(0.9 + s, 0.1 + a, B + b, [shift_px[0] + x, shift_px[1] + y])
        };
        let derivatives = rendering.gradient.iter().flatten().chain(rendering.motion.iter().flatten());
        for (i, (derivative, step)) in derivatives.zip([1e-2, 1e-2, 1e-2 * B, 1e-2, 1e-2]).enumerate() {
            let sides = [step, -step].map(|step| {
                let mut steps = [0.0; 5];
                steps[i] = step;
                at(steps)
            });
            let [more, less] = &sides;
            let slope: Vec<f64> = more.iter().zip(less).map(|(a, b)| (a - b) / (2.0 * step)).collect();
            let off = relative_l2(pixels(derivative), slope);
            println!("{i}: {off:.1e}");
            // A central difference errs by the square of its relative step, some 1e-4.
            assert!(off < 5e-4, "derivative {i}: {off:.1e}");
        }
    }
}

/// Light that leaves on one side must not come back on the other, though the kernel is narrow.
#[test]
fn padding_for_shifts_keeps_the_far_side_out() {
    let optics = optics(B);
    for (border, inner) in [(Border::Zero, None), (Border::Clamp, Some(0))] {
        let geometry = Geometry::planar(40, 32, 2.0, 1.5).unwrap();
        let scene = Scene { view: View::whole(40, 32), ..Scene::new(geometry, border) };
        let still = scene.filter().render(&optics).unwrap();
        let image = |prepared: Prepared| prepared.render_shifted(&optics, [12.0, 0.0]).unwrap();
        let padded = image(Backend::Cpu.prepare_for_shifts(scene.target(), &optics, 1.0, 12.0).unwrap());
        let plain = image(Backend::Cpu.prepare(scene.target(), &optics, 1.0).unwrap());
        // A tenth of a pixel of blur leaves next to nothing beyond the third column outside.
        let outside = |y: usize| inner.map_or(0.0, |x: usize| still.at(x, y));
        let off = |image: &Image| {
            let columns = (0..9).flat_map(|x| (2..30).map(move |y| (x, y)));
            columns.map(|(x, y)| (image.at(x, y) - outside(y)).abs()).fold(0.0, f32::max)
        };
        println!("{border:?}: off by {:.1e}, plainly padded by {:.1e}", off(&padded), off(&plain));
        assert!(off(&padded) < 0.02 && off(&plain) > 0.1, "{border:?}");
    }
}
