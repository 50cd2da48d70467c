#!/usr/bin/env bash
# Where no graphics adapter is found, install Mesa's software Vulkan: the GPU tests run on it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

adapters() { cargo run --quiet --release --locked --example adapters; }

if adapters; then
  exit 0
fi
if ! command -v apt-get >/dev/null; then
  echo "no graphics adapter: install a Vulkan driver (Mesa's software one is called lavapipe)" >&2
  exit 1
fi
as_root=()
if [ "$(id -u)" -ne 0 ]; then
  as_root=(sudo)
fi
"${as_root[@]}" apt-get update -qq
"${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq mesa-vulkan-drivers >/dev/null
adapters
