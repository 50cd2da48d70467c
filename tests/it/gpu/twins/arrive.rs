//! Twin of shaders/arrive.wgsl.

use super::C;
use super::arriving::arriving;
use super::canvas::{object_pixel, position};
use narrowbeam::filter::gpu::{Collect, Source};

fn nearest(i: u32, start: u32, length: u32, size: u32) -> u32 {
    let from_start = (i + size - start) % size;
    if from_start < length {
        return from_start;
    }
    if 2 * from_start < size + length { length - 1 } else { 0 }
}

pub fn arrive(
    collect: &Collect,
    sources: &[Source],
    weights: &[f32],
    pairs: &[Vec<C>; 2],
    arrived: &mut [Vec<C>; 2],
) {
    let canvas = &collect.canvas;
    let near = |axis: usize, i: u32| {
        let start = canvas.margin[axis] + collect.view[axis];
        nearest(i, start, collect.view_size[axis], canvas.size[axis])
    };
    for at in 0..canvas.size[0] * canvas.size[1] {
        let x = near(0, at % canvas.size[0]);
        let y = near(1, at / canvas.size[0]);
        let seen = (y * collect.view_size[0] + x) as usize;
        let at = at as usize;
        let pixel = object_pixel(canvas, position(canvas, at));
        let mut sum = arriving(collect, sources, weights, pairs, (at, seen, pixel));
        if collect.before > 0 {
            let before = [arrived[0][at].re, arrived[0][at].im, arrived[1][at].re, arrived[1][at].im];
            sum.iter_mut().zip(before).for_each(|(s, b)| *s += b);
        }
        if collect.derivatives == 1 {
            arrived[0][at] = C::new(sum[0], sum[1]);
            arrived[1][at] = C::new(sum[2], sum[3]);
        } else {
            arrived[0][at] = C::new(sum[0], 0.0);
        }
    }
}
