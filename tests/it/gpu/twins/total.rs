//! Twin of shaders/total.wgsl.

use super::two_sum::join;
use narrowbeam::filter::gpu::Total;

pub fn total(total: &Total, partial: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let products = total.products as usize;
    let of = |product: usize| {
        let groups = partial.chunks(products).take(total.groups as usize);
        groups.fold([0.0; 2], |sum, group| join(sum, group[product]))
    };
    (0..products).map(of).collect()
}
