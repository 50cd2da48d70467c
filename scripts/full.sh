#!/usr/bin/env bash
# What takes too long for every change: a million damaged files and 2500 random command lines.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

NARROWBEAM_FUZZ="${NARROWBEAM_FUZZ:-500000}" cargo test --release --locked --test it fuzz:: -- --nocapture
