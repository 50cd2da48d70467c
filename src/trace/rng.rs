//! One stream of random numbers for each path, so that no result depends on the number of threads.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Spacing of the seeds of neighbouring paths. Odd, so that paths never share a seed; and not the increment of
/// SplitMix64, which fills the generator's state: with that, neighbours would share three of their four words.
const PATH_STRIDE: u64 = 0xd134_2543_de82_ef95;

/// 2^-24: one step of the uniform numbers.
const STEP: f32 = 1.0 / (1 << 24) as f32;

/// Uniform random numbers of one path.
///
/// Xoshiro256++ (Blackman and Vigna 2021), seeded from the run's seed and the path's index.
#[derive(Debug, Clone)]
pub struct Stream(Xoshiro256PlusPlus);

impl Stream {
    /// The stream of path number `path` of the run whose [`key`](Self::key) is given.
    #[inline]
    pub fn new(key: u64, path: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(key.wrapping_add(path.wrapping_mul(PATH_STRIDE))))
    }

    /// Hash of a run's seed. Without it path i of seed s could be path i-1 of seed s+1, or near it.
    pub fn key(seed: u64) -> u64 {
        Xoshiro256PlusPlus::seed_from_u64(seed).next_u64()
    }

    /// A uniform number in [0, 1), a multiple of 2^-24.
    #[inline]
    pub fn uniform(&mut self) -> f32 {
        (self.0.next_u64() >> 40) as f32 * STEP
    }

    /// A uniform number in (0, 1], a multiple of 2^-24, of which a logarithm can be taken.
    #[inline]
    pub fn uniform_above_zero(&mut self) -> f32 {
        ((self.0.next_u64() >> 40) + 1) as f32 * STEP
    }

    /// A uniform number in [0, 1), a multiple of 2^-53, for what is drawn only once per path.
    #[inline]
    pub fn uniform_f64(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbouring_seeds_and_paths_share_no_stream() {
        let mut seen = std::collections::HashSet::new();
        for seed in 0..64 {
            for path in 0..64 {
                let mut stream = Stream::new(Stream::key(seed), path);
                assert!(seen.insert(stream.0.next_u64()), "seed {seed}, path {path}");
            }
        }
    }

    #[test]
    fn neighbouring_paths_are_uncorrelated() {
        let key = Stream::key(1);
        let n = 100_000;
        let first = |path| f64::from(Stream::new(key, path).uniform()) - 0.5;
        let product: f64 = (0..n).map(|i| first(i) * first(i + 1)).sum();
        // The product of two centred uniforms has standard deviation 1/12.
        assert!((product / n as f64).abs() < 4.0 / (12.0 * (n as f64).sqrt()));
    }

    #[test]
    fn uniform_numbers_keep_to_their_interval() {
        let mut stream = Stream::new(Stream::key(0), 0);
        for _ in 0..1_000_000 {
            assert!((0.0..1.0).contains(&stream.uniform()));
            let above = stream.uniform_above_zero();
            assert!(above > 0.0 && above <= 1.0);
        }
    }
}
