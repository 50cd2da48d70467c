// Adds up what the workgroups of the stage `sums` left.

struct Total {
    groups: u32,
    products: u32,
    zero: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> total: Total;
@group(0) @binding(1) var<storage, read> partial: array<vec2f>;
@group(0) @binding(2) var<storage, read_write> whole: array<vec2f>;

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) within: u32) {
    if within >= total.products {
        return;
    }
    var sum = vec2f(0.0);
    for (var group = 0u; group < total.groups; group++) {
        sum = join(sum, partial[group * total.products + within], total.zero);
    }
    whole[within] = sum;
}
