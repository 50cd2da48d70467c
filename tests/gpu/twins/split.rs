//! Twin of shaders/split.wgsl.

use super::{C, first_of, second_of};
use narrowbeam::filter::gpu::{NOTHING, Store};

pub fn split(split: &Store, pair: &[C], spectra: &mut [C]) {
    let [width, height] = split.size.map(|n| n as usize);
    for at in 0..split.columns as usize * height {
        let column = at / height;
        let kx = split.begin as usize + column;
        let ky = at % height;
        let z = pair[kx * height + ky];
        let opposite = pair[((width - kx) % width) * height + (height - ky) % height];
        let row = column * split.planes as usize * height + ky;
        spectra[row + split.places[0] as usize * height] = first_of(z, opposite);
        if split.places[1] != NOTHING {
            spectra[row + split.places[1] as usize * height] = second_of(z, opposite);
        }
    }
}
