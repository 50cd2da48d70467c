// What arrives at the camera: scattered light, weighted for the obliquity that it was computed for and to be summed over
// obliquities, and the direct light of the nearest slab. Mirrors `Collect` of src/filter/gpu/layout.rs.

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

// At pixel `on_canvas`, as seen by pixel `seen` of the view; `pixel` of the object image is what it shows, -1 for none.
fn arriving(on_canvas: u32, seen: u32, pixel: i32) -> vec4f {
    let canvas = collect.canvas;
    var sum = vec4f(pair_0[on_canvas], 0.0, 0.0);
    if collect.derivatives == 1u {
        sum = vec4f(sum.xy, pair_1[on_canvas]);
    }
    let pixels = collect.view_width * collect.view_height;
    sum *= weights[min(collect.before * pixels + seen, arrayLength(&weights) - 1u)];
    for (var layer = 0u; layer < canvas.layers && collect.direct == 1u && pixel >= 0; layer++) {
        let source = sources[layer * canvas.object_width * canvas.object_height + u32(pixel)];
        if source.slab == 0u {
            sum += direct(source.light, collect.sigma_t, source.z / source.cosine, collect.unit);
        }
    }
    return sum;
}
