#!/usr/bin/env bash
# Set up whatever the tests need and run them all: the test command of a fresh machine with Rust.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# One test renders a Mitsuba image: its Python environment, once.
scripts/mitsuba_env.sh >/dev/null
# The GPU tests need an adapter, even if only a software one.
scripts/vulkan.sh

cargo test --release --locked --lib --bins --tests --examples
# Documentation examples are run apart. Benches are measurements, and only checked (by clippy).
cargo test --release --locked --doc
