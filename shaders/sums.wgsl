// Weighted sums over the pixels of the products of IMAGES images: the render, its derivatives in sigma_s, sigma_a and B,
// and, if it moves, in the shift along x and y; the residual at a reference exposure, and 1. Each workgroup leaves the
// products of its pixels, each pair once, in two floats each.

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

// The render and its derivatives.
const PLANES: u32 = IMAGES - 2u;
const PRODUCTS: u32 = IMAGES * (IMAGES + 1u) / 2u;

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
    var mine: array<vec2f, PRODUCTS>;
    for (var at = group.x * 64u + within; at < sums.pixels; at += groups.x * 64u) {
        let here = observed[at];
        if here.y == 0.0 {
            continue;
        }
        let image = planes[at];
        var all = array<f32, IMAGES>();
        all[0] = image;
        all[PLANES] = sums.gain * image + sums.veil - here.x;
        all[PLANES + 1u] = 1.0;
        for (var c = 1u; c < PLANES && sums.derivatives == 1u; c++) {
            all[c] = planes[c * sums.pixels + at];
        }
        var product = 0u;
        for (var i = 0u; i < IMAGES; i++) {
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
