// What arrives at the camera, over the view.

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
    let sum = arriving(on_canvas, at, i32(y * canvas.object_width + x));
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
