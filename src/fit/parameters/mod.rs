//! The named parameters of a fit: those of the medium, which all scenes share, and those of single scenes.
//!
//! Nothing outside knows a parameter by its place: parameters are found by name, or by the [`Quantity`] that they move, and
//! what belongs to one is asked for with its [`Id`].

mod coordinate;
mod medium;
mod nuisance;
mod options;
mod parameter;

pub use coordinate::Coordinate;
pub use parameter::{Bounds, Descriptor, Parameter, Role};

use crate::error::{Error, Result};
use crate::forward::{Quantity, State};
use crate::geometry::PathLengths;
use crate::imaging::Imaging;
use crate::medium::Medium;
use crate::phase::Family;
use crate::scene::FitOptions;
use crate::spread::Model;
use nalgebra::DVector;
use std::ops::Index;

/// A parameter among those of one fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Id(usize);

impl Id {
    /// Its row in vectors and matrices over all parameters.
    pub(super) fn row(self) -> usize {
        self.0
    }
}

/// The parameters of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    family: Family,
    all: Vec<Parameter>,
    /// What the camera of each scene does, as far as it is not fitted; none where it does nothing.
    cameras: Vec<Option<Imaging>>,
}

impl Parameters {
    /// Parameters of the medium as the user asks for them, values not yet chosen where neither fixed nor started.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] where a fixed or starting value lies outside its range, or a bound beyond what `model` has
    /// kernels for; [`Error::NothingToFit`] if all are fixed; those of [`Model::range`].
    pub fn new(options: &FitOptions, model: Model, lengths: PathLengths) -> Result<Self> {
        let all = medium::medium(options, model, lengths)?;
        if !all.iter().any(Parameter::is_free) {
            return Err(Error::NothingToFit("every parameter is fixed".into()));
        }
        Ok(Self { family: options.family, all, cameras: Vec::new() })
    }

    /// Adds what is fitted of the observation of scene number `scene` of `scenes`: its shift, if it is registered, from where it is
    /// first seen, and what is looked for of its camera.
    pub(super) fn add_scene(
        &mut self,
        scene: usize,
        scenes: usize,
        shift_px: Option<[f64; 2]>,
        imaging: Option<Imaging>,
    ) {
        let scene = nuisance::Scene { number: scene, of: scenes };
        self.all.extend(shift_px.into_iter().flat_map(|start_px| scene.shift(start_px)));
        self.all.extend(imaging.iter().flat_map(|imaging| scene.imaging(imaging)));
        if let Some(imaging) = imaging {
            self.cameras.resize(scene.of, None);
            self.cameras[scene.number] = Some(imaging);
        }
    }

    /// The family of the phase function.
    pub fn family(&self) -> Family {
        self.family
    }

    /// Number of parameters.
    pub(super) fn count(&self) -> usize {
        self.all.len()
    }

    /// Number of free parameters.
    pub fn free_count(&self) -> usize {
        self.all.iter().filter(|p| p.is_free()).count()
    }

    /// All parameters.
    pub fn iter(&self) -> impl Iterator<Item = (Id, &Parameter)> {
        self.all.iter().enumerate().map(|(i, parameter)| (Id(i), parameter))
    }

    /// Those of the medium.
    pub fn of_medium(&self) -> impl Iterator<Item = (Id, &Parameter)> {
        self.iter().filter(|(_, p)| p.descriptor().scene.is_none())
    }

    /// Those of scene number `scene`.
    pub fn of_scene(&self, scene: usize) -> impl Iterator<Item = (Id, &Parameter)> {
        self.iter().filter(move |(_, p)| p.descriptor().scene == Some(scene))
    }

    /// The parameter called `name`.
    pub fn find(&self, name: &str) -> Option<Id> {
        self.all.iter().position(|p| p.name() == name).map(Id)
    }

    /// The parameter of the medium that moves `quantity`.
    ///
    /// # Panics
    /// If it is not one of a medium.
    pub fn id(&self, quantity: Quantity) -> Id {
        let found = self.of_medium().find(|(_, p)| p.descriptor().quantity == quantity);
        found.expect("a medium has all its quantities").0
    }

    /// The parameter `id`.
    pub fn get(&self, id: Id) -> &Parameter {
        &self.all[id.0]
    }

    /// The medium's parameter that moves `quantity`.
    pub fn of(&self, quantity: Quantity) -> &Parameter {
        self.get(self.id(quantity))
    }

    /// Its value.
    pub fn value(&self, quantity: Quantity) -> f64 {
        self.of(quantity).value()
    }

    /// The medium that the values describe.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if they describe none.
    pub fn medium(&self) -> Result<Medium> {
        let phase = self.family.phase(self.value(Quantity::Phase))?;
        Medium::new(self.value(Quantity::SigmaS), self.value(Quantity::SigmaA), phase)
    }

