// Spectra of images that move by a shift d: times exp(-i w d), and for the derivatives of the first image in the shift by
// the derivatives of that factor. Axes have their own factors, see src/filter/shift.rs.

// Mirrors `ShiftBy` of src/filter/gpu/layout.rs.
struct Shift {
    // Of the canvas; spectra are stored column by column.
    width: u32,
    height: u32,
    // 1 if there are derivatives.
    derivatives: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> shift: Shift;
// For each frequency across, then down: the factor and its derivative.
@group(0) @binding(1) var<storage, read> factors: array<vec4f>;
// Image and first derivative, second and third, as one complex transform each: as they are, and moved.
@group(0) @binding(2) var<storage, read> still_0: array<vec2f>;
@group(0) @binding(3) var<storage, read> still_1: array<vec2f>;
@group(0) @binding(4) var<storage, read_write> moved_0: array<vec2f>;
@group(0) @binding(5) var<storage, read_write> moved_1: array<vec2f>;
// The derivatives in the shift along x and y.
@group(0) @binding(6) var<storage, read_write> motion: array<vec2f>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let at = workgroup_number(group, groups) * 64u + within;
    if at >= shift.width * shift.height {
        return;
    }
    let kx = at / shift.height;
    let ky = at % shift.height;
    let across = factors[kx];
    let down = factors[shift.width + ky];
    let factor = multiply(across.xy, down.xy);
    moved_0[at] = multiply(still_0[at], factor);
    if shift.derivatives == 1u {
        moved_1[at] = multiply(still_1[at], factor);
        let back = ((shift.width - kx) % shift.width) * shift.height + (shift.height - ky) % shift.height;
        let image = first_of(still_0[at], still_0[back]);
        motion[at] = together(
            multiply(image, multiply(across.zw, down.xy)),
            multiply(image, multiply(across.xy, down.zw)),
        );
    }
}
