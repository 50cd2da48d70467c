//! Twin of shaders/shared/two_sum.wgsl; Rust's compiler keeps to the rounding as written.

pub fn plus(sum: [f32; 2], term: f32) -> [f32; 2] {
    let high = sum[0] + term;
    let part = high - sum[0];
    let lost = (sum[0] - (high - part)) + (term - part);
    [high, sum[1] + lost]
}

pub fn join(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    let sum = plus(a, b[0]);
    [sum[0], sum[1] + b[1]]
}
