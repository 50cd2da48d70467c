//! Twin of shaders/collect.wgsl.

use super::C;
use super::arriving::arriving;
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
        let pixel = (y * canvas.object[0] + x) as i32;
        let sum = arriving(collect, sources, weights, pairs, (on_canvas, at as usize, pixel));
        let count = if collect.derivatives == 1 { 4 } else { 1 };
        for c in 0..count {
            let plane = &mut planes[c * pixels + at as usize];
            *plane = if collect.before > 0 { *plane + sum[c] } else { sum[c] };
        }
    }
}
