//! Twin of shaders/weigh.wgsl.

use super::C;
use super::canvas::{object_pixel, position, turn};
use narrowbeam::filter::gpu::{NOTHING, Source, Weigh};

fn lagrange(i: u32, nodes: &[f32], x: f32) -> f32 {
    let (mut mine, mut sum) = (0.0, 0.0);
    let count = nodes.len() as u32;
    for j in 0..count {
        let distance = x - nodes[j as usize];
        if distance == 0.0 {
            return if i == j { 1.0 } else { 0.0 };
        }
        let sign = if j & 1 == 1 { -1.0 } else { 1.0 };
        let end = if j == 0 || j == count - 1 { 0.5 } else { 1.0 };
        let term = sign * end / distance;
        sum += term;
        if i == j {
            mine = term;
        }
    }
    mine / sum
}

fn weight(weigh: &Weigh, nodes: &[f32], slice: u32, source: &Source) -> f32 {
    if slice == NOTHING {
        return 0.0;
    }
    if weigh.exact == 1 {
        return if source.along[0] as u32 == slice { 1.0 } else { 0.0 };
    }
    let deep = weigh.counts[0];
    let (along_z, along_magnification) = nodes.split_at(deep as usize);
    lagrange(slice % deep, along_z, source.along[0])
        * lagrange(slice / deep, &along_magnification[..weigh.counts[1] as usize], source.along[1])
}

pub fn weigh(weigh: &Weigh, sources: &[Source], nodes: &[f32]) -> Vec<C> {
    let canvas = &weigh.canvas;
    let object = canvas.object.map(|n| n as usize);
    let at = |at: usize| {
        let place = position(canvas, at);
        let pixel = object_pixel(canvas, place);
        let mut sum = C::default();
        for layer in 0..canvas.layers as usize {
            if pixel < 0 {
                break;
            }
            let source = &sources[layer * object[0] * object[1] + pixel as usize];
            if source.slab != weigh.slab || source.light == 0.0 {
                continue;
            }
            if weigh.sloping == 1 {
                let turned = [0, 1].map(|axis| turn(place[axis], object[axis] as i32, canvas.border));
                let w = weight(weigh, nodes, weigh.slices[0], source) * source.light;
                sum += w * C::new(turned[0] * source.slope[0], turned[1] * source.slope[1]);
            } else {
                let weights = weigh.slices.map(|slice| weight(weigh, nodes, slice, source));
                sum += source.light * C::new(weights[0], weights[1]);
            }
        }
        sum
    };
    (0..(canvas.size[0] * canvas.size[1]) as usize).map(at).collect()
}
