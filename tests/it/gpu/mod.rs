//! The graphics backend. Without an adapter every test here fails: `scripts/test.sh` installs a software one.

use crate::common;

#[path = "../../../benches/contenders/methods/mod.rs"]
#[allow(dead_code, reason = "the bench uses all of it")]
mod contenders;

mod adapters;
#[path = "contenders.rs"]
mod contenders_are_right;
mod fits;
mod images;
mod scenes;
mod shifts;
mod stages;
mod twins;

use narrowbeam::gpu::Gpu;

/// The device that the tests share.
pub fn gpu() -> &'static Gpu {
    static GPU: std::sync::OnceLock<Gpu> = std::sync::OnceLock::new();
    GPU.get_or_init(|| {
        let gpu = Gpu::open().expect("these tests need a graphics adapter: see scripts/test.sh");
        println!("adapter: {}", gpu.adapter());
        gpu
    })
}
