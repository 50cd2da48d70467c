//! How much memory may be taken, and who has taken how much of it.
//!
//! An allocation that fails ends the program without a word, and one that succeeds may end others. So whatever takes memory that
//! the input decides (decoders, planes, slices, bases, records) asks here first, by an estimate that stands beside it, and holds
//! a [`Reservation`] as long as it holds the memory. There is one budget a process: by default three quarters of what the
//! machine, its control group or the limit of the address space allows.

mod machine;

use crate::error::{Error, Result};
use std::sync::atomic::{AtomicU64, Ordering};

/// The budget, bytes; 0 until it is set or first asked for.
static BUDGET: AtomicU64 = AtomicU64::new(0);
/// What is reserved, bytes.
static RESERVED: AtomicU64 = AtomicU64::new(0);

/// Share of the machine's memory that is the default budget.
const SHARE: f64 = 0.75;

/// The budget, bytes.
pub fn budget() -> u64 {
    match BUDGET.load(Ordering::Relaxed) {
        0 => {
            let bytes = (SHARE * machine::memory() as f64) as u64;
            BUDGET.store(bytes, Ordering::Relaxed);
            bytes
        }
        bytes => bytes,
    }
}

/// Replaces the budget of this process, bytes, at least 1.
pub fn set_budget(bytes: u64) {
    BUDGET.store(bytes.max(1), Ordering::Relaxed);
}

/// Memory that is reserved until this is dropped.
#[derive(Debug)]
pub struct Reservation(u64);

impl Drop for Reservation {
    fn drop(&mut self) {
        RESERVED.fetch_sub(self.0, Ordering::Relaxed);
    }
}

/// Reserves `bytes` for `what`, which says in words what takes them.
///
/// # Errors
/// [`Error::Memory`] if they exceed what is left of the budget.
pub fn reserve(what: impl FnOnce() -> String, bytes: u64) -> Result<Reservation> {
    let budget = budget();
    let fits = |reserved: u64| reserved.checked_add(bytes).filter(|&sum| sum <= budget);
    match RESERVED.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits) {
        Ok(_) => Ok(Reservation(bytes)),
        Err(reserved) => Err(Error::Memory { what: what(), bytes, left: budget.saturating_sub(reserved) }),
    }
}

/// The product of `factors`, or the largest number if it is larger: sizes that no memory holds.
pub(crate) fn product(factors: &[usize]) -> u64 {
    factors.iter().fold(1, |product: u64, &factor| product.saturating_mul(factor as u64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_reserved_is_given_back() {
        let too_much = || reserve(|| "a test".into(), budget() + 1);
        let message = too_much().unwrap_err().to_string();
        assert!(message.starts_with("a test: takes ") && message.contains("memory"), "{message}");
        // Other tests reserve at the same time, but never half of the machine.
        let half = reserve(|| "a test".into(), budget() / 2).unwrap();
        assert!(reserve(|| "a test".into(), budget() / 2 + 2).is_err());
        drop(half);
        assert!(reserve(|| "a test".into(), budget() / 2 + 2).is_ok());
        assert!(reserve(|| "a test".into(), u64::MAX).is_err());
    }

    #[test]
    fn products_never_overflow() {
        assert_eq!((product(&[3, 4, 5]), product(&[usize::MAX, 8])), (60, u64::MAX));
    }
}
