// Rows of several images sampled at half the rate by a half-band filter, and written as columns.

struct Halve {
    // Length of a row, rows, length of the result, of which `margin` numbers lie before the row.
    n: u32,
    rows: u32,
    result: u32,
    margin: u32,
    planes: u32,
    // 1 if image k is the first times the kth power of the second, 0 if it is the kth.
    powers: u32,
    padding: vec2u,
}

@group(0) @binding(0) var<uniform> p: Halve;
@group(0) @binding(1) var<storage, read> input: array<f32>;
@group(0) @binding(2) var<storage, read> half_band: array<f32, 16>;
@group(0) @binding(3) var<storage, read_write> output: array<f32>;

fn value(plane: u32, at: u32) -> f32 {
    let size = p.n * p.rows;
    if p.powers == 0u {
        return input[plane * size + at];
    }
    var product = input[at];
    for (var power = 0u; power < plane; power++) {
        product *= input[size + at];
    }
    return product;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let number = (group.y * groups.x + group.x) * 64u + within;
    let all = p.rows * p.result;
    if number >= all * p.planes {
        return;
    }
    let plane = number / all;
    let row = (number % all) / p.result;
    let i = number % p.result;
    let first = 2 * (i32(i) - i32(p.margin)) - 7;
    var sum = 0.0;
    for (var k = 0; k < 16; k++) {
        let x = first + k;
        if x >= 0 && x < i32(p.n) {
            sum += half_band[k] * value(plane, row * p.n + u32(x));
        }
    }
    output[plane * all + i * p.rows + row] = sum;
}
