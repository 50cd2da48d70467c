//! Plans of 2-D Fourier transforms for the stage `fft`.
//!
//! An image is stored row by row, its transform column by column, so that one of two passes reads or writes neighbours.

use super::shaders::FFT;
use crate::error::{Error, Result};
use crate::gpu::{Gpu, Recording, Stage};
use bytemuck::{Pod, Zeroable};
use std::f64::consts::TAU;
use std::sync::Arc;
use wgpu::Buffer;

/// Numbers that one workgroup transforms: two copies fill the 16 KiB of shared memory that every adapter has.
pub const CAPACITY: usize = 1024;

/// Counterpart of `Fft` in shaders/fft.wgsl.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Parameters {
    n: u32,
    lines: u32,
    per_group: u32,
    inner: u32,
    read: Strides,
    written: Strides,
    twiddle: u32,
    inverse: u32,
    scale: f32,
    factors: u32,
    padding: [u32; 2],
    factor: [u32; 12],
}

/// Distances in memory between the numbers of a line, lines, and groups of lines.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
struct Strides {
    element: u32,
    inner: u32,
    outer: u32,
}

/// Transforms of complex images of one size.
pub struct FftPlan {
    stage: Arc<Stage>,
    forward: Vec<Pass>,
    inverse: Vec<Pass>,
}

/// One dispatch.
struct Pass {
    parameters: Parameters,
    roots: Buffer,
}

/// Lines to be transformed: how many, and where they are before and after.
struct Lines {
    n: usize,
    count: usize,
    /// Distances between numbers and between lines.
    from: [usize; 2],
    to: [usize; 2],
}

impl FftPlan {
    /// The plan for images of `width` by `height`.
    ///
    /// # Errors
    /// [`Error::Gpu`] if a side has a prime factor above 1024, or is above its square.
    pub fn new(gpu: &Gpu, width: usize, height: usize) -> Result<Self> {
        let across = |from, to| Lines { n: width, count: height, from, to };
        let down = Lines { n: height, count: width, from: [1, height], to: [1, height] };
        let (image, spectrum) = ([1, width], [height, 1]);
        let scale = 1.0 / (width as f64 * height as f64);
        let both = |first: Lines, second: Lines, inverse: bool, scale: f64| -> Result<Vec<Pass>> {
            let mut passes = passes(gpu, &first, inverse, 1.0)?;
            passes.extend(self::passes(gpu, &second, inverse, scale)?);
            Ok(passes)
        };
        Ok(Self {
            stage: gpu.stage(&FFT),
            forward: both(across(image, spectrum), Lines { ..down }, false, 1.0)?,
            inverse: both(down, across(spectrum, image), true, scale)?,
        })
    }

    /// Transforms `images[i]` for each `i` of `which`, with the last of `images` as working space; the buffers change
    /// places so that each result is where its image was.
    pub fn record(
        &self,
        recording: &mut Recording,
        images: &mut [Buffer; 3],
        which: &[usize],
        inverse: bool,
    ) {
        for &i in which {
            for pass in if inverse { &self.inverse } else { &self.forward } {
                let p = &pass.parameters;
                let groups = p.lines.div_ceil(p.per_group) as usize;
                let buffers = [&pass.roots, &images[i], &images[2]];
                recording.dispatch_groups(&self.stage, p, &buffers, groups);
                images.swap(i, 2);
            }
        }
    }

    /// Dispatches of one transform.
    pub fn passes(&self) -> usize {
        self.forward.len()
    }
}

