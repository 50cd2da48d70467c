#!/usr/bin/env bash
# What takes too long for every change: more of the same tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Fits that are killed at 200 random moments.
cargo test --release --locked --test it cli::killed:: -- --ignored --nocapture

# A million damaged files and 2500 random command lines.
NARROWBEAM_FUZZ="${NARROWBEAM_FUZZ:-500000}" cargo test --release --locked --test it fuzz:: -- --nocapture
