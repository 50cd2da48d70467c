// The source of the slope term, i w·FT[(fx, fy)] / w², out of the common transform of fx and fy; stored beside the
// spectra of the slices. At the highest frequency of an axis a derivative along it has no sign and is left out.

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
    if at >= store.columns * store.height {
        return;
    }
    let here = stored(at);
    let w = vec2f(frequency(here.kx, store.width), frequency(here.ky, store.height));
    var value = vec2f(0.0);
    if here.kx + here.ky > 0u {
        let along = slope(here.kx, store.width) * first_of(here.z, here.opposite)
            + slope(here.ky, store.height) * second_of(here.z, here.opposite);
        value = vec2f(-along.y, along.x) / dot(w, w);
    }
    spectra[kept(here, store.first)] = value;
}
