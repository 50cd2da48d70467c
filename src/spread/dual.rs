//! Values with their derivatives in the medium's parameters.

use std::ops::{Add, Div, Mul, Sub};

/// Value and derivatives in (sigma_s, sigma_a, B) of a transfer function or of a share of light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Derivatives in sigma_s (length), sigma_a (length) and B (1/rad²).
    pub gradient: [f64; 3],
}

impl Dual {
    /// A number that does not depend on the medium.
    pub fn constant(value: f64) -> Self {
        Self { value, gradient: [0.0; 3] }
    }

    fn combine(self, other: Self, value: f64, of_self: f64, of_other: f64) -> Self {
        let gradient = std::array::from_fn(|i| of_self * self.gradient[i] + of_other * other.gradient[i]);
        Self { value, gradient }
    }
}

impl Add for Dual {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.combine(other, self.value + other.value, 1.0, 1.0)
    }
}

impl Sub for Dual {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.combine(other, self.value - other.value, 1.0, -1.0)
    }
}

impl Mul for Dual {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        self.combine(other, self.value * other.value, other.value, self.value)
    }
}

impl Mul<Dual> for f64 {
    type Output = Dual;

    fn mul(self, other: Dual) -> Dual {
        Dual::constant(self) * other
    }
}

impl Div for Dual {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let ratio = self.value / other.value;
        self.combine(other, ratio, 1.0 / other.value, -ratio / other.value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_follow_the_rules_of_calculus() {
        let at = |t: f64| {
            let a = Dual { value: 2.0 + 3.0 * t, gradient: [3.0, 0.0, 1.0] };
            let b = Dual { value: 5.0 - t, gradient: [-1.0, 2.0, 0.0] };
            [a + b, a - b, a * b, a / b, 7.0 * a]
        };
        let step = 1e-6;
        for (i, d) in at(0.0).into_iter().enumerate() {
            let difference = (at(step)[i].value - at(-step)[i].value) / (2.0 * step);
            assert!((d.gradient[0] - difference).abs() < 1e-8, "{i}");
        }
    }
}
