//! Twin of shaders/shared/canvas.wgsl.

use narrowbeam::filter::gpu::CanvasLayout;

pub fn shown(position: i32, n: i32, border: u32) -> i32 {
    if position >= 0 && position < n {
        return position;
    }
    if border == 0 {
        return -1;
    }
    if border == 1 {
        return position.clamp(0, n - 1);
    }
    let period = 2 * n;
    let j = ((position % period) + period) % period;
    if j < n { j } else { period - 1 - j }
}

pub fn turn(position: i32, n: i32, border: u32) -> f32 {
    if position >= 0 && position < n {
        return 1.0;
    }
    if border != 2 {
        return 0.0;
    }
    let period = 2 * n;
    let j = ((position % period) + period) % period;
    if j < n { 1.0 } else { -1.0 }
}

pub fn position(canvas: &CanvasLayout, at: usize) -> [i32; 2] {
    let width = canvas.size[0] as usize;
    [(at % width) as i32 - canvas.margin[0] as i32, (at / width) as i32 - canvas.margin[1] as i32]
}

pub fn object_pixel(canvas: &CanvasLayout, at: [i32; 2]) -> i32 {
    let size = canvas.object.map(|n| n as i32);
    let x = shown(at[0], size[0], canvas.border);
    let y = shown(at[1], size[1], canvas.border);
    if x < 0 || y < 0 { -1 } else { y * size[0] + x }
}
