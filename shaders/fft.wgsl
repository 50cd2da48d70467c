// Fourier transforms of lines of up to 1024 numbers in workgroup memory: Stockham's algorithm, which sorts as it goes.
// Longer lines take two such passes with twiddle factors between them (Bailey 1990).

struct Fft {
    // Length of a line, lines, and lines that a workgroup takes.
    n: u32,
    lines: u32,
    per_group: u32,
    // Line l is number l % inner of group l / inner.
    inner: u32,
    // Distances between numbers, lines and groups of lines, read and written.
    in_element: u32,
    in_inner: u32,
    in_outer: u32,
    out_element: u32,
    out_inner: u32,
    out_outer: u32,
    // 1 to multiply number k of line l by root[n + k (l % inner)] at the end.
    twiddle: u32,
    // 1 for exp(+i…).
    inverse: u32,
    scale: f32,
    factors: u32,
    padding: vec2u,
    factor: array<vec4u, 3>,
}

const CAPACITY: u32 = 1024u;
const SIZE: u32 = 128u;

@group(0) @binding(0) var<uniform> fft: Fft;
// exp(-2 pi i j / n) for j < n, then the twiddle factors.
@group(0) @binding(1) var<storage, read> root: array<vec2f>;
@group(0) @binding(2) var<storage, read> input: array<vec2f>;
@group(0) @binding(3) var<storage, read_write> output: array<vec2f>;

var<workgroup> line: array<vec2f, 2048>;

// A quarter turn clockwise.
fn turned(a: vec2f) -> vec2f {
    return vec2f(a.y, -a.x);
}

// Which line of the group, and which number of it, is the `t`th to be moved: neighbours in memory follow each other.
fn moved(t: u32, element: u32, inner: u32) -> vec2u {
    if element < inner {
        return vec2u(t / fft.n, t % fft.n);
    }
    return vec2u(t % fft.per_group, t / fft.per_group);
}

// One step of any other factor, term by term.
fn advance_by_terms(radix: u32, done: u32, source: u32, result: u32, lines: u32, within: u32) {
    let stride = fft.n / radix;
    for (var t = within; t < lines * fft.n; t += SIZE) {
        let start = (t / fft.n) * fft.n;
        let j = (t % fft.n) % stride;
        let q = (t % fft.n) / stride;
        let k = j % done;
        let turn = k * (stride / done) + q * stride;
        var sum = vec2f(0.0);
        for (var i = 0u; i < radix; i++) {
            sum += multiply(line[source + start + j + i * stride], root[(i * turn) % fft.n]);
        }
        line[result + start + (j / done) * done * radix + k + q * done] = sum;
    }
}

// One step over all lines, from the half of `line` that begins at `source` to the one at `result`.
fn advance(radix: u32, done: u32, source: u32, result: u32, lines: u32, within: u32) {
    let stride = fft.n / radix;
    let turns = stride / done;
    for (var b = within; b < lines * stride; b += SIZE) {
        let start = (b / stride) * fft.n;
        let j = b % stride;
        let k = j % done;
        let read = source + start + j;
        let write = result + start + (j / done) * done * radix + k;
        let a0 = line[read];
        let a1 = multiply(line[read + stride], root[k * turns]);
        switch radix {
            case 2u: {
                line[write] = a0 + a1;
                line[write + done] = a0 - a1;
            }
            case 3u: {
                let a2 = multiply(line[read + 2u * stride], root[2u * k * turns]);
                let sum = a1 + a2;
                let middle = a0 - 0.5 * sum;
                let side = 0.866025403784439 * turned(a1 - a2);
                line[write] = a0 + sum;
                line[write + done] = middle + side;
                line[write + 2u * done] = middle - side;
            }
            case 4u: {
                let a2 = multiply(line[read + 2u * stride], root[2u * k * turns]);
                let a3 = multiply(line[read + 3u * stride], root[3u * k * turns]);
                let even = a0 + a2;
                let odd = a1 + a3;
                let apart = a0 - a2;
                let side = turned(a1 - a3);
                line[write] = even + odd;
                line[write + done] = apart + side;
                line[write + 2u * done] = even - odd;
                line[write + 3u * done] = apart - side;
            }
            default: {
                // 5
                let a2 = multiply(line[read + 2u * stride], root[2u * k * turns]);
                let a3 = multiply(line[read + 3u * stride], root[3u * k * turns]);
                let a4 = multiply(line[read + 4u * stride], root[4u * k * turns]);
                let near = a1 + a4;
                let far = a2 + a3;
                let near_side = turned(a1 - a4);
                let far_side = turned(a2 - a3);
                // cos and sin of 72 and 144 degrees.
                let first = a0 + 0.309016994374947 * near - 0.809016994374947 * far;
                let second = a0 - 0.809016994374947 * near + 0.309016994374947 * far;
                let first_side = 0.951056516295154 * near_side + 0.587785252292473 * far_side;
                let second_side = 0.587785252292473 * near_side - 0.951056516295154 * far_side;
                line[write] = a0 + near + far;
                line[write + done] = first + first_side;
                line[write + 2u * done] = second + second_side;
                line[write + 3u * done] = second - second_side;
                line[write + 4u * done] = first - first_side;
            }
        }
    }
}

@compute @workgroup_size(128)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let begin = workgroup_number(group, groups) * fft.per_group;
    let lines = min(fft.per_group, max(fft.lines, begin) - begin);
    let all = fft.per_group * fft.n;
    for (var t = within; t < all; t += SIZE) {
        let place = moved(t, fft.in_element, fft.in_inner);
        if place.x < lines {
            let l = begin + place.x;
            let at = (l / fft.inner) * fft.in_outer + (l % fft.inner) * fft.in_inner + place.y * fft.in_element;
            let value = input[at];
            line[place.x * fft.n + place.y] = select(value, conjugate(value), fft.inverse == 1u);
        }
    }
    var half = 0u;
    var done = 1u;
    for (var f = 0u; f < fft.factors; f++) {
        workgroupBarrier();
        let radix = fft.factor[f / 4u][f % 4u];
        if radix <= 5u {
            advance(radix, done, half, CAPACITY - half, lines, within);
        } else {
            advance_by_terms(radix, done, half, CAPACITY - half, lines, within);
        }
        half = CAPACITY - half;
        done *= radix;
    }
    workgroupBarrier();
    for (var t = within; t < all; t += SIZE) {
        let place = moved(t, fft.out_element, fft.out_inner);
        if place.x < lines {
            let l = begin + place.x;
            var value = line[half + place.x * fft.n + place.y];
            if fft.twiddle == 1u {
                value = multiply(value, root[fft.n + place.y * (l % fft.inner)]);
            }
            value = fft.scale * select(value, conjugate(value), fft.inverse == 1u);
            let at = (l / fft.inner) * fft.out_outer + (l % fft.inner) * fft.out_inner + place.y * fft.out_element;
            output[at] = value;
        }
    }
}
