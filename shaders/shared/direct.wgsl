// Direct light and its derivatives in sigma_s, sigma_a and B, after the path length `way`.
fn direct(light: f32, sigma_t: f32, way: f32) -> vec4f {
    let arrived = exp(-sigma_t * way) * light;
    return vec4f(arrived, -way * arrived, -way * arrived, 0.0);
}
