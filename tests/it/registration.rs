//! The first guess of a shift, on blurred, dimmed, veiled and noisy renders.

use crate::common::{texture, with_noise};
use narrowbeam::filter::cpu::CpuFilter;
use narrowbeam::filter::{Optics, Target, coarse_shift};
use narrowbeam::geometry::Geometry;
use narrowbeam::image::{Border, Image, View};
use narrowbeam::medium::Medium;
use narrowbeam::spread::Model;

const SMALL: [[f64; 2]; 4] = [[0.0, 0.0], [0.3, -0.2], [1.7, 0.4], [-12.3, 7.6]];
const LARGE: [[f64; 2]; 2] = [[24.4, -19.1], [-29.3, 28.8]];
const Z: f64 = 2.0;
const B: f64 = 0.004;

/// Patches of all sizes in no order, as in a photograph.
fn patches(width: usize, height: usize) -> Image {
    let mut image = Image::filled(width, height, 0.5);
    let mut state = 12345_u64;
    let mut draw = |n: usize| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as usize % n
    };
    for i in 0..2500 {
        let side = 2 + 60 / (1 + i / 20);
        let (x, y, shade) = (draw(width), draw(height), 0.05 + 0.009 * draw(100) as f32);
        for v in y..(y + side).min(height) {
            image.data[v * width + x..v * width + (x + side).min(width)].fill(shade);
        }
    }
    image
}

/// The guess for a kernel of `width_px` and `noise` as a share of the mean.
fn guess(
    object: &Image,
    (tau, width_px): (f64, f64),
    shift_px: [f64; 2],
    noise: f64,
    mask: Option<&Image>,
) -> [f64; 2] {
    let (width, height) = (object.width, object.height);
    let geometry = Geometry::planar(width, height, Z * B.sqrt() / width_px, Z).unwrap();
    let view = View::centred((width, height), (128, 112));
    let border = Border::Mirror;
    let target = Target::plain(object, &geometry, border, view);
    let medium = Medium::gaussian(tau / Z, 0.1, B).unwrap();
    let optics = Optics { model: Model::SmallAngle, medium };
    let filter = CpuFilter::new(target, &optics, 1.0).unwrap();
    let mut seen = filter.render_shifted(&optics, shift_px).unwrap();
    seen.data.iter_mut().for_each(|v| *v = 0.6 * *v + 0.1);
    let observed = with_noise(&seen, noise * seen.mean(), 5);
    coarse_shift(&object.crop(view), &observed, mask)
}

/// How far off that guess is, px.
fn error(object: &Image, medium: (f64, f64), shift_px: [f64; 2], noise: f64, mask: Option<&Image>) -> f64 {
    let found = guess(object, medium, shift_px, noise, mask);
    (found[0] - shift_px[0]).hypot(found[1] - shift_px[1])
}

const MEDIA: [(f64, f64); 5] = [(0.3, 1.0), (0.3, 20.0), (1.5, 5.0), (4.0, 1.0), (4.0, 20.0)];

#[test]
fn shifts_are_found_through_any_medium() {
    // The texture all but repeats itself every 46.5 px, so it is asked for small shifts alone.
    let scenes = [
        ("texture", texture(200, 180), SMALL.to_vec()),
        ("patches", patches(200, 180), [&SMALL[..], &LARGE[..]].concat()),
    ];
    let mut worst: f64 = 0.0;
    for (name, object, shifts) in &scenes {
        for medium in MEDIA {
            for noise in [0.01, 0.03] {
                let off: Vec<f64> = shifts.iter().map(|d| error(object, medium, *d, noise, None)).collect();
                println!("{name}, tau and width {medium:?}, noise {noise}: {off:.3?} px");
                worst = off.into_iter().fold(worst, f64::max);
            }
        }
    }
    assert!(worst < 0.3, "{worst} px");
}

#[test]
fn the_guess_is_not_drawn_to_no_shift() {
    let object = patches(200, 180);
    for medium in MEDIA {
        let guessed = [0.3, 0.5, -0.4].map(|dx| guess(&object, medium, [dx, 0.0], 0.01, None)[0] / dx);
        println!("tau and width {medium:?}: {guessed:.3?} of the shift");
        assert!(guessed.iter().all(|share| (share - 1.0).abs() < 0.1), "{medium:?}: {guessed:?}");
    }
}

#[test]
fn masked_pixels_do_not_mislead() {
    let object = patches(200, 180);
    let mask = Image::from_fn(128, 112, |x, y| if (40..70).contains(&x) && y > 50 { 0.0 } else { 1.0 });
    for shift_px in SMALL {
        let off = error(&object, (1.5, 5.0), shift_px, 0.02, Some(&mask));
        assert!(off < 0.3, "{shift_px:?}: {off} px");
    }
}

#[test]
fn images_without_detail_have_no_shift() {
    let flat = Image::filled(40, 30, 0.7);
    assert_eq!(coarse_shift(&flat, &flat, None), [0.0; 2]);
    assert_eq!(coarse_shift(&texture(40, 30), &texture(40, 30), Some(&Image::filled(40, 30, 0.0))), [0.0; 2]);
}
