// Takes the light at an occluder through it: the direct light of what lies behind is added, and what meets the occluder is
// lost.

struct Pass {
    canvas: Canvas,
    slab: u32,
    // The occluder's bit in `opaque`.
    bit: u32,
    // Path length along the camera's axis at the occluder.
    z: f32,
    sigma_t: f32,
    // Unit of the derivatives in sigma_s and sigma_a.
    unit: f32,
    // 1 if there are derivatives.
    derivatives: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> pass_by: Pass;
@group(0) @binding(1) var<storage, read> sources: array<Source>;
// For each object pixel a bit for each occluder.
@group(0) @binding(2) var<storage, read> opaque: array<u32>;
// Image and first derivative, second and third.
@group(0) @binding(3) var<storage, read_write> pair_0: array<vec2f>;
@group(0) @binding(4) var<storage, read_write> pair_1: array<vec2f>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let canvas = pass_by.canvas;
    let at = workgroup_number(group, groups) * 64u + within;
    if at >= canvas.width * canvas.height {
        return;
    }
    let pixel = object_pixel(canvas, position(canvas, at));
    if pixel < 0 {
        return;
    }
    var sum = vec4f(0.0);
    let open = (opaque[pixel] & pass_by.bit) == 0u;
    if open {
        sum = vec4f(pair_0[at], 0.0, 0.0);
        if pass_by.derivatives == 1u {
            sum = vec4f(sum.xy, pair_1[at]);
        }
    }
    for (var layer = 0u; layer < canvas.layers && open; layer++) {
        let source = sources[layer * canvas.object_width * canvas.object_height + u32(pixel)];
        if source.slab == pass_by.slab {
            let way = (source.z - pass_by.z) / source.cosine;
            sum += direct(source.light, pass_by.sigma_t, way, pass_by.unit);
        }
    }
    if pass_by.derivatives == 1u {
        pair_0[at] = sum.xy;
        pair_1[at] = sum.zw;
    } else {
        pair_0[at] = vec2f(sum.x, 0.0);
    }
}