    /// What the values say of scene number `scene`.
    ///
    /// # Errors
    /// As [`medium`](Self::medium).
    pub(super) fn state(&self, scene: usize) -> Result<State> {
        let along = |quantity| {
            self.of_scene(scene).find(|(_, p)| p.descriptor().quantity == quantity).map(|(_, p)| p.value())
        };
        let shift_px = along(Quantity::ShiftX).zip(along(Quantity::ShiftY)).map(|(x, y)| [x, y]);
        let mut imaging = self.cameras.get(scene).copied().flatten();
        if let Some(imaging) = &mut imaging {
            self.of_scene(scene)
                .for_each(|(_, p)| p.descriptor().quantity.set_in_imaging(imaging, p.value()));
        }
        Ok(State { medium: self.medium()?, shift_px, imaging })
    }

    /// The parameter that moves `quantity` in scene number `scene`: the scene's own, or the medium's.
    pub(super) fn moving(&self, quantity: Quantity, scene: usize) -> Option<Id> {
        let mine = |p: &Parameter| p.descriptor().scene.is_none_or(|of| of == scene);
        self.iter().find(|(_, p)| p.descriptor().quantity == quantity && mine(p)).map(|(id, _)| id)
    }

    /// Sets the medium's value, moved into its bounds; a fixed one keeps its value.
    pub(super) fn set(&mut self, quantity: Quantity, value: f64) {
        let id = self.id(quantity);
        self.all[id.0].set(value);
    }

    /// These parameters with another phase-function parameter, even if it is not free.
    pub(super) fn with_phase(&self, value: f64) -> Self {
        let mut other = self.clone();
        other.all[self.id(Quantity::Phase).0].replace(value);
        other
    }

    /// Coordinates of all parameters.
    pub(super) fn point(&self) -> DVector<f64> {
        self.vector(Parameter::coordinate)
    }

    /// Takes the free values from coordinates.
    pub(super) fn set_point(&mut self, point: &DVector<f64>) {
        for (parameter, &u) in self.all.iter_mut().zip(point) {
            parameter.set(parameter.value_at(u));
        }
    }

    /// Takes the values of `other` where it has a parameter of the same name.
    pub(super) fn take(&mut self, other: &Self) {
        for parameter in &mut self.all {
            if let Some(id) = other.find(parameter.name()) {
                parameter.set(other.get(id).value());
            }
        }
    }

    /// Takes the coordinates of `other`, and its parameters of scenes.
    pub(super) fn take_all(&mut self, other: &Self) {
        self.cameras.clone_from(&other.cameras);
        for (id, parameter) in other.iter() {
            match self.find(parameter.name()) {
                Some(mine) => {
                    let mine = &mut self.all[mine.0];
                    mine.set(mine.value_at(parameter.coordinate()));
                }
                None => self.all.push(other.get(id).clone()),
            }
        }
    }

    /// The parameters of the medium without those of scenes.
    pub(super) fn medium_alone(&self) -> Self {
        Self {
            family: self.family,
            all: self.of_medium().map(|(_, p)| p.clone()).collect(),
            cameras: Vec::new(),
        }
    }

    /// These parameters at other coordinates.
    pub(super) fn at(&self, point: &DVector<f64>) -> Self {
        let mut other = self.clone();
        other.set_point(point);
        other
    }

    /// d value / d coordinate of each; 0 for one that is not free.
    pub(super) fn chain(&self) -> DVector<f64> {
        self.vector(|p| if p.is_free() { p.slope() } else { 0.0 })
    }

    /// `f` of each parameter.
    pub(super) fn vector(&self, f: impl Fn(&Parameter) -> f64) -> DVector<f64> {
        DVector::from_iterator(self.all.len(), self.all.iter().map(f))
    }

    /// The linear function of the coordinates that is the parameter `id` alone.
    pub fn along(&self, id: Id) -> DVector<f64> {
        DVector::from_fn(self.all.len(), |row, _| f64::from(u8::from(row == id.0)))
    }

    /// The linear function of the coordinates with these slopes in those of the medium.
    pub fn direction(&self, parts: &[(Quantity, f64)]) -> DVector<f64> {
        let mut direction = DVector::zeros(self.all.len());
        parts.iter().for_each(|(quantity, slope)| direction[self.id(*quantity).0] += slope);
        direction
    }
}

impl Index<&str> for Parameters {
    type Output = Parameter;

    /// The parameter of this name.
    ///
    /// # Panics
    /// If there is none.
    fn index(&self, name: &str) -> &Parameter {
        let id = self.find(name).unwrap_or_else(|| panic!("no parameter is called {name}"));
        self.get(id)
    }
}
