//! Depth slices: a few path lengths that stand for all of a depth map's.
//!
//! The filter's transfer function at any depth is a smooth function of the path length z, and is interpolated by
//! polynomials on Chebyshev nodes: slice i filters the image weighted with the i-th basis polynomial at each pixel's
//! own z. The length of a pixel follows from z with parallel rays, and in a perspective view before a flat surface of
//! the medium; elsewhere the nodes form a grid of z and the magnification a = pitch/z. A map of a few distinct depths
//! gets exactly those.

use super::Optics;
use crate::chebyshev::Chebyshev;
use crate::error::Result;

/// A path length along the camera's axis, and the length of a pixel at its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Path length in the medium, length.
    pub z: f64,
    /// Length of a pixel.
    pub pitch: f64,
}

/// Slices of the pixels of one target, or of one part of it.
#[derive(Debug, Clone)]
pub struct Slices {
    /// The slices' path lengths and pitches.
    pub nodes: Vec<Node>,
    layout: Layout,
    /// Pixels at which the slices are judged.
    samples: Vec<Node>,
}

#[derive(Debug, Clone)]
enum Layout {
    /// Nodes at exactly these increasing path lengths.
    Exact(Vec<f64>),
    /// Nodes along z.
    Line(Chebyshev),
    /// Nodes along z for each magnification.
    Grid { z: Chebyshev, magnification: Chebyshev },
}

impl Slices {
    /// `count` slices along z for pixels at `nodes` (at least one), fewer if they have fewer distinct path lengths.
    /// `divergence` is the length of a pixel per unit of depth, 0 for parallel rays.
    pub fn new(divergence: f64, nodes: &[Node], count: usize) -> Self {
        Self::over(divergence, &sorted(nodes), [count, usize::MAX])
    }

    /// The same for sorted nodes, with `count` slices along z and along the magnification at most.
    fn over(divergence: f64, nodes: &[Node], count: [usize; 2]) -> Self {
        let samples = samples(nodes);
        let (first, last) = (nodes[0], nodes[nodes.len() - 1]);
        // Before a flat surface of the medium the pitch follows from z.
        let pitch = |z: f64| first.pitch + divergence * (z - first.z);
        let follows = |n: &Node| (n.pitch - pitch(n.z)).abs() <= SAME_PITCH * n.pitch;
        if nodes.iter().all(follows) {
            let mut distinct: Vec<f64> = nodes.iter().map(|n| n.z).collect();
            distinct.dedup();
            let exact = distinct.len() <= count[0];
            let z = if exact { distinct } else { Chebyshev::new(count[0], first.z, last.z).x };
            let nodes = z.iter().map(|&z| Node { z, pitch: pitch(z) }).collect();
            let layout = if exact { Layout::Exact(z) } else { Layout::Line(Chebyshev { x: z }) };
            return Self { nodes, layout, samples };
        }
        let magnifications = || nodes.iter().map(|n| n.pitch / n.z);
        let near = magnifications().fold(f64::INFINITY, f64::min);
        let far = magnifications().fold(0.0, f64::max);
        let z = Chebyshev::new(if last.z > first.z { count[0] } else { 1 }, first.z, last.z);
        // Interpolation over a range of half-width rho about 1 falls like rho^n.
        let rho = (far - near) / (far + near);
        let enough = (SLICE_FLOOR.ln() / rho.ln()).ceil().max(2.0) as usize;
        let magnification = Chebyshev::new(enough.min(count[1]), near, far);
        let grid = magnification.x.iter().flat_map(|&a| z.x.iter().map(move |&z| Node { z, pitch: a * z }));
        Self { nodes: grid.collect(), layout: Layout::Grid { z, magnification }, samples }
    }

    /// Weight of every slice for a pixel whose own node is `at`; they add up to 1.
    pub fn weights(&self, at: Node) -> Vec<f64> {
        match &self.layout {
            Layout::Exact(depths) => depths.iter().map(|&z| f64::from(u8::from(z == at.z))).collect(),
            Layout::Line(line) => line.basis(at.z),
            Layout::Grid { z, magnification } => {
                let along_z = z.basis(at.z);
                let weights = magnification.basis(at.pitch / at.z);
                weights.iter().flat_map(|a| along_z.iter().map(move |z| a * z)).collect()
            }
        }
    }

    /// Number of slices along z and along the magnification, and whether each stands for its own z alone.
    pub fn counts(&self) -> ([usize; 2], bool) {
        match &self.layout {
            Layout::Exact(depths) => ([depths.len(), 1], true),
            Layout::Line(line) => ([line.x.len(), 1], false),
            Layout::Grid { z, magnification } => ([z.x.len(), magnification.x.len()], false),
        }
    }

