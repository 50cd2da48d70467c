// Adds what stays in its pixel: direct light, and the scattered light that is not blurred beyond the pixel.

struct Sharp {
    pixels: u32,
    terms: u32,
    // Path length in the middle of the depths, half their range, extinction coefficient.
    middle: f32,
    half_range: f32,
    sigma_t: f32,
    padding_1: u32,
    padding_2: u32,
    padding_3: u32,
    coefficients: array<vec4f, 2>,
}

@group(0) @binding(0) var<uniform> p: Sharp;
// Radiance, then places along the depths.
@group(0) @binding(1) var<storage, read> input: array<f32>;
@group(0) @binding(2) var<storage, read_write> image: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let at = (group.y * groups.x + group.x) * 64u + within;
    if at >= p.pixels {
        return;
    }
    let place = input[p.pixels + at];
    var share = 0.0;
    for (var k = p.terms; k > 0u; k--) {
        share = share * place + p.coefficients[(k - 1u) / 4u][(k - 1u) % 4u];
    }
    image[at] += (share + exp(-p.sigma_t * (p.middle + p.half_range * place))) * input[at];
}
