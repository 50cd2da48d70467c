// Rows sampled at twice the rate by the same half-band filter, and written as columns.

struct Double {
    // Length of a row, of which `margin` numbers lie before the result, rows, length of the result.
    n: u32,
    rows: u32,
    result: u32,
    margin: u32,
}

@group(0) @binding(0) var<uniform> p: Double;
@group(0) @binding(1) var<storage, read> input: array<f32>;
@group(0) @binding(2) var<storage, read> half_band: array<f32, 16>;
@group(0) @binding(3) var<storage, read_write> output: array<f32>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let number = (group.y * groups.x + group.x) * 64u + within;
    if number >= p.rows * p.result {
        return;
    }
    let row = number / p.result;
    let x = number % p.result;
    // Sample i of the row reaches from 2 (i - margin) - 7 to 2 (i - margin) + 8.
    let shifted = i32(x) + 2 * i32(p.margin);
    let last = (shifted + 7) / 2;
    var sum = 0.0;
    for (var i = max(last - 7, 0); i <= min(last, i32(p.n) - 1); i++) {
        sum += half_band[shifted + 7 - 2 * i] * input[row * p.n + u32(i)];
    }
    output[x * p.rows + row] = 2.0 * sum;
}
