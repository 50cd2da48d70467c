//! Twin of shaders/pass.wgsl.

use super::canvas::{object_pixel, position};
use super::{C, direct};
use narrowbeam::filter::gpu::{Pass, Source};

pub fn pass(pass: &Pass, sources: &[Source], opaque: &[u32], pairs: &mut [Vec<C>; 2]) {
    let canvas = &pass.canvas;
    for at in 0..(canvas.size[0] * canvas.size[1]) as usize {
        let pixel = object_pixel(canvas, position(canvas, at));
        if pixel < 0 {
            continue;
        }
        let mut sum = [0.0; 4];
        let open = opaque[pixel as usize] & pass.bit == 0;
        if open {
            sum[..2].copy_from_slice(&[pairs[0][at].re, pairs[0][at].im]);
            if pass.derivatives == 1 {
                sum[2..].copy_from_slice(&[pairs[1][at].re, pairs[1][at].im]);
            }
        }
        for layer in 0..canvas.layers {
            let source = &sources[(layer * canvas.object[0] * canvas.object[1]) as usize + pixel as usize];
            if open && source.slab == pass.slab {
                let way = (source.z - pass.z) / source.cosine;
                let light = direct(source.light, pass.sigma_t, way, pass.unit);
                sum.iter_mut().zip(light).for_each(|(s, l)| *s += l);
            }
        }
        if pass.derivatives == 1 {
            pairs[0][at] = C::new(sum[0], sum[1]);
            pairs[1][at] = C::new(sum[2], sum[3]);
        } else {
            pairs[0][at] = C::new(sum[0], 0.0);
        }
    }
}
