//! Twin of shaders/bend.wgsl.

use super::{C, first_of, second_of};
use narrowbeam::filter::gpu::Store;

fn frequency(i: usize, n: usize) -> f32 {
    let number = if 2 * i < n { i as f32 } else { i as f32 - n as f32 };
    std::f32::consts::TAU * number / n as f32
}

fn slope(i: usize, n: usize) -> f32 {
    if 2 * i == n { 0.0 } else { frequency(i, n) }
}

pub fn bend(bend: &Store, pair: &[C], spectra: &mut [C]) {
    let [width, height] = bend.size.map(|n| n as usize);
    for at in 0..bend.columns as usize * height {
        let column = at / height;
        let kx = bend.begin as usize + column;
        let ky = at % height;
        let z = pair[kx * height + ky];
        let opposite = pair[((width - kx) % width) * height + (height - ky) % height];
        let w = [frequency(kx, width), frequency(ky, height)];
        let mut value = C::default();
        if kx + ky > 0 {
            let along = slope(kx, width) * first_of(z, opposite) + slope(ky, height) * second_of(z, opposite);
            value = C::new(-along.im, along.re) / (w[0] * w[0] + w[1] * w[1]);
        }
        spectra[(column * bend.planes as usize + bend.places[0] as usize) * height + ky] = value;
    }
}
