//! Lists the graphics adapters that `--backend gpu` could use, best first. Fails if there is none.
//!
//! ```sh
//! cargo run --release --example adapters
//! ```

use narrowbeam::gpu::adapters;
use std::process::ExitCode;

fn main() -> ExitCode {
    let all = adapters();
    for adapter in &all {
        println!("{adapter}, binds {} MiB", adapter.most_bytes >> 20);
    }
    if all.is_empty() { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
