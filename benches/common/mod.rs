//! What the benches measure their floors with.
#![allow(dead_code, reason = "each bench uses its own part")]

use rayon::prelude::*;
use realfft::RealFftPlanner;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;
use std::time::Instant;

/// Seconds that `f` takes, the best of `rounds`.
pub fn best_of(rounds: usize, mut f: impl FnMut()) -> f64 {
    let mut round = || {
        let start = Instant::now();
        f();
        start.elapsed().as_secs_f64()
    };
    (0..rounds).map(|_| round()).fold(f64::INFINITY, f64::min)
}

/// Nanoseconds that one call of `f` takes on this core, averaged over `arguments`.
pub fn nanoseconds(arguments: &[f64], mut f: impl FnMut(f64)) -> f64 {
    const REPEATS: usize = 200;
    let all = || (0..REPEATS).for_each(|_| arguments.iter().for_each(|&x| f(x)));
    best_of(5, all) * 1e9 / (REPEATS * arguments.len()) as f64
}

/// Seconds of one inverse real 2-D f32 FFT of this width and height on all cores: its columns by rustfft and its rows
/// by realfft, without what lies between them (transposing, scaling, memory to put it in).
pub fn fft_seconds([width, height]: [usize; 2]) -> f64 {
    let half = width / 2 + 1;
    let columns = FftPlanner::<f32>::new().plan_fft_inverse(height);
    let rows = RealFftPlanner::<f32>::new().plan_fft_inverse(width);
    let zero = Complex::new(0.0, 0.0);
    let mut spectrum = vec![zero; half * height];
    let mut image = vec![0.0; width * height];
    best_of(20, || {
        spectrum.par_chunks_mut(height).for_each_init(
            || vec![zero; columns.get_inplace_scratch_len()],
            |scratch, column| columns.process_with_scratch(column, scratch),
        );
        spectrum.par_chunks_mut(half).zip(image.par_chunks_mut(width)).for_each_init(
            || rows.make_scratch_vec(),
            |scratch, (row, out)| {
                row[0].im = 0.0;
                row[half - 1].im = 0.0;
                rows.process_with_scratch(row, out, scratch).expect("sizes are the plan's");
            },
        );
    })
}
