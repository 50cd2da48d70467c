// Light scattered on its way to an occluder, or to the camera: the slices' spectra times their transfer functions, and what
// is carried from farther occluders, with the derivatives in sigma_s, sigma_a and B. See src/filter/transfer.rs for the
// equations. A vec4f holds a factor and its three derivatives, a mat4x2f an amplitude and its three.

struct Gather {
    // Of the canvas; spectra are stored column by column.
    width: u32,
    height: u32,
    // The columns of this part: their first, and how many.
    begin: u32,
    columns: u32,
    slices: u32,
    // 1 if there is a slope term, light from farther occluders, an occluder to pass, derivatives to be had.
    sloping: u32,
    carried: u32,
    occluded: u32,
    derivatives: u32,
    // The divisor's scale: where its table begins, and entries per rad/px.
    scale: u32,
    scale_per_w: f32,
    padding: u32,
}

// Mirrors `Record` of src/filter/gpu/tables.rs.
struct Record {
    // Where the radial table begins, and its entries per rad/px; likewise that of the slope term.
    baseband: u32,
    per_w: f32,
    slope_correction: u32,
    slope_correction_per_w: f32,
    // Where the 8 by 8 aliases begin.
    aliases: u32,
    padding_1: u32,
    padding_2: u32,
    padding_3: u32,
    // Share of the occluder's direct light that is this slice's; direct light in units of the scale.
    direct: vec4f,
    unscattered: vec4f,
}

const NODES: u32 = 8u;
// Slices whose aliases along this column are held at a time.
const TILE: u32 = 16u;

@group(0) @binding(0) var<uniform> gather: Gather;
// Of the slices, then of the light from farther occluders, then of the divisor.
@group(0) @binding(1) var<storage, read> records: array<Record>;
@group(0) @binding(2) var<storage, read> tables: array<vec4f>;
// For each frequency across, then down: (w, what both pixels leave, -, -) and 8 basis values.
@group(0) @binding(3) var<storage, read> axes: array<vec4f>;
@group(0) @binding(4) var<storage, read> spectra: array<vec2f>;
// Image and first derivative, second and third, as one complex transform each; first what is carried, then the result.
@group(0) @binding(5) var<storage, read_write> pair_0: array<vec2f>;
@group(0) @binding(6) var<storage, read_write> pair_1: array<vec2f>;

var<workgroup> lines: array<array<vec4f, 8>, 16>;

fn product(a: vec4f, b: vec4f) -> vec4f {
    return vec4f(a.x * b.x, a.yzw * b.x + a.x * b.yzw);
}

fn times(wave: mat4x2f, factor: vec4f) -> mat4x2f {
    let value = wave[0];
    return mat4x2f(
        value * factor.x,
        wave[1] * factor.x + value * factor.y,
        wave[2] * factor.x + value * factor.z,
        wave[3] * factor.x + value * factor.w,
    );
}

fn over(wave: mat4x2f, divisor: vec4f) -> mat4x2f {
    let inverse = 1.0 / divisor.x;
    let value = wave[0] * inverse;
    return mat4x2f(
        value,
        (wave[1] - value * divisor.y) * inverse,
        (wave[2] - value * divisor.z) * inverse,
        (wave[3] - value * divisor.w) * inverse,
    );
}

fn lit(light: vec2f, factor: vec4f) -> mat4x2f {
    return mat4x2f(light * factor.x, light * factor.y, light * factor.z, light * factor.w);
}

