//! Depth slices: a few path lengths that stand for all of a depth map's.
//!
//! The filter's transfer function at any depth is a smooth function of the path length z and of the magnification
//! a = pitch/z; it is interpolated by polynomials on Chebyshev nodes. So slice i filters the image weighted with
//! the i-th basis polynomial at each pixel's own (z, a). With parallel rays a follows from z and the nodes lie
//! along z alone; in a perspective view they form a grid. A map of a few distinct depths gets exactly those.

use super::chebyshev::Chebyshev;
use super::{Optics, Target};
use crate::error::Result;
use crate::geometry::{Camera, Field};

/// One slice: a path length and the length of a pixel at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Node {
    /// Path length, length.
    pub z: f64,
    /// Length of a pixel.
    pub pitch: f64,
}

/// Slices of one target.
#[derive(Debug, Clone)]
pub struct Slices {
    /// The slices' path lengths and pitches.
    pub nodes: Vec<Node>,
    layout: Layout,
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

/// Range of a quantity over the pixels of a target.
#[derive(Debug, Clone, Copy)]
struct Range {
    low: f64,
    high: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        values.fold(Range { low: f64::INFINITY, high: f64::NEG_INFINITY }, |r, v| Range {
            low: r.low.min(v),
            high: r.high.max(v),
        })
    }
}

impl Slices {
    /// `count` slices along z for `target`, fewer if it has fewer distinct path lengths.
    pub fn new(target: &Target, count: usize) -> Self {
        Self::over(target, &sorted_nodes(target), count)
    }

    /// The same from the sorted nodes of the target's pixels.
    fn over(target: &Target, nodes: &[Node], count: usize) -> Self {
        match target.geometry.camera {
            Camera::Orthographic { pixel_pitch } => {
                let node = |z: f64| Node { z, pitch: pixel_pitch };
                let mut distinct: Vec<f64> = nodes.iter().map(|n| n.z).collect();
                distinct.dedup();
                if distinct.len() <= count {
                    let nodes = distinct.iter().map(|&z| node(z)).collect();
                    return Self { nodes, layout: Layout::Exact(distinct) };
                }
                let line = Chebyshev::new(count, distinct[0], distinct[distinct.len() - 1]);
                Self { nodes: line.x.iter().map(|&z| node(z)).collect(), layout: Layout::Line(line) }
            }
            Camera::Perspective { .. } => {
                let z = Range::of(nodes.iter().map(|n| n.z));
                let a = Range::of(nodes.iter().map(|n| n.pitch / n.z));
                let z = Chebyshev::new(if z.high > z.low { count } else { 1 }, z.low, z.high);
                // Pitch and path length are nearly proportional, so this range is short. Interpolation over a range
                // of half-width rho about 1 falls like rho^n.
                let rho = (a.high - a.low) / (a.high + a.low);
                let enough = (SLICE_FLOOR.ln() / rho.ln()).ceil().max(2.0) as usize;
                let many = if rho > 1e-9 { enough.min(count.max(2)) } else { 1 };
                let magnification = Chebyshev::new(many, a.low, a.high);
                let grid =
                    magnification.x.iter().flat_map(|&a| z.x.iter().map(move |&z| Node { z, pitch: a * z }));
                Self { nodes: grid.collect(), layout: Layout::Grid { z, magnification } }
            }
        }
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

    /// Largest error of the interpolated transfer functions over sample pixels and frequencies, relative to the
    /// scattered light.
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn error(&self, target: &Target, optics: &Optics) -> Result<f64> {
        match self.layout {
            Layout::Exact(_) => Ok(0.0),
            _ => self.error_at(&samples(&sorted_nodes(target)), optics),
        }
    }

    fn error_at(&self, samples: &[Node], optics: &Optics) -> Result<f64> {
        let kernels = self.nodes.iter().map(|n| optics.kernel(n.z)).collect::<Result<Vec<_>>>()?;
        let mut worst: f64 = 0.0;
        for &at in samples {
            let kernel = optics.kernel(at.z)?;
            let weights = self.weights(at);
            for i in 0..FREQUENCIES {
                let w = std::f64::consts::PI * 0.5_f64.powf(0.5 * i as f64);
                let slices = kernels.iter().zip(&self.nodes).zip(&weights);
                let sum: f64 =
                    slices.map(|((k, n), weight)| weight * k.scattered_transfer(w / n.pitch).value).sum();
                let want = kernel.scattered_transfer(w / at.pitch).value;
                worst = worst.max((sum - want).abs() / kernel.scattered().max(f64::MIN_POSITIVE));
            }
        }
        Ok(worst)
    }

    /// The fewest slices whose [`error`](Self::error) stays under `tolerance`, at most [`MOST_SLICES`].
    ///
    /// # Errors
    /// As [`Optics::kernel`].
    pub fn for_tolerance(target: &Target, optics: &Optics, tolerance: f64) -> Result<Self> {
        let nodes = sorted_nodes(target);
        let samples = samples(&nodes);
        let mut count = 2;
        loop {
            let slices = Self::over(target, &nodes, count);
            let exact = matches!(slices.layout, Layout::Exact(_));
            if exact || count >= MOST_SLICES || slices.error_at(&samples, optics)? <= tolerance {
                return Ok(slices);
            }
            count += count.div_ceil(3);
        }
    }
}

/// Share of the scattered light to which the magnification is interpolated in a perspective view.
const SLICE_FLOOR: f64 = 1e-5;
/// Slices along z beyond which no more are taken.
pub const MOST_SLICES: usize = 40;
/// Frequencies, from pi rad/px down by half-octaves, at which slices are judged.
const FREQUENCIES: usize = 16;
/// Pixels at which slices are judged.
const SAMPLES: usize = 48;

/// The node of pixel (`x`, `y`), or `None` if it shows no object.
pub fn pixel_node(target: &Target, x: usize, y: usize) -> Option<Node> {
    let g = target.geometry;
    g.path_length(x, y).map(|z| Node { z, pitch: g.pixel_pitch(x, y) })
}

/// The nodes of all pixels that show an object, by path length; one stands for all of a flat scene.
fn sorted_nodes(target: &Target) -> Vec<Node> {
    let g = target.geometry;
    let flat = matches!(
        (&g.camera, &g.depth, &g.surface),
        (Camera::Orthographic { .. }, Field::Uniform(_), Field::Uniform(_))
    );
    let pixels = if flat { 1 } else { g.width * g.height };
    let mut nodes: Vec<Node> =
        (0..pixels).filter_map(|i| pixel_node(target, i % g.width, i / g.width)).collect();
    nodes.sort_by(|a, b| a.z.total_cmp(&b.z));
    nodes
}

/// Some of `nodes`, evenly over their order, and the last.
fn samples(nodes: &[Node]) -> Vec<Node> {
    let step = (nodes.len() / SAMPLES).max(1);
    nodes.iter().step_by(step).chain(nodes.last()).copied().collect()
}
