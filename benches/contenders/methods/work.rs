//! Counted cost.

use std::ops::{Add, AddAssign, Mul};

/// What a contender asks of an adapter: from formulas, for the stages as they are written.
///
/// Operations are additions and multiplications of f32 (a fused one counts two). Bytes are what workgroups read from and
/// write to storage buffers, without tables, which caches hold.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Arithmetic operations.
    pub flops: f64,
    /// Memory traffic.
    pub bytes: f64,
    /// Dispatches.
    pub dispatches: f64,
}

/// A round adapter: operations and bytes per second, and seconds that a dispatch takes besides.
const ADAPTER: (f64, f64, f64) = (1e13, 4e11, 5e-6);

impl Work {
    /// One dispatch with `flops` and `bytes` for each of `items`.
    pub fn dispatch(items: f64, flops: f64, bytes: f64) -> Self {
        Self { flops: items * flops, bytes: items * bytes, dispatches: 1.0 }
    }

    /// Seconds on a round adapter of 10 Tflop/s, 400 GB/s and 5 µs a dispatch, whose arithmetic and memory work side by side.
    pub fn seconds(self) -> f64 {
        let (flops, bytes, dispatch) = ADAPTER;
        (self.flops / flops).max(self.bytes / bytes) + dispatch * self.dispatches
    }
}

impl Add for Work {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            flops: self.flops + other.flops,
            bytes: self.bytes + other.bytes,
            dispatches: self.dispatches + other.dispatches,
        }
    }
}

impl AddAssign for Work {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Mul<f64> for Work {
    type Output = Self;

    fn mul(self, times: f64) -> Self {
        Self { flops: times * self.flops, bytes: times * self.bytes, dispatches: times * self.dispatches }
    }
}
