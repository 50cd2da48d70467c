//! The images along which causes leave residuals, at the optimum of a fit.

use super::cause::Cause;
use crate::error::{Error, Result};
use crate::filter::{Target, motion};
use crate::fit::inference::displacement::Displacement;
use crate::fit::inference::error_images::ErrorImages;
use crate::fit::observation::{Observation, VeilTerm};
use crate::forward::{Quantity, Rendering, State};
use crate::geometry::{Field, path_lengths};
use crate::image::{Border, Image};
use crate::imaging::{Blur, GainField, Places, Registration, VeilField};
use crate::phase::PhaseFunction;
use std::f64::consts::PI;

/// Causes whose columns share the noise of a noisy clear image with the residual, which would pass for them. So do errors of the model.
const NOISY: [Cause; 4] = [Cause::Blur, Cause::GainField, Cause::Transfer, Cause::PhaseTail];

/// Share of outside light below which there is none.
const LEAST_OUTSIDE: f64 = 1e-4;

/// A factor that varies over the view: a monomial of the place, or the square of the distance from the middle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Factor {
    Monomial(usize),
    Square,
}

const ONE: Factor = Factor::Monomial(0);
const GRADIENT: [Factor; 2] = [Factor::Monomial(1), Factor::Monomial(2)];
const FIELD: [Factor; 3] = [Factor::Monomial(1), Factor::Monomial(2), Factor::Square];
/// What quadratic fields have beside slopes and square.
const FURTHER: [Factor; 2] = [Factor::Monomial(3), Factor::Monomial(4)];

/// An image times a factor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    /// Number of the image; `None` for the image 1.
    image: Option<usize>,
    factor: Factor,
}

/// The columns of one scene, in units of its observation.
pub(super) struct Columns {
    images: Vec<Image>,
    places: Places,
    gain: f32,
    /// What the model is known to err.
    errors: Vec<Column>,
    /// The columns of each cause.
    causes: Vec<(Cause, Vec<Column>)>,
}

impl Columns {
    /// Those of scene number `scene` of `fit`, which shows `rendering` and whose model errs by `errors`.
    pub(super) fn new(
        fit: &Displacement,
        scene: usize,
        rendering: &Rendering,
        errors: Option<&ErrorImages>,
    ) -> Result<Self> {
        let observation = fit.observed[scene].observation;
        let mut this = Self {
            images: Vec::new(),
            places: observation.places(),
            gain: fit.exposures[scene].gain as f32,
            errors: Vec::new(),
            causes: Vec::new(),
        };
        for error in errors.iter().flat_map(|errors| errors.of_scene(scene)) {
            let column = this.add(error.clone());
            this.errors.push(column);
        }
        let (state, light) = (fit.parameters.state(scene)?, &rendering.image);
        this.add_motion(light, &observation)?;
        this.add_levels(light, &observation);
        this.add_phase_function(fit, scene, errors);
        this.add_depth(rendering, &state);
        this.add_surroundings(fit, scene, &state)?;
        if fit.observed[scene].object_noise.is_some() {
            this.errors.clear();
            this.causes.retain(|(cause, _)| !NOISY.contains(cause));
        }
        Ok(this)
    }

    /// The value of `column` at the pixel `index` of the view.
    pub(super) fn value(&self, column: Column, index: usize) -> f64 {
        let value = column.image.map_or(1.0, |i| f64::from(self.images[i].data[index]));
        if column.factor == ONE {
            return value;
        }
        let terms = self.places.monomials(index);
        match column.factor {
            Factor::Monomial(term) => value * terms[term],
            Factor::Square => value * (terms[3] + terms[5]),
        }
    }

