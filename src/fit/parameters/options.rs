//! What the user asks of each parameter.

use crate::forward::Quantity;
use crate::scene::{FitOptions, ParameterOptions};

impl FitOptions {
    /// What is asked of the medium's parameter that moves `quantity`.
    ///
    /// # Panics
    /// If it is not one of a medium.
    pub(crate) fn of(&self, quantity: Quantity) -> &ParameterOptions {
        match quantity {
            Quantity::SigmaS => &self.sigma_s,
            Quantity::SigmaA => &self.sigma_a,
            Quantity::Phase => &self.phase,
            _ => panic!("{quantity:?} is not a quantity of a medium"),
        }
    }

    fn of_mut(&mut self, quantity: Quantity) -> &mut ParameterOptions {
        match quantity {
            Quantity::SigmaS => &mut self.sigma_s,
            Quantity::SigmaA => &mut self.sigma_a,
            Quantity::Phase => &mut self.phase,
            _ => panic!("{quantity:?} is not a quantity of a medium"),
        }
    }

    /// Whether no parameter is started by the user.
    pub(crate) fn is_unstarted(&self) -> bool {
        Quantity::MEDIUM.iter().all(|&quantity| self.of(quantity).start.is_none())
    }

    /// These options, started at `values` where the user has not started.
    pub(crate) fn or_started_at(mut self, values: impl Fn(Quantity) -> f64) -> Self {
        for quantity in Quantity::MEDIUM {
            self.of_mut(quantity).start.get_or_insert(values(quantity));
        }
        self
    }

    /// These options, started at `values`.
    pub fn started_at(mut self, values: impl Fn(Quantity) -> f64) -> Self {
        for quantity in Quantity::MEDIUM {
            self.of_mut(quantity).start = Some(values(quantity));
        }
        self
    }

    /// These options with the parameter that moves `quantity` held at `value`.
    pub(crate) fn held_at(mut self, quantity: Quantity, value: f64) -> Self {
        self.of_mut(quantity).fixed = Some(value);
        self
    }

    /// The same with as little room as a fit needs for something to be free.
    pub(crate) fn nearly_held_at(mut self, quantity: Quantity, value: f64) -> Self {
        let options = self.of_mut(quantity);
        options.bounds = Some([value, value * (1.0 + 1e-9) + 1e-300]);
        options.start = Some(value);
        self
    }
}
