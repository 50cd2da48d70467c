// The source of the slope term, i w·FT[(fx, fy)] / w², out of the common transform of fx and fy; stored beside the
// spectra of the slices. At the highest frequency of an axis a derivative along it has no sign and is left out.

struct Bend {
    // Of the canvas; the transform is stored column by column.
    width: u32,
    height: u32,
    // The columns to be stored: their first, and how many.
    begin: u32,
    columns: u32,
    // Spectra stored for each column, and where this one belongs among them.
    planes: u32,
    plane: u32,
    padding: vec2u,
}

@group(0) @binding(0) var<uniform> bend: Bend;
@group(0) @binding(1) var<storage, read> pair: array<vec2f>;
@group(0) @binding(2) var<storage, read_write> spectra: array<vec2f>;

const TURN: f32 = 6.28318530717959;

// Frequency i of n, rad/px.
fn frequency(i: u32, n: u32) -> f32 {
    let number = select(f32(i) - f32(n), f32(i), 2u * i < n);
    return TURN * number / f32(n);
}

fn slope(i: u32, n: u32) -> f32 {
    return select(frequency(i, n), 0.0, 2u * i == n);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let at = workgroup_number(group, groups) * 64u + within;
    if at >= bend.columns * bend.height {
        return;
    }
    let column = at / bend.height;
    let kx = bend.begin + column;
    let ky = at % bend.height;
    let z = pair[kx * bend.height + ky];
    let opposite = pair[((bend.width - kx) % bend.width) * bend.height + (bend.height - ky) % bend.height];
    let w = vec2f(frequency(kx, bend.width), frequency(ky, bend.height));
    var value = vec2f(0.0);
    if kx + ky > 0u {
        let along = slope(kx, bend.width) * first_of(z, opposite) + slope(ky, bend.height) * second_of(z, opposite);
        value = vec2f(-along.y, along.x) / dot(w, w);
    }
    spectra[(column * bend.planes + bend.plane) * bend.height + ky] = value;
}
