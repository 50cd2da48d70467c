//! What lies between two occluders: its slices, and the light that it sends on towards the camera.

use super::Optics;
use super::canvas::{Canvas, Place, Spectrum};
use super::obliquity::Obliquity;
use super::plan::Plan;
use super::slices::{Node, Slices};
use super::slope_correction::slope_correction;
use super::sources::{Layer, Source};
use super::transfer::{Frequency, Wave, Way, over, times};
use crate::error::Result;
use crate::medium::Medium;
use crate::relief::Occluder;
use rayon::prelude::*;
use rustfft::num_complex::Complex;

/// Sources between two occluders.
pub(super) struct Slab {
    pub slices: Option<Slices>,
    /// The object weighted for each slice, transformed.
    light: Vec<Spectrum>,
    /// The source of its slope term, likewise; none at all if nothing slopes.
    slope_correction: Vec<Spectrum>,
    /// Length of a pixel per unit of depth; 0 for parallel rays.
    divergence: f64,
    /// For each row of the canvas the pixels whose direct light the occluder lets pass.
    direct: Vec<Vec<Direct>>,
    /// What its light must pass.
    pub occluder: Option<VisibilityMask>,
}

/// Direct light of a pixel of a row of the canvas.
struct Direct {
    x: usize,
    /// Path length along the camera's axis, and the cosine of the ray off it.
    z: f64,
    cosine: f64,
    light: f32,
}

/// An occluder on the canvas.
pub(super) struct VisibilityMask {
    pub node: Node,
    /// 0 where the occluder is opaque, 1 elsewhere.
    open: Vec<f32>,
}

/// Light at an occluder, on its way to the camera: spectra of the image and its derivatives.
pub(super) struct Carried {
    node: Node,
    spectra: Vec<Spectrum>,
}

impl Slab {
    /// The part of `layers` that must pass `passed` occluders.
    pub(super) fn new(
        (plan, canvas): (&Plan, &Canvas),
        layers: &[Layer],
        passed: usize,
        slices: Option<Slices>,
    ) -> Self {
        let occluder = plan.occluder(passed);
        let mine =
            |of: usize| layers.iter().filter_map(move |layer| layer[of].filter(|s| s.occluders == passed));
        let mut slab = Self {
            light: Vec::new(),
            slope_correction: Vec::new(),
            divergence: plan.target.geometry.pitch_per_depth(),
            direct: Vec::new(),
            occluder: occluder.map(|occluder| VisibilityMask::new(plan, canvas, occluder)),
            slices,
        };
        let Some(slices) = &slab.slices else { return slab };
        let count = slices.nodes.len();
        let weighted = |value: &(dyn Fn(&Source, [f32; 2]) -> f32 + Sync)| -> Vec<Vec<f32>> {
            let mut planes = vec![vec![0.0; canvas.pixels()]; count];
            canvas.rows(&mut planes).enumerate().for_each(|(j, mut row)| {
                let mut latest: Option<(Node, Vec<f64>)> = None;
                for place in canvas.row(j) {
                    for source in mine(place.of) {
                        let value = value(&source, place.turn);
                        if value != 0.0 {
                            // Neighbours often lie at one depth.
                            let weights = match latest.take() {
                                Some((node, weights)) if node == source.node => weights,
                                _ => slices.weights(source.node),
                            };
                            for (part, weight) in row.iter_mut().zip(&weights) {
                                part[place.x] += *weight as f32 * value;
                            }
                            latest = Some((source.node, weights));
                        }
                    }
                }
            });
            planes
        };
        let light = weighted(&|s, _| s.light);
        slab.light = light.into_iter().map(|plane| canvas.fft.forward(plane)).collect();
        let sloping = layers.iter().flatten().flatten().any(|s| s.occluders == passed && s.slope != [0.0; 2]);
        if sloping {
            let along = |axis: usize| weighted(&move |s, turn| turn[axis] * s.slope[axis] * s.light);
            let fields = along(0).into_iter().zip(along(1));
            slab.slope_correction = fields.map(|(x, y)| slope_correction(canvas, [x, y])).collect();
        }
        let direct = |j: usize| -> Vec<Direct> {
            let open = canvas.row(j).filter(|place| occluder.is_none_or(|s| !s.opaque[place.of]));
            let light = |place: Place| {
                mine(place.of).map(move |s| Direct {
                    x: place.x,
                    z: s.node.z,
                    cosine: s.cosine,
                    light: s.light,
                })
            };
            open.flat_map(light).collect()
        };
        slab.direct = (0..canvas.fft.height).into_par_iter().map(direct).collect();
        slab
    }

    /// Adds the direct light of this slab, as it is at the path length `from` along the axis, and its derivatives
    /// to `planes`.
    pub(super) fn add_direct(&self, canvas: &Canvas, medium: &Medium, from: f64, planes: &mut [Vec<f32>]) {
        canvas.rows(planes).zip(&self.direct).for_each(|(mut row, direct)| {
            let (mut last, mut transmittance) = (f64::NAN, 0.0);
            for d in direct {
                let way = (d.z - from) / d.cosine;
                if way != last {
                    (last, transmittance) = (way, (-medium.sigma_t() * way).exp() as f32);
                }
                let light = transmittance * d.light;
                let way = way as f32;
                for (part, factor) in row.iter_mut().zip([1.0, -way, -way, 0.0]) {
                    part[d.x] += factor * light;
                }
            }
        });
    }

