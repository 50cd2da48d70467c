// What arrives at the camera, on the whole canvas, to be moved there. What lies outside the view is seen as by the
// nearest pixel of the view.

// Image and first derivative, second and third.
@group(0) @binding(5) var<storage, read_write> arrived_0: array<vec2f>;
@group(0) @binding(6) var<storage, read_write> arrived_1: array<vec2f>;

// The nearest of the `length` pixels from `start` on to pixel `i` of a row of `size`, around its ends if that is shorter.
fn nearest(i: u32, start: u32, length: u32, size: u32) -> u32 {
    let from_start = (i + size - start) % size;
    if from_start < length {
        return from_start;
    }
    return select(0u, length - 1u, 2u * from_start < size + length);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let canvas = collect.canvas;
    let at = workgroup_number(group, groups) * 64u + within;
    if at >= canvas.width * canvas.height {
        return;
    }
    let x = nearest(at % canvas.width, canvas.margin_x + collect.view_x, collect.view_width, canvas.width);
    let y = nearest(at / canvas.width, canvas.margin_y + collect.view_y, collect.view_height, canvas.height);
    let pixel = object_pixel(canvas, position(canvas, at));
    var sum = arriving(at, y * collect.view_width + x, pixel);
    if collect.before > 0u {
        sum += vec4f(arrived_0[at], arrived_1[at]);
    }
    if collect.derivatives == 1u {
        arrived_0[at] = sum.xy;
        arrived_1[at] = sum.zw;
    } else {
        arrived_0[at] = vec2f(sum.x, 0.0);
    }
}
