//! The bundled datasets, and their fits: each is made once, whichever tests look at it.

use super::report::fit_scenes;
use narrowbeam::filter::Filter;
use narrowbeam::fit::{SceneFit, Settings};
use narrowbeam::scene::ObservedScene;
use narrowbeam::spread::Model;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, OnceLock};

/// The folder of the dataset `name`.
pub fn dataset(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("datasets").join(name)
}

/// A dataset, and the model and the filter that it is fitted by.
type Key = (String, Model, &'static str);

static FITS: LazyLock<Mutex<HashMap<Key, &'static OnceLock<SceneFit>>>> = LazyLock::new(Mutex::default);

/// The fit of the dataset `name` by `model`, on the CPU and with all other settings as they are by default.
pub fn fit(name: &str, model: Model, filter: Filter) -> &'static SceneFit {
    let key = (name.into(), model, filter.name());
    let place = *FITS.lock().unwrap().entry(key).or_insert_with(|| Box::leak(Box::default()));
    place.get_or_init(|| {
        let scene = ObservedScene::read(&dataset(name).join("scene.toml")).unwrap();
        fit_scenes(&[scene], &Settings { model, ..Settings::default() }, filter, &|| ()).unwrap()
    })
}