    /// Light scattered on its way to this slab's occluder, or to the camera: that of the slab itself, and what is
    /// `carried` to it from farther occluders. Spectra of the `components` of image and derivatives.
    pub(super) fn gather(
        &self,
        canvas: &Canvas,
        (optics, obliquity): (&Optics, Obliquity),
        carried: Option<&Carried>,
        components: &[usize],
    ) -> Result<Vec<Spectrum>> {
        let sloping = !self.slope_correction.is_empty();
        let Way { transfers, farther, divisor } = Way::new(
            self.slices.as_ref().map_or(&[][..], |s| &s.nodes),
            sloping.then_some(self.divergence),
            carried.map(|c| c.node),
            self.occluder.as_ref().map(|mask| mask.node),
            (optics, obliquity, canvas.sampling),
        )?;

        let (half, height) = (canvas.fft.half_width(), canvas.fft.height);
        let mut sums = vec![vec![Complex::new(0.0, 0.0); half * height]; components.len()];
        let mut columns: Vec<Vec<&mut [Complex<f32>]>> = (0..half).map(|_| Vec::new()).collect();
        for sum in &mut sums {
            for (column, part) in columns.iter_mut().zip(sum.chunks_mut(height)) {
                column.push(part);
            }
        }
        let [across, down] = &canvas.axes;
        columns.into_par_iter().enumerate().for_each(|(kx, mut column)| {
            let basis = &across.basis[kx];
            let lines: Vec<_> = transfers.iter().map(|t| t.line(basis)).collect();
            let farther = farther.as_ref().map(|t| (t, t.line(basis)));
            let divisor = divisor.as_ref().map(|d| (d, d.line(basis)));
            for ky in 0..=height / 2 {
                let w = (across.w[kx].powi(2) + down.w[ky].powi(2)).sqrt();
                let at = Frequency {
                    w,
                    weight: across.pixel[kx] * down.pixel[ky],
                    basis: &down.basis[ky],
                    scale: divisor.as_ref().map_or([1.0, 0.0, 0.0, 0.0], |(d, _)| d.scale(w)),
                };
                let mirrored = (ky > 0 && 2 * ky < height).then(|| height - ky);
                let places = [Some(ky), mirrored].into_iter().flatten().map(|y| kx * height + y);
                let mut sum = [Wave::default(); 2];
                let mut direct = [Wave::default(); 2];
                for (i, (transfer, line)) in transfers.iter().zip(&lines).enumerate() {
                    let scattered = transfer.scattered(line, &at);
                    let slope_correction = if sloping { transfer.slope_correction(&at) } else { [0.0; 4] };
                    for (j, place) in places.clone().enumerate() {
                        let light = self.light[i][place];
                        add(&mut sum[j], light, &scattered);
                        if sloping {
                            add(&mut sum[j], self.slope_correction[i][place], &slope_correction);
                        }
                        if divisor.is_some() {
                            add(&mut direct[j], light, &transfer.direct);
                        }
                    }
                }
                if let (Some((transfer, line)), Some(carried)) = (&farther, carried) {
                    let whole = transfer.whole(line, &at);
                    for (j, place) in places.clone().enumerate() {
                        let wave = times(&carried.wave(place), &whole);
                        sum[j].iter_mut().zip(wave).for_each(|(s, v)| *s += v);
                    }
                }
                if let Some((divisor, line)) = &divisor {
                    let [own, whole] = divisor.at(line, &at);
                    for (sum, direct) in sum.iter_mut().zip(&direct) {
                        sum.iter_mut().zip(times(direct, &own)).for_each(|(s, v)| *s -= v);
                        *sum = over(sum, &whole);
                    }
                }
                for (sum, y) in sum.iter().zip([Some(ky), mirrored].into_iter().flatten()) {
                    column.iter_mut().zip(components).for_each(|(out, &c)| out[y] = sum[c]);
                }
            }
        });
        Ok(sums)
    }

    /// Takes the light at the slab's occluder through it; `fields` are image and derivatives there, without the
    /// direct light.
    pub(super) fn pass(
        &self,
        mask: &VisibilityMask,
        canvas: &Canvas,
        medium: &Medium,
        mut fields: Vec<Vec<f32>>,
    ) -> Carried {
        self.add_direct(canvas, medium, mask.node.z, &mut fields);
        let masked = fields.into_iter().map(|mut field| {
            mask.apply(&mut field);
            canvas.fft.forward(field)
        });
        Carried { node: mask.node, spectra: masked.collect() }
    }
}

impl VisibilityMask {
    fn new(plan: &Plan, canvas: &Canvas, occluder: &Occluder) -> Self {
        let mut open = [vec![1.0; canvas.pixels()]];
        canvas.rows(&mut open).enumerate().for_each(|(j, mut row)| {
            for place in canvas.row(j).filter(|place| occluder.opaque[place.of]) {
                row[0][place.x] = 0.0;
            }
        });
        let [open] = open;
        Self { node: plan.node(occluder), open }
    }

    /// Takes away what meets the occluder.
    pub(super) fn apply(&self, field: &mut [f32]) {
        field.iter_mut().zip(&self.open).for_each(|(v, open)| *v *= open);
    }
}

impl Carried {
    fn wave(&self, place: usize) -> Wave {
        std::array::from_fn(|c| self.spectra.get(c).map_or(Complex::default(), |s| s[place]))
    }
}

fn add(sum: &mut Wave, light: Complex<f32>, factor: &[f32; 4]) {
    for (s, f) in sum.iter_mut().zip(factor) {
        *s += light * f;
    }
}
