//! Twin of shaders/sums.wgsl.

use super::two_sum::{join, plus};
use narrowbeam::filter::gpu::{Sums, products};

const WORKGROUP: usize = 64;

/// The sums of each of `groups` workgroups, for `images` images.
pub fn sums(
    sums: &Sums,
    images: usize,
    planes: &[f32],
    observed: &[[f32; 2]],
    groups: usize,
) -> Vec<[f32; 2]> {
    let pixels = sums.pixels as usize;
    let rendered = images - 2;
    let mut partial = Vec::new();
    for group in 0..groups {
        let mut shared = vec![vec![[0.0; 2]; products(images)]; WORKGROUP];
        for (within, mine) in shared.iter_mut().enumerate() {
            for at in (group * WORKGROUP + within..pixels).step_by(groups * WORKGROUP) {
                let here = observed[at];
                if here[1] == 0.0 {
                    continue;
                }
                let image = planes[at];
                let mut all = vec![0.0; images];
                all[0] = image;
                all[rendered] = sums.gain * image + sums.veil - here[0];
                all[rendered + 1] = 1.0;
                if sums.derivatives == 1 {
                    for c in 1..rendered {
                        all[c] = planes[c * pixels + at];
                    }
                }
                let mut product = 0;
                for i in 0..images {
                    for j in 0..=i {
                        mine[product] = plus(mine[product], here[1] * all[i] * all[j]);
                        product += 1;
                    }
                }
            }
        }
        for half in [32, 16, 8, 4, 2, 1] {
            for within in 0..half {
                let other = shared[within + half].clone();
                shared[within].iter_mut().zip(other).for_each(|(mine, other)| *mine = join(*mine, other));
            }
        }
        partial.extend(&shared[0]);
    }
    partial
}
