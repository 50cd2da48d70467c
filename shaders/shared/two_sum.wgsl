// Sums held in two floats, the second of which takes what the first rounds away (Knuth, two-sum).
//
// In exact arithmetic what is rounded away is 0, and some compilers reckon so. `zero` is 0 at run time, which they do not
// know.

fn rounded(value: f32, zero: u32) -> f32 {
    return bitcast<f32>(bitcast<u32>(value) ^ zero);
}

fn plus(sum: vec2f, term: f32, zero: u32) -> vec2f {
    let high = rounded(sum.x + term, zero);
    let part = rounded(high - sum.x, zero);
    let lost = (sum.x - rounded(high - part, zero)) + (term - part);
    return vec2f(high, sum.y + lost);
}

fn join(a: vec2f, b: vec2f, zero: u32) -> vec2f {
    let sum = plus(a, b.x, zero);
    return vec2f(sum.x, sum.y + b.y);
}
