//! Twin of shaders/split.wgsl.

use super::store::{kept, stored};
use super::{C, first_of, second_of};
use narrowbeam::filter::gpu::{NOTHING, Store};

pub fn split(store: &Store, pair: &[C], spectra: &mut [C]) {
    for at in 0..(store.columns * store.size[1]) as usize {
        let here = stored(store, pair, at);
        spectra[kept(store, &here, store.places[0])] = first_of(here.z, here.opposite);
        if store.places[1] != NOTHING {
            spectra[kept(store, &here, store.places[1])] = second_of(here.z, here.opposite);
        }
    }
}
