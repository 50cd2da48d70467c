//! Twin of shaders/shared/store.wgsl.

use super::C;
use narrowbeam::filter::gpu::Store;

pub struct Stored {
    column: usize,
    pub kx: usize,
    pub ky: usize,
    pub z: C,
    pub opposite: C,
}

pub fn stored(store: &Store, pair: &[C], at: usize) -> Stored {
    let [width, height] = store.size.map(|n| n as usize);
    let column = at / height;
    let kx = store.begin as usize + column;
    let ky = at % height;
    let back = ((width - kx) % width) * height + (height - ky) % height;
    Stored { column, kx, ky, z: pair[kx * height + ky], opposite: pair[back] }
}

pub fn kept(store: &Store, here: &Stored, plane: u32) -> usize {
    (here.column * store.planes as usize + plane as usize) * store.size[1] as usize + here.ky
}