    /// All columns, those of errors first.
    pub(super) fn all(&self) -> impl Iterator<Item = Column> + '_ {
        self.errors.iter().chain(self.causes.iter().flat_map(|(_, columns)| columns)).copied()
    }

    /// Number of columns of errors.
    pub(super) fn error_count(&self) -> usize {
        self.errors.len()
    }

    /// Each cause with the numbers of its columns among all.
    pub(super) fn causes(&self) -> Vec<(Cause, Vec<usize>)> {
        let mut next = self.errors.len();
        let numbered = |(cause, columns): &(Cause, Vec<Column>)| {
            let numbers = (next..next + columns.len()).collect();
            next += columns.len();
            (*cause, numbers)
        };
        self.causes.iter().map(numbered).collect()
    }

    /// Adds an image of the object's light, as it is observed.
    fn add(&mut self, mut image: Image) -> Column {
        image.data.iter_mut().for_each(|v| *v *= self.gain);
        self.images.push(image);
        Column { image: Some(self.images.len() - 1), factor: ONE }
    }

    fn add_cause(&mut self, cause: Cause, image: Image) {
        let column = self.add(image);
        self.causes.push((cause, vec![column]));
    }

    fn made(&self, value: impl Fn(usize) -> f64) -> Image {
        let Places { width, height } = self.places;
        Image { width, height, data: (0..width * height).map(|i| value(i) as f32).collect() }
    }

    /// How the image of `light` moves, and how it blurs.
    fn add_motion(&mut self, light: &Image, observation: &Observation) -> Result<()> {
        let motion = motion(light)?;
        let moved = |axis: usize, i: usize| f64::from(motion[axis].data[i]);
        // A motion of each place: [[xx, xy], [yx, yy]] times the place, px.
        let bent = |this: &Self, [xx, xy, yx, yy]: [f64; 4]| {
            this.made(|i| {
                let [x, y] = this.places.px(i);
                (xx * x + xy * y) * moved(0, i) + (yx * x + yy * y) * moved(1, i)
            })
        };
        let half = self.places.half_diagonal_px();
        let tilted = |this: &Self, axis: usize| {
            this.made(|i| {
                let place = this.places.px(i);
                -place[axis] / half * (place[0] * moved(0, i) + place[1] * moved(1, i))
            })
        };
        let Places { width, height } = self.places;
        let at = |x: usize, y: usize| f64::from(light.at(x, y));
        let blurred = self.made(|i| {
            let (x, y) = (i % width, i / width);
            let (right, down) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
            let (left, up) = (x.saturating_sub(1), y.saturating_sub(1));
            0.5 * (at(left, y) + at(right, y) + at(x, up) + at(x, down) - 4.0 * at(x, y))
        });
        // Of each cause what the next kind of registration would have beside this one.
        let registration = observation.registration;
        let images: Vec<(Cause, Vec<Image>)> = match registration {
            Registration::Similarity => {
                let strains = [[1.0, 0.0, 0.0, -1.0], [0.0, 1.0, 1.0, 0.0]];
                vec![(Cause::Scale, strains.map(|strain| bent(self, strain)).to_vec())]
            }
            Registration::Affine => vec![(Cause::Scale, [0, 1].map(|axis| tilted(self, axis)).to_vec())],
            Registration::Homography => Vec::new(),
            _ => {
                let degree = PI / 180.0;
                let turned = bent(self, [0.0, -degree, degree, 0.0]);
                let scaled = bent(self, [1.0, 0.0, 0.0, 1.0]);
                vec![(Cause::Rotation, vec![turned]), (Cause::Scale, vec![scaled])]
            }
        };
        if registration == Registration::None {
            let columns = motion.map(|image| self.add(image)).to_vec();
            self.causes.push((Cause::Shift, columns));
        }
        for (cause, images) in images {
            let columns = images.into_iter().map(|image| self.add(image)).collect();
            self.causes.push((cause, columns));
        }
        if observation.blur != Blur::Free {
            self.add_cause(Cause::Blur, blurred);
        }
        Ok(())
    }

    /// What gain, veil and response do to the image of `light`.
    fn add_levels(&mut self, light: &Image, observation: &Observation) {
        let Column { image, .. } = self.add(light.clone());
        let field: &[Factor] = match observation.gain_field {
            GainField::None => &FIELD,
            GainField::Radial => &[FIELD[0], FIELD[1], FURTHER[0], FURTHER[1]],
            _ => &[],
        };
        self.add_field(Cause::GainField, image, field);
        let veil: &[Factor] = match observation.veil {
            VeilTerm::Free(VeilField::Constant) => &FIELD,
            VeilTerm::Free(VeilField::Linear) => &[Factor::Square, FURTHER[0], FURTHER[1]],
            VeilTerm::Free(_) => &[],
            _ => &[ONE, FIELD[0], FIELD[1], FIELD[2]],
        };
        self.add_field(Cause::Veil, None, veil);
        let mean = light.mean().max(f64::MIN_POSITIVE);
        let bent = self.made(|i| {
            let share = f64::from(light.data[i]) / mean;
            if share > 0.0 { mean * share * share.ln() } else { 0.0 }
        });
        self.add_cause(Cause::Transfer, bent);
    }

    /// The image number `image`, or 1, times these factors, if there are any.
    fn add_field(&mut self, cause: Cause, image: Option<usize>, factors: &[Factor]) {
        if !factors.is_empty() {
            self.causes.push((cause, factors.iter().map(|&factor| Column { image, factor }).collect()));
        }
    }

    /// The second difference of the reference's light in the width of the phase function: part of it is wider, part of it narrower.
    fn add_phase_function(&mut self, fit: &Displacement, scene: usize, errors: Option<&ErrorImages>) {
        let shape = errors.and_then(|errors| errors.shape(scene));
        if let Some(shape) = shape.filter(|_| !fit.parameters.of(Quantity::Phase).is_absent()) {
            self.add_cause(Cause::PhaseTail, shape);
        }
    }

    /// How the light changes with the depth: tau, sigma_a z and the width of the kernel change with it.
    fn add_depth(&mut self, rendering: &Rendering, state: &State) {
        let phase = state.medium.phase();
        let widening = phase.planar_width() / phase.planar_width_derivative();
        let per_depth = [state.medium.sigma_s(), state.medium.sigma_a(), widening];
        let slopes = Quantity::MEDIUM.map(|quantity| rendering.derivative(quantity));
        let [Some(sigma_s), Some(sigma_a), Some(phase)] = slopes else { return };
        let change = self.made(|i| {
            let slopes = [sigma_s, sigma_a, phase].map(|image| f64::from(image.data[i]));
            slopes.iter().zip(per_depth).map(|(slope, change)| slope * change).sum()
        });
        let Column { image, .. } = self.add(change);
        self.causes.push((Cause::DepthGradient, GRADIENT.map(|factor| Column { image, factor }).to_vec()));
    }

    /// Light of the mean radiance from outside the clear image.
    fn add_surroundings(&mut self, fit: &Displacement, scene: usize, state: &State) -> Result<()> {
        let target = fit.observed[scene].observation.target;
        // Extrapolated light is an error of the model, and what sees much of it is left out.
        if target.border == Border::Unknown {
            return Ok(());
        }
        let level = target.radiance.mean() as f32;
        let even = Image { data: vec![level; target.radiance.data.len()], ..*target.radiance };
        let behind: Vec<Image> = target.behind.iter().map(|_| even.clone()).collect();
        let engine = fit.engine.without_noise();
        let seen = |border: Border| {
            let target = Target { radiance: &even, behind: &behind, border, ..target };
            engine.image(target, state, scene, 1.0)
        };
        let Some([inside]) = known([seen(Border::Zero)])? else { return Ok(()) };
        let all = match target.geometry.depth {
            // All light of a plane that goes on without end.
            Field::Uniform(_) if target.relief.is_none() => {
                let z = path_lengths(&[(target.geometry, target.radiance)]).median;
                let total = engine.total(state, z)? * f64::from(level);
                Image::filled(inside.width, inside.height, total as f32)
            }
            _ => match known([seen(Border::Clamp)])? {
                Some([all]) => all,
                None => return Ok(()),
            },
        };
        let outside = self.made(|i| f64::from(all.data[i] - inside.data[i]));
        if outside.data.iter().all(|&v| f64::from(v) <= LEAST_OUTSIDE * f64::from(level)) {
            return Ok(());
        }
        let Column { image, .. } = self.add(outside);
        let columns = [ONE, GRADIENT[0], GRADIENT[1]].map(|factor| Column { image, factor });
        self.causes.push((Cause::OutsideLight, columns.to_vec()));
        Ok(())
    }
}

/// What was rendered; `None` where a model has no kernels.
fn known<const N: usize>(images: [Result<Image>; N]) -> Result<Option<[Image; N]>> {
    let images = images.into_iter().collect::<Result<Vec<Image>>>();
    match images {
        Err(error) if error.is_about_model() => Ok(None),
        Err(Error::OutOfRange { .. }) => Ok(None),
        images => Ok(Some(images?.try_into().expect("as many as were asked for"))),
    }
}
