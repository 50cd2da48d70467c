// The part of the canvas that the view shows.

// Mirrors `Crop` of src/filter/gpu/layout.rs.
struct Crop {
    // Of the canvas.
    width: u32,
    // Where the view begins on it.
    left: u32,
    top: u32,
    view_width: u32,
    view_height: u32,
    // 1 if there are derivatives.
    derivatives: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> crop: Crop;
// Image and first derivative, second and third; the derivatives in the shift.
@group(0) @binding(1) var<storage, read> pair_0: array<vec2f>;
@group(0) @binding(2) var<storage, read> pair_1: array<vec2f>;
@group(0) @binding(3) var<storage, read> motion: array<vec2f>;
// Over the view, one after the other.
@group(0) @binding(4) var<storage, read_write> planes: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let at = workgroup_number(group, groups) * 64u + within;
    let pixels = crop.view_width * crop.view_height;
    if at >= pixels {
        return;
    }
    let on_canvas = (crop.top + at / crop.view_width) * crop.width + crop.left + at % crop.view_width;
    planes[at] = pair_0[on_canvas].x;
    if crop.derivatives == 1u {
        planes[pixels + at] = pair_0[on_canvas].y;
        planes[2u * pixels + at] = pair_1[on_canvas].x;
        planes[3u * pixels + at] = pair_1[on_canvas].y;
        planes[4u * pixels + at] = motion[on_canvas].x;
        planes[5u * pixels + at] = motion[on_canvas].y;
    }
}
