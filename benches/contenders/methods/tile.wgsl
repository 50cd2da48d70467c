// Each pixel sums the object pixels in the kernel's disc, by way of tiles in workgroup memory. The weight between two
// pixels is a polynomial in the place of the sending pixel along the depths.

struct Tile {
    width: u32,
    height: u32,
    radius: u32,
    // Squared radius of the disc.
    disc: u32,
    // Coefficients of a weight, 1 or up to 6.
    terms: u32,
    // Path length in the middle of the depths, half their range, extinction coefficient.
    middle: f32,
    half_range: f32,
    sigma_t: f32,
}

// Outputs, offsets and sources of a tile along one side.
const SIDE: u32 = 16u;
const SOURCES: u32 = 31u;

@group(0) @binding(0) var<uniform> p: Tile;
// Radiance and place along the depths, -1 to 1.
@group(0) @binding(1) var<storage, read> sources: array<vec2f>;
// Of offsets 0 to radius down and across.
@group(0) @binding(2) var<storage, read> weights: array<array<vec4f, 2>>;
@group(0) @binding(3) var<storage, read_write> image: array<f32>;

var<workgroup> tile: array<vec2f, 961>;

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    let across = (p.width + SIDE - 1u) / SIDE;
    let number = group.y * groups.x + group.x;
    let origin = vec2i(vec2u(number % across, number / across) * SIDE);
    let x = within % SIDE;
    let y = (within / SIDE) * 4u;
    let radius = i32(p.radius);
    var sum = vec4f(0.0);
    for (var down = -radius; down <= radius; down += i32(SIDE)) {
        for (var right = -radius; right <= radius; right += i32(SIDE)) {
            workgroupBarrier();
            for (var t = within; t < SOURCES * SOURCES; t += 64u) {
                let at = origin + vec2i(right, down) + vec2i(vec2u(t % SOURCES, t / SOURCES));
                var source = vec2f(0.0);
                if all(at >= vec2i(0)) && at.x < i32(p.width) && at.y < i32(p.height) {
                    source = sources[u32(at.y) * p.width + u32(at.x)];
                }
                tile[t] = source;
            }
            workgroupBarrier();
            for (var dy = down; dy <= min(down + i32(SIDE) - 1, radius); dy++) {
                let left = i32(p.disc) - dy * dy;
                let reach = select(-1, i32(sqrt(f32(left) + 0.5)), left >= 0);
                for (var dx = max(right, -reach); dx <= min(right + i32(SIDE) - 1, reach); dx++) {
                    let entry = u32(abs(dy)) * (p.radius + 1u) + u32(abs(dx));
                    let low = weights[entry][0];
                    let at = (y + u32(dy - down)) * SOURCES + x + u32(dx - right);
                    let a = tile[at];
                    let b = tile[at + SOURCES];
                    let c = tile[at + 2u * SOURCES];
                    let d = tile[at + 3u * SOURCES];
                    let place = vec4f(a.y, b.y, c.y, d.y);
                    var weight = vec4f(low.x);
                    if p.terms > 1u {
                        let high = weights[entry][1];
                        weight = high.y * place + high.x;
                        weight = weight * place + low.w;
                        weight = weight * place + low.z;
                        weight = weight * place + low.y;
                        weight = weight * place + low.x;
                    }
                    sum += weight * vec4f(a.x, b.x, c.x, d.x);
                }
            }
        }
    }
    for (var i = 0u; i < 4u; i++) {
        let at = vec2u(origin) + vec2u(x, y + i);
        if at.x < p.width && at.y < p.height {
            let source = sources[at.y * p.width + at.x];
            let direct = exp(-p.sigma_t * (p.middle + p.half_range * source.y)) * source.x;
            image[at.y * p.width + at.x] = sum[i] + direct;
        }
    }
}
