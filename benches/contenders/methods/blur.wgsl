// Rows blurred by a symmetric kernel and written as columns, so that two passes blur an image.

struct Blur {
    // Length of a row, and rows.
    n: u32,
    rows: u32,
    radius: u32,
    // Coefficients in depth of the light to be blurred; 0 if `input` is one image, to be taken as it is.
    terms: u32,
    // 1 if `input` is radiance and place along the depths; 0 if it is one image a coefficient.
    powers: u32,
    // 1 to add to what is there.
    adds: u32,
    padding: vec2u,
    coefficients: array<vec4f, 2>,
}

// Outputs along a row, rows, offsets at a time, and sources that they need.
const OUTPUTS: u32 = 32u;
const ROWS: u32 = 8u;
const OFFSETS: i32 = 97;
const SOURCES: u32 = 128u;

@group(0) @binding(0) var<uniform> p: Blur;
@group(0) @binding(1) var<storage, read> input: array<f32>;
// At offsets 0 to radius.
@group(0) @binding(2) var<storage, read> taps: array<f32>;
@group(0) @binding(3) var<storage, read_write> output: array<f32>;

// Four rows side by side, twice.
var<workgroup> line: array<vec4f, 256>;

fn light(row: u32, x: i32) -> f32 {
    if row >= p.rows || x < 0 || x >= i32(p.n) {
        return 0.0;
    }
    let at = row * p.n + u32(x);
    if p.terms == 0u {
        return input[at];
    }
    let plane = p.n * p.rows;
    var sum = 0.0;
    if p.powers == 1u {
        let place = input[plane + at];
        for (var k = p.terms; k > 0u; k--) {
            sum = sum * place + p.coefficients[(k - 1u) / 4u][(k - 1u) % 4u];
        }
        return sum * input[at];
    }
    for (var k = 0u; k < p.terms; k++) {
        sum += p.coefficients[k / 4u][k % 4u] * input[k * plane + at];
    }
    return sum;
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let across = (p.n + OUTPUTS - 1u) / OUTPUTS;
    let number = group.y * groups.x + group.x;
    let first = (number % across) * OUTPUTS;
    let row = (number / across) * ROWS;
    let x = within % OUTPUTS;
    let four = within / OUTPUTS;
    let radius = i32(p.radius);
    var sum = vec4f(0.0);
    for (var begin = -radius; begin <= radius; begin += OFFSETS) {
        let end = min(begin + OFFSETS - 1, radius);
        // What lies outside the rows is dark.
        if i32(first + OUTPUTS) - 1 + end < 0 || i32(first) + begin >= i32(p.n) {
            continue;
        }
        workgroupBarrier();
        let needed = OUTPUTS + u32(end - begin);
        for (var t = within; t < 2u * needed; t += 64u) {
            let place = i32(first) + begin + i32(t % needed);
            let r = row + (t / needed) * 4u;
            line[(t / needed) * SOURCES + t % needed] =
                vec4f(light(r, place), light(r + 1u, place), light(r + 2u, place), light(r + 3u, place));
        }
        workgroupBarrier();
        for (var d = begin; d <= end; d++) {
            sum += taps[u32(abs(d))] * line[four * SOURCES + x + u32(d - begin)];
        }
    }
    for (var i = 0u; i < 4u && first + x < p.n; i++) {
        let r = row + four * 4u + i;
        if r < p.rows {
            let at = (first + x) * p.rows + r;
            if p.adds == 1u {
                output[at] += sum[i];
            } else {
                output[at] = sum[i];
            }
        }
    }
}
