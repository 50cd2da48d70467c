// Weighted sums over the pixels of the products of six images: the render, its derivatives in sigma_s, sigma_a and B,
// the residual at a reference exposure, and 1. Each workgroup leaves the 21 products of its pixels, in two floats each.

struct Sums {
    pixels: u32,
    // The reference exposure.
    gain: f32,
    veil: f32,
    // 1 if there are derivatives.
    derivatives: u32,
    zero: u32,
    padding_1: u32,
    padding_2: u32,
    padding_3: u32,
}

const PRODUCTS: u32 = 21u;

@group(0) @binding(0) var<uniform> sums: Sums;
// Image and derivatives, one after the other.
@group(0) @binding(1) var<storage, read> planes: array<f32>;
// The observation, and its weight.
@group(0) @binding(2) var<storage, read> observed: array<vec2f>;
@group(0) @binding(3) var<storage, read_write> partial: array<vec2f>;

var<workgroup> shared_sums: array<vec2f, 64>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    var mine: array<vec2f, 21>;
    for (var at = group.x * 64u + within; at < sums.pixels; at += groups.x * 64u) {
        let here = observed[at];
        if here.y == 0.0 {
            continue;
        }
        let image = planes[at];
        var all = array<f32, 6>(image, 0.0, 0.0, 0.0, sums.gain * image + sums.veil - here.x, 1.0);
        for (var c = 1u; c < 4u && sums.derivatives == 1u; c++) {
            all[c] = planes[c * sums.pixels + at];
        }
        var product = 0u;
        for (var i = 0u; i < 6u; i++) {
            for (var j = 0u; j <= i; j++) {
                mine[product] = plus(mine[product], here.y * all[i] * all[j], sums.zero);
                product++;
            }
        }
    }
    for (var product = 0u; product < PRODUCTS; product++) {
        workgroupBarrier();
        shared_sums[within] = mine[product];
        for (var half = 32u; half > 0u; half /= 2u) {
            workgroupBarrier();
            if within < half {
                shared_sums[within] = join(shared_sums[within], shared_sums[within + half], sums.zero);
            }
        }
        if within == 0u {
            partial[group.x * PRODUCTS + product] = shared_sums[0];
        }
    }
}