    /// Where `at` lies along z and along the magnification: the number of its slice if slices stand for their own z
    /// alone, else in [-1, 1] from the first slice to the last.
    pub fn place(&self, at: Node) -> [f64; 2] {
        match &self.layout {
            Layout::Exact(depths) => [depths.partition_point(|&z| z < at.z) as f64, 0.0],
            Layout::Line(line) => [line.place(at.z), 0.0],
            Layout::Grid { z, magnification } => [z.place(at.z), magnification.place(at.pitch / at.z)],
        }
    }

    /// Where the slices lie along z, then along the magnification, in the terms of [`place`](Self::place).
    pub fn node_places(&self) -> Vec<f32> {
        let places = |line: &Chebyshev| line.x.iter().map(|&x| line.place(x) as f32).collect::<Vec<_>>();
        let one = |line: &Chebyshev| [places(line), vec![0.0]].concat();
        match &self.layout {
            Layout::Exact(depths) => (0..=depths.len()).map(|i| i as f32).collect(),
            Layout::Line(line) => one(line),
            Layout::Grid { z, magnification } => [places(z), places(magnification)].concat(),
        }
    }

    /// Largest error of the interpolated transfer functions over sample pixels and frequencies, relative to the
    /// scattered light.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn error(&self, optics: &Optics) -> Result<f64> {
        if matches!(self.layout, Layout::Exact(_)) {
            return Ok(0.0);
        }
        let slices = self.nodes.iter().map(|n| response(n, optics)).collect::<Result<Vec<_>>>()?;
        let mut worst: f64 = 0.0;
        for at in &self.samples {
            let scattered = optics.kernel(at.z)?.scattered().max(f64::MIN_POSITIVE);
            let weights = self.weights(*at);
            for (i, want) in response(at, optics)?.into_iter().enumerate() {
                let sum: f64 = slices.iter().zip(&weights).map(|(slice, weight)| weight * slice[i]).sum();
                worst = worst.max((sum - want).abs() / scattered);
            }
        }
        Ok(worst)
    }

    /// The fewest slices for pixels at `nodes` (at least one) whose [`error`](Self::error) stays under `tolerance`, at
    /// most [`MOST_SLICES`] along z.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn for_tolerance(divergence: f64, nodes: &[Node], optics: &Optics, tolerance: f64) -> Result<Self> {
        let nodes = sorted(nodes);
        let mut count = [2, 1];
        let mut best = Self::over(divergence, &nodes, count);
        let mut error = best.error(optics)?;
        while error > tolerance && count[0] < MOST_SLICES {
            let [deeper, wider] = [[count[0] + count[0].div_ceil(3), count[1]], [count[0], count[1] + 1]];
            let slices = Self::over(divergence, &nodes, deeper);
            let mut next = (slices.error(optics)?, deeper, slices);
            let slices = Self::over(divergence, &nodes, wider);
            if slices.nodes.len() > best.nodes.len() {
                let error = slices.error(optics)?;
                if error < next.0 {
                    next = (error, wider, slices);
                }
            }
            (error, count, best) = next;
        }
        Ok(best)
    }
}

/// Scattered transfer function at `node` for some frequencies from pi rad/px down by half-octaves.
fn response(node: &Node, optics: &Optics) -> Result<[f64; FREQUENCIES]> {
    let kernel = optics.kernel(node.z)?;
    let w = |i: usize| std::f64::consts::PI * 0.5_f64.powf(0.5 * i as f64);
    Ok(std::array::from_fn(|i| kernel.scattered_transfer(w(i) / node.pitch).value))
}

/// Relative difference of pixel lengths that is rounding: depth maps hold f32.
const SAME_PITCH: f64 = 1e-6;
/// Share of the scattered light to which the magnification is interpolated in a perspective view.
const SLICE_FLOOR: f64 = 1e-5;
/// Slices along z beyond which no more are taken.
pub const MOST_SLICES: usize = 40;
/// Frequencies at which slices are judged.
const FREQUENCIES: usize = 16;
/// Pixels at which slices are judged.
const SAMPLES: usize = 48;

/// By path length.
fn sorted(nodes: &[Node]) -> Vec<Node> {
    let mut nodes = nodes.to_vec();
    nodes.sort_by(|a, b| a.z.total_cmp(&b.z));
    nodes
}

/// Some of `nodes`, evenly over their order, and the last.
fn samples(nodes: &[Node]) -> Vec<Node> {
    let step = (nodes.len() / SAMPLES).max(1);
    nodes.iter().step_by(step).chain(nodes.last()).copied().collect()
}
