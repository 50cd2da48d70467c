//! Twin of shaders/collect.wgsl.

use super::{C, direct};
use narrowbeam::filter::gpu::{Collect, Source};

pub fn collect(
    collect: &Collect,
    sources: &[Source],
    weights: &[f32],
    pairs: &[Vec<C>; 2],
    planes: &mut [f32],
) {
    let canvas = &collect.canvas;
    let [view_width, view_height] = collect.view_size;
    let pixels = (view_width * view_height) as usize;
    for at in 0..pixels as u32 {
        let x = collect.view[0] + at % view_width;
        let y = collect.view[1] + at / view_width;
        let on_canvas = ((y + canvas.margin[1]) * canvas.size[0] + x + canvas.margin[0]) as usize;
        let mut sum = [pairs[0][on_canvas].re, pairs[0][on_canvas].im, 0.0, 0.0];
        if collect.derivatives == 1 {
            sum[2..].copy_from_slice(&[pairs[1][on_canvas].re, pairs[1][on_canvas].im]);
        }
        let place = collect.before as usize * pixels + at as usize;
        let weight = weights[place.min(weights.len() - 1)];
        sum.iter_mut().for_each(|v| *v *= weight);
        for sheet in 0..canvas.sheets {
            let source = &sources[((sheet * canvas.object[1] + y) * canvas.object[0] + x) as usize];
            if collect.direct == 1 && source.segment == 0 {
                let light = direct(source.light, collect.sigma_t, source.z / source.cosine, collect.unit);
                sum.iter_mut().zip(light).for_each(|(s, l)| *s += l);
            }
        }
        let count = if collect.derivatives == 1 { 4 } else { 1 };
        for c in 0..count {
            let plane = &mut planes[c * pixels + at as usize];
            *plane = if collect.before > 0 { *plane + sum[c] } else { sum[c] };
        }
    }
}
