//! Twin of shaders/slope_correction.wgsl.

use super::store::{kept, stored};
use super::{C, first_of, second_of};
use narrowbeam::filter::gpu::Store;

fn frequency(i: usize, n: usize) -> f32 {
    let number = if 2 * i < n { i as f32 } else { i as f32 - n as f32 };
    std::f32::consts::TAU * number / n as f32
}

fn slope(i: usize, n: usize) -> f32 {
    if 2 * i == n { 0.0 } else { frequency(i, n) }
}

pub fn slope_correction(store: &Store, pair: &[C], spectra: &mut [C]) {
    let [width, height] = store.size.map(|n| n as usize);
    for at in 0..store.columns as usize * height {
        let here = stored(store, pair, at);
        let w = [frequency(here.kx, width), frequency(here.ky, height)];
        let mut value = C::default();
        if here.kx + here.ky > 0 {
            let along = slope(here.kx, width) * first_of(here.z, here.opposite)
                + slope(here.ky, height) * second_of(here.z, here.opposite);
            value = C::new(-along.im, along.re) / (w[0] * w[0] + w[1] * w[1]);
        }
        spectra[kept(store, &here, store.places[0])] = value;
    }
}
