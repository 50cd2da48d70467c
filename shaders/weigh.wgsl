// The object weighted for two slices, or the source of one slice's slope term: two real images on the canvas, as one
// complex image. Slices interpolate in depth: the weights are Lagrange polynomials on Chebyshev points.

struct Weigh {
    canvas: Canvas,
    slab: u32,
    // 1 where the coordinate along z is the number of the slice, 0 where it lies in [-1, 1].
    exact: u32,
    count_z: u32,
    count_magnification: u32,
    // The slices; the second may be NOTHING.
    first: u32,
    second: u32,
    // 1 for the source of the first slice's slope term, along x and along y.
    sloping: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> weigh: Weigh;
@group(0) @binding(1) var<storage, read> sources: array<Source>;
// The Chebyshev points along z, then those along the magnification.
@group(0) @binding(2) var<storage, read> nodes: array<f32>;
@group(0) @binding(3) var<storage, read_write> pair: array<vec2f>;

// Polynomial `i` on the `count` points from `begin` at `x` in [-1, 1], in barycentric form (Berrut and Trefethen 2004).
fn lagrange(i: u32, begin: u32, count: u32, x: f32) -> f32 {
    var mine = 0.0;
    var sum = 0.0;
    for (var j = 0u; j < count; j++) {
        let distance = x - nodes[begin + j];
        if distance == 0.0 {
            return select(0.0, 1.0, i == j);
        }
        let sign = select(1.0, -1.0, (j & 1u) == 1u);
        let end = select(1.0, 0.5, j == 0u || j == count - 1u);
        let term = sign * end / distance;
        sum += term;
        mine = select(mine, term, i == j);
    }
    return mine / sum;
}

fn weight(slice: u32, source: Source) -> f32 {
    if slice == NOTHING {
        return 0.0;
    }
    if weigh.exact == 1u {
        return select(0.0, 1.0, u32(source.along_z) == slice);
    }
    let deep = weigh.count_z;
    let along_z = lagrange(slice % deep, 0u, deep, source.along_z);
    return along_z * lagrange(slice / deep, deep, weigh.count_magnification, source.along_magnification);
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let canvas = weigh.canvas;
    let at = workgroup_number(group, groups) * 64u + within;
    if at >= canvas.width * canvas.height {
        return;
    }
    let place = position(canvas, at);
    let pixel = object_pixel(canvas, place);
    var sum = vec2f(0.0);
    for (var layer = 0u; layer < canvas.layers && pixel >= 0; layer++) {
        let source = sources[layer * canvas.object_width * canvas.object_height + u32(pixel)];
        if source.slab != weigh.slab || source.light == 0.0 {
            continue;
        }
        if weigh.sloping == 1u {
            let turned = vec2f(
                turn(place.x, i32(canvas.object_width), canvas.border),
                turn(place.y, i32(canvas.object_height), canvas.border),
            );
            let slope = turned * vec2f(source.slope_x, source.slope_y);
            sum += weight(weigh.first, source) * source.light * slope;
        } else {
            sum += source.light * vec2f(weight(weigh.first, source), weight(weigh.second, source));
        }
    }
    pair[at] = sum;
}
