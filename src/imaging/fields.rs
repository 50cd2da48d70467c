//! Polynomials over a view.

/// Number of monomials up to the second order.
pub const MONOMIALS: usize = 6;

/// Which of them a gain field has: all but the constant.
pub const GAIN_MONOMIALS: std::ops::Range<usize> = 1..MONOMIALS;

/// 1, x, y, x², xy, y² of a place.
pub fn monomials([x, y]: [f64; 2]) -> [f64; MONOMIALS] {
    [1.0, x, y, x * x, x * y, y * y]
}

/// Places in a view: x and y from its middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Places {
    /// Columns of the view, px.
    pub width: usize,
    /// Rows of the view, px.
    pub height: usize,
}

impl Places {
    /// Half the diagonal of the view, px: the unit of places.
    pub fn half_diagonal_px(&self) -> f64 {
        0.5 * (self.width as f64).hypot(self.height as f64)
    }

    /// The pixel `index` from the middle, px.
    pub fn px(&self, index: usize) -> [f64; 2] {
        let middle = |i: usize, n: usize| i as f64 + 0.5 - 0.5 * n as f64;
        [middle(index % self.width, self.width), middle(index / self.width, self.height)]
    }

    /// The same in half diagonals.
    pub fn of(&self, index: usize) -> [f64; 2] {
        let half = self.half_diagonal_px();
        self.px(index).map(|c| c / half)
    }

    /// The [`monomials`] at the pixel `index`.
    pub fn monomials(&self, index: usize) -> [f64; MONOMIALS] {
        monomials(self.of(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corner_is_one_half_diagonal_from_the_middle() {
        let places = Places { width: 40, height: 30 };
        let [x, y] = places.of(0);
        assert!((x.hypot(y) - 1.0).abs() < 0.03 && x < 0.0 && y < 0.0);
        let [u, v] = places.of(40 * 30 - 1);
        assert_eq!([u, v], [-x, -y]);
        assert_eq!(places.monomials(0), [1.0, x, y, x * x, x * y, y * y]);
    }
}
