// The spectra of two real images out of their common transform, stored beside those of the other slices.

struct Split {
    // Of the canvas; the transform is stored column by column.
    width: u32,
    height: u32,
    // The columns to be stored: their first, and how many.
    begin: u32,
    columns: u32,
    // Spectra stored for each column, and where these two belong among them; the second may be NOTHING.
    planes: u32,
    first: u32,
    second: u32,
    padding: u32,
}

const NOTHING: u32 = 0xffffffffu;

@group(0) @binding(0) var<uniform> split: Split;
@group(0) @binding(1) var<storage, read> pair: array<vec2f>;
@group(0) @binding(2) var<storage, read_write> spectra: array<vec2f>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let at = workgroup_number(group, groups) * 64u + within;
    if at >= split.columns * split.height {
        return;
    }
    let column = at / split.height;
    let kx = split.begin + column;
    let ky = at % split.height;
    let z = pair[kx * split.height + ky];
    let opposite = pair[((split.width - kx) % split.width) * split.height + (split.height - ky) % split.height];
    let row = column * split.planes * split.height + ky;
    spectra[row + split.first * split.height] = first_of(z, opposite);
    if split.second != NOTHING {
        spectra[row + split.second * split.height] = second_of(z, opposite);
    }
}
