// Number of a workgroup: along x first, then along y.
fn workgroup_number(id: vec3u, groups: vec3u) -> u32 {
    return id.y * groups.x + id.x;
}
