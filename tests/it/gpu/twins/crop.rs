//! Twin of shaders/crop.wgsl.

use super::C;
use narrowbeam::filter::gpu::Crop;

pub fn crop(crop: &Crop, pairs: &[Vec<C>; 3], planes: &mut [f32]) {
    let [view_width, view_height] = crop.view_size.map(|n| n as usize);
    let pixels = view_width * view_height;
    for at in 0..pixels {
        let (x, y) = (at % view_width, at / view_width);
        let on_canvas = (crop.corner[1] as usize + y) * crop.width as usize + crop.corner[0] as usize + x;
        planes[at] = pairs[0][on_canvas].re;
        if crop.derivatives == 1 {
            planes[pixels + at] = pairs[0][on_canvas].im;
            planes[2 * pixels + at] = pairs[1][on_canvas].re;
            planes[3 * pixels + at] = pairs[1][on_canvas].im;
            planes[4 * pixels + at] = pairs[2][on_canvas].re;
            planes[5 * pixels + at] = pairs[2][on_canvas].im;
        }
    }
}