// The table at |w| by the cubic through four neighbours; its first entry lies one step before 0.
fn radial(begin: u32, per_w: f32, w: f32) -> vec4f {
    let place = w * per_w;
    let i = u32(place);
    let t = place - f32(i);
    let first = begin + i;
    return tables[first] * (-t * (t - 1.0) * (t - 2.0) / 6.0)
        + tables[first + 1u] * ((t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0)
        + tables[first + 2u] * (-(t + 1.0) * t * (t - 2.0) / 2.0)
        + tables[first + 3u] * ((t + 1.0) * t * (t - 1.0) / 6.0);
}

// Basis value `node` of the frequency whose entry in `axes` is `entry`.
fn basis(entry: u32, node: u32) -> f32 {
    return axes[3u * entry + 1u + node / 4u][node % 4u];
}

fn aliases(tile: u32, low: vec4f, high: vec4f) -> vec4f {
    return lines[tile][0] * low.x + lines[tile][1] * low.y + lines[tile][2] * low.z + lines[tile][3] * low.w
        + lines[tile][4] * high.x + lines[tile][5] * high.y + lines[tile][6] * high.z + lines[tile][7] * high.w;
}

fn carried(here: u32, opposite: u32) -> mat4x2f {
    let first = pair_0[here];
    let first_opposite = pair_0[opposite];
    var wave = mat4x2f(first_of(first, first_opposite), vec2f(0.0), vec2f(0.0), vec2f(0.0));
    if gather.derivatives == 1u {
        let second = pair_1[here];
        let second_opposite = pair_1[opposite];
        wave[1] = second_of(first, first_opposite);
        wave[2] = first_of(second, second_opposite);
        wave[3] = second_of(second, second_opposite);
    }
    return wave;
}

fn store(sum: mat4x2f, here: u32, opposite: u32) {
    var first = vec2f(0.0);
    if gather.derivatives == 1u {
        first = sum[1];
        pair_1[here] = together(sum[2], sum[3]);
        if opposite != here {
            pair_1[opposite] = together(conjugate(sum[2]), conjugate(sum[3]));
        }
    }
    pair_0[here] = together(sum[0], first);
    if opposite != here {
        pair_0[opposite] = together(conjugate(sum[0]), conjugate(first));
    }
}

@compute @workgroup_size(64)
fn main(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) within: u32,
) {
    // A workgroup takes 64 of a column's frequencies ky ≥ 0, each with its mirror image -ky.
    let blocks = (gather.height / 2u + 64u) / 64u;
    let number = workgroup_number(group, groups);
    let column = min(number / blocks, gather.columns - 1u);
    let kx = gather.begin + column;
    let ky = (number % blocks) * 64u + within;
    let counts = number / blocks < gather.columns && ky <= gather.height / 2u;
    let half = gather.width / 2u + 1u;
    let across = axes[3u * kx];
    let entry = half + min(ky, gather.height / 2u);
    let down = axes[3u * entry];
    let low = axes[3u * entry + 1u];
    let high = axes[3u * entry + 2u];
    let w = length(vec2f(across.x, down.x));
    let weight = across.y * down.y;
    var scale = vec4f(1.0, 0.0, 0.0, 0.0);
    if gather.occluded == 1u {
        scale = radial(gather.scale, gather.scale_per_w, w);
    }

    let mirrored_y = select(ky, gather.height - ky, ky > 0u && 2u * ky < gather.height);
    let opposite_x = (gather.width - kx) % gather.width;
    let here = vec2u(kx * gather.height + ky, kx * gather.height + mirrored_y);
    let opposite = opposite_x * gather.height
        + vec2u((gather.height - ky) % gather.height, (gather.height - mirrored_y) % gather.height);

    var sum_0 = mat4x2f();
    var sum_1 = mat4x2f();
    var direct_0 = mat4x2f();
    var direct_1 = mat4x2f();
    let planes = gather.slices * (1u + gather.sloping);
    let count = gather.slices + gather.carried + gather.occluded;
    for (var begin = 0u; begin < count; begin += TILE) {
        workgroupBarrier();
        for (var i = within; i < TILE * NODES; i += 64u) {
            let record = begin + i / NODES;
            if record < count {
                let first = records[record].aliases;
                var line = vec4f(0.0);
                for (var node = 0u; node < NODES; node++) {
                    line += basis(kx, node) * tables[first + node * NODES + i % NODES];
                }
                lines[i / NODES][i % NODES] = line;
            }
        }
        workgroupBarrier();
        for (var tile = 0u; tile < TILE && begin + tile < count && counts; tile++) {
            let number = begin + tile;
            let record = records[number];
            let scattered = weight * radial(record.baseband, record.per_w, w)
                + product(aliases(tile, low, high), scale);
            if number < gather.slices {
                let first = (column * planes + number) * gather.height;
                let light = vec4f(spectra[first + ky], spectra[first + mirrored_y]);
                sum_0 += lit(light.xy, scattered);
                sum_1 += lit(light.zw, scattered);
                if gather.sloping == 1u {
                    let factor = weight * radial(record.slope_correction, record.slope_correction_per_w, w);
                    let source = first + gather.slices * gather.height;
                    sum_0 += lit(spectra[source + ky], factor);
                    sum_1 += lit(spectra[source + mirrored_y], factor);
                }
                if gather.occluded == 1u {
                    direct_0 += lit(light.xy, record.direct);
                    direct_1 += lit(light.zw, record.direct);
                }
                continue;
            }
            let whole = scattered + product(record.unscattered, scale);
            if gather.carried == 1u && number == gather.slices {
                let wave_0 = carried(here.x, opposite.x);
                let wave_1 = carried(here.y, opposite.y);
                sum_0 += times(wave_0, whole);
                sum_1 += times(wave_1, whole);
                continue;
            }
            // At least sinc² sinc² ≥ .16 but where the light counts as nothing.
            let divisor = vec4f(max(whole.x, 0.1), whole.yzw);
            sum_0 = over(sum_0 - times(direct_0, scattered), divisor);
            sum_1 = over(sum_1 - times(direct_1, scattered), divisor);
        }
    }
    if counts {
        store(sum_0, here.x, opposite.x);
        if mirrored_y != ky {
            store(sum_1, here.y, opposite.y);
        }
    }
}
