// Direct light after the path length `way`, and its derivatives in sigma_s and sigma_a in units of `unit`, and in B.
fn direct(light: f32, sigma_t: f32, way: f32, unit: f32) -> vec4f {
    let arrived = exp(-sigma_t * way) * light;
    let slope = -way / unit * arrived;
    return vec4f(arrived, slope, slope, 0.0);
}
