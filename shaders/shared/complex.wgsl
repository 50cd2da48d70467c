// Complex numbers as (real, imaginary).

fn conjugate(a: vec2f) -> vec2f {
    return vec2f(a.x, -a.y);
}

fn multiply(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// Two real images are transformed as one complex image, the second being its imaginary part. `z` is the transform at a
// frequency, `opposite` that at the opposite one; these are the two images' own transforms.

fn first_of(z: vec2f, opposite: vec2f) -> vec2f {
    return 0.5 * (z + conjugate(opposite));
}

fn second_of(z: vec2f, opposite: vec2f) -> vec2f {
    let twice = z - conjugate(opposite);
    return 0.5 * vec2f(twice.y, -twice.x);
}

// The transform of both, at the frequency where the two images have `a` and `b`.
fn together(a: vec2f, b: vec2f) -> vec2f {
    return vec2f(a.x - b.y, a.y + b.x);
}
