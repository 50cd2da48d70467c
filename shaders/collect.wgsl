// What arrives at the camera: scattered light from the canvas, weighted for the obliquity that it was computed for and
// summed over obliquities, and the direct light of the nearest segment.

struct Collect {
    canvas: Canvas,
    // The view on the object image.
    view_x: u32,
    view_y: u32,
    view_width: u32,
    view_height: u32,
    sigma_t: f32,
    // Unit of the derivatives in sigma_s and sigma_a.
    unit: f32,
    // 1 if there are derivatives; images collected before; 1 to add direct light.
    derivatives: u32,
    before: u32,
    direct: u32,
    padding_1: u32,
    padding_2: u32,
    padding_3: u32,
}

@group(0) @binding(0) var<uniform> collect: Collect;
@group(0) @binding(1) var<storage, read> sources: array<Source>;
// Of the obliquities, one view after the other; a single 1 if there is but one.
@group(0) @binding(2) var<storage, read> weights: array<f32>;
// Image and first derivative, second and third.
@group(0) @binding(3) var<storage, read> pair_0: array<vec2f>;
@group(0) @binding(4) var<storage, read> pair_1: array<vec2f>;
// Image and derivatives over the view, one after the other.
@group(0) @binding(5) var<storage, read_write> planes: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let canvas = collect.canvas;
    let at = workgroup_number(group, groups) * 64u + within;
    let pixels = collect.view_width * collect.view_height;
    if at >= pixels {
        return;
    }
    let x = collect.view_x + at % collect.view_width;
    let y = collect.view_y + at / collect.view_width;
    let on_canvas = (y + canvas.margin_y) * canvas.width + x + canvas.margin_x;
    var sum = vec4f(pair_0[on_canvas], 0.0, 0.0);
    if collect.derivatives == 1u {
        sum = vec4f(sum.xy, pair_1[on_canvas]);
    }
    sum *= weights[min(collect.before * pixels + at, arrayLength(&weights) - 1u)];
    for (var sheet = 0u; sheet < canvas.sheets && collect.direct == 1u; sheet++) {
        let object = (sheet * canvas.object_height + y) * canvas.object_width + x;
        let source = sources[object];
        if source.segment == 0u {
            sum += direct(source.light, collect.sigma_t, source.z / source.cosine, collect.unit);
        }
    }
    let count = select(1u, 4u, collect.derivatives == 1u);
    for (var c = 0u; c < count; c++) {
        let place = c * pixels + at;
        if collect.before > 0u {
            planes[place] += sum[c];
        } else {
            planes[place] = sum[c];
        }
    }
}
