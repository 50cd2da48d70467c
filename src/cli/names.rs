//! The names that options take, as clap lists them and refuses others.

use crate::filter::Filter;
use crate::fit::Method;
use crate::phase::Family;
use crate::spread::Model;
use clap::ValueEnum;
use clap::builder::PossibleValue;
use std::sync::LazyLock;

/// A model, or the program's choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WantedModel {
    Auto,
    This(Model),
}

impl ValueEnum for WantedModel {
    fn value_variants<'a>() -> &'a [Self] {
        static ALL: LazyLock<Vec<WantedModel>> = LazyLock::new(|| {
            let models = Model::ALL.into_iter().chain([Model::Traced]).map(WantedModel::This);
            std::iter::once(WantedModel::Auto).chain(models).collect()
        });
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(match self {
            WantedModel::Auto => "auto",
            WantedModel::This(model) => model.name(),
        }))
    }
}

/// Lets clap know the names in `ALL`.
macro_rules! names {
    ($($kind:ty),*) => { $(
        impl ValueEnum for $kind {
            fn value_variants<'a>() -> &'a [Self] {
                &Self::ALL
            }

            fn to_possible_value(&self) -> Option<PossibleValue> {
                Some(PossibleValue::new(self.name()))
            }
        }
    )* };
}

names!(Family, Filter, Method, Model);
