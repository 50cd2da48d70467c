// The padded image, and what sends light on it. Mirrors `Canvas` and `Source` of src/filter/gpu/layout.rs.

struct Canvas {
    width: u32,
    height: u32,
    object_width: u32,
    object_height: u32,
    // Where the object image begins.
    margin_x: u32,
    margin_y: u32,
    // 0 zero, 1 clamp, 2 mirror.
    border: u32,
    // Sources for each object pixel: the object and its further layers.
    layers: u32,
}

struct Source {
    light: f32,
    // Where it lies among the slices, along z and along the magnification.
    along_z: f32,
    along_magnification: f32,
    // Path length along the camera's axis, and the cosine of the ray off it.
    z: f32,
    cosine: f32,
    // Of its surface, length per pixel.
    slope_x: f32,
    slope_y: f32,
    // Occluders that its light must pass; NOTHING if there is no source.
    slab: u32,
}

const NOTHING: u32 = 0xffffffffu;

// Index of the pixel of a row of `n` that stands for `position`, -1 for none.
fn shown(position: i32, n: i32, border: u32) -> i32 {
    if position >= 0 && position < n {
        return position;
    }
    if border == 0u {
        return -1;
    }
    if border == 1u {
        return clamp(position, 0, n - 1);
    }
    let period = 2 * n;
    let j = ((position % period) + period) % period;
    return select(period - 1 - j, j, j < n);
}

// Factor of a slope along the row at `position`.
fn turn(position: i32, n: i32, border: u32) -> f32 {
    if position >= 0 && position < n {
        return 1.0;
    }
    if border != 2u {
        return 0.0;
    }
    let period = 2 * n;
    let j = ((position % period) + period) % period;
    return select(-1.0, 1.0, j < n);
}

// Position on the object image of pixel `at` of the canvas.
fn position(canvas: Canvas, at: u32) -> vec2i {
    return vec2i(vec2u(at % canvas.width, at / canvas.width))
        - vec2i(vec2u(canvas.margin_x, canvas.margin_y));
}

// Index of the object pixel at a position, -1 for none.
fn object_pixel(canvas: Canvas, at: vec2i) -> i32 {
    let size = vec2i(vec2u(canvas.object_width, canvas.object_height));
    let x = shown(at.x, size.x, canvas.border);
    let y = shown(at.y, size.y, canvas.border);
    return select(y * size.x + x, -1, x < 0 || y < 0);
}
