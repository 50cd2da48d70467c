//! Twin of shaders/shared/arriving.wgsl.

use super::{C, direct};
use narrowbeam::filter::gpu::{Collect, Source};

pub fn arriving(
    collect: &Collect,
    sources: &[Source],
    weights: &[f32],
    pairs: &[Vec<C>; 2],
    (on_canvas, seen, pixel): (usize, usize, i32),
) -> [f32; 4] {
    let canvas = &collect.canvas;
    let mut sum = [pairs[0][on_canvas].re, pairs[0][on_canvas].im, 0.0, 0.0];
    if collect.derivatives == 1 {
        sum[2..].copy_from_slice(&[pairs[1][on_canvas].re, pairs[1][on_canvas].im]);
    }
    let pixels = (collect.view_size[0] * collect.view_size[1]) as usize;
    let weight = weights[(collect.before as usize * pixels + seen).min(weights.len() - 1)];
    sum.iter_mut().for_each(|v| *v *= weight);
    for layer in 0..canvas.layers {
        if collect.direct == 0 || pixel < 0 {
            break;
        }
        let source = &sources[(layer * canvas.object[0] * canvas.object[1]) as usize + pixel as usize];
        if source.slab == 0 {
            let light = direct(source.light, collect.sigma_t, source.z / source.cosine, collect.unit);
            sum.iter_mut().zip(light).for_each(|(s, l)| *s += l);
        }
    }
    sum
}
