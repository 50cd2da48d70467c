//! Twin of shaders/shift.wgsl.

use super::{C, first_of, multiply, together};
use narrowbeam::filter::gpu::ShiftBy;

/// `moved` are the moved pairs, then the derivatives in the shift.
pub fn shift(shift: &ShiftBy, factors: &[[f32; 4]], still: &[Vec<C>; 2], moved: &mut [Vec<C>; 3]) {
    let [width, height] = shift.size.map(|n| n as usize);
    let parts = |i: usize| [C::new(factors[i][0], factors[i][1]), C::new(factors[i][2], factors[i][3])];
    for at in 0..width * height {
        let kx = at / height;
        let ky = at % height;
        let across = parts(kx);
        let down = parts(width + ky);
        let factor = multiply(across[0], down[0]);
        moved[0][at] = multiply(still[0][at], factor);
        if shift.derivatives == 1 {
            moved[1][at] = multiply(still[1][at], factor);
            let back = ((width - kx) % width) * height + (height - ky) % height;
            let image = first_of(still[0][at], still[0][back]);
            moved[2][at] = together(
                multiply(image, multiply(across[1], down[0])),
                multiply(image, multiply(across[0], down[1])),
            );
        }
    }
}
