// The spectra of two real images out of their common transform, stored beside those of the other slices.

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
    spectra[kept(here, store.first)] = first_of(here.z, here.opposite);
    if store.second != NOTHING {
        spectra[kept(here, store.second)] = second_of(here.z, here.opposite);
    }
}
