// Sums held in two floats, the second of which takes what the first rounds away (Knuth, two-sum).

fn plus(sum: vec2f, term: f32) -> vec2f {
    let high = sum.x + term;
    let part = high - sum.x;
    let lost = (sum.x - (high - part)) + (term - part);
    return vec2f(high, sum.y + lost);
}

fn join(a: vec2f, b: vec2f) -> vec2f {
    let sum = plus(a, b.x);
    return vec2f(sum.x, sum.y + b.y);
}