/// The dispatches that transform `lines` and multiply by `scale`.
fn passes(gpu: &Gpu, lines: &Lines, inverse: bool, scale: f64) -> Result<Vec<Pass>> {
    let &Lines { n, count, from, to } = lines;
    let strides = |element: usize, inner: usize, outer: usize| Strides {
        element: element as u32,
        inner: inner as u32,
        outer: outer as u32,
    };
    let [a, b] = split(n)?;
    if b == 1 {
        let ends = [strides(from[0], from[1], 0), strides(to[0], to[1], 0)];
        return Ok(vec![pass(gpu, n, [count, count], ends, None, inverse, scale)?]);
    }
    // Number b i + j of a line is number i of its part j; number k of part j, twiddled, is number j of line k.
    let first = [strides(b * from[0], from[0], from[1]), strides(b, 1, n)];
    let second = [strides(1, b, n), strides(a * to[0], to[0], to[1])];
    Ok(vec![
        pass(gpu, a, [count * b, b], first, Some(n), inverse, 1.0)?,
        pass(gpu, b, [count * a, a], second, None, inverse, scale)?,
    ])
}

fn pass(
    gpu: &Gpu,
    n: usize,
    [lines, inner]: [usize; 2],
    [read, written]: [Strides; 2],
    twiddle: Option<usize>,
    inverse: bool,
    scale: f64,
) -> Result<Pass> {
    let radices = radices(n);
    let mut factor = [0; 12];
    factor.iter_mut().zip(&radices).for_each(|(f, &r)| *f = r as u32);
    let roots: Vec<[f32; 2]> = roots(n).chain(twiddle.into_iter().flat_map(roots)).collect();
    Ok(Pass {
        parameters: Parameters {
            n: n as u32,
            lines: lines as u32,
            per_group: (CAPACITY / n) as u32,
            inner: inner as u32,
            read,
            written,
            twiddle: u32::from(twiddle.is_some()),
            inverse: u32::from(inverse),
            scale: scale as f32,
            factors: radices.len() as u32,
            padding: [0; 2],
            factor,
        },
        roots: gpu.upload("roots of unity", &roots)?,
    })
}

/// exp(-2 pi i j/n), j = 0..n.
fn roots(n: usize) -> impl Iterator<Item = [f32; 2]> {
    (0..n).map(move |j| {
        let (sin, cos) = (-TAU * j as f64 / n as f64).sin_cos();
        [cos as f32, sin as f32]
    })
}

/// Prime factors, in increasing order.
fn primes(mut n: usize) -> Vec<usize> {
    let mut all = Vec::new();
    let mut p = 2;
    while p * p <= n {
        while n.is_multiple_of(p) {
            all.push(p);
            n /= p;
        }
        p += 1;
    }
    if n > 1 {
        all.push(n);
    }
    all
}

/// Factors of the steps within a line: twos by pairs, the rest prime.
fn radices(n: usize) -> Vec<usize> {
    let primes = primes(n);
    let twos = primes.iter().filter(|&&p| p == 2).count();
    let mut all = vec![4; twos / 2];
    all.extend(primes.iter().skip(twos - twos % 2));
    all
}

/// Two factors of `n` of at most [`CAPACITY`], the second 1 if one is enough.
fn split(n: usize) -> Result<[usize; 2]> {
    if n <= CAPACITY {
        return Ok([n, 1]);
    }
    let fits = |a: &usize| n.is_multiple_of(*a) && *a <= CAPACITY && n / a <= CAPACITY;
    let half = n.isqrt();
    let a = (half..=CAPACITY).find(fits).ok_or_else(|| {
        Error::Gpu(format!(
            "a padded image side of {n} px has no two factors up to {CAPACITY}, which the graphics adapter's Fourier \
             transform needs; use --backend cpu, another border, or crop the object image"
        ))
    })?;
    Ok([a, n / a])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_into_factors() {
        assert_eq!(radices(1024), [4; 5]);
        assert_eq!(radices(2 * 3 * 5 * 7), [2, 3, 5, 7]);
        assert_eq!(radices(1), [0; 0]);
        assert_eq!(split(1000).unwrap(), [1000, 1]);
        let [a, b] = split(4096).unwrap();
        assert_eq!((a * b, a.max(b)), (4096, 64));
        assert!(split(2 * 1031).unwrap_err().to_string().contains("2062"));
    }
}
