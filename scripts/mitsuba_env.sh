#!/usr/bin/env bash
# Make the Python environment of the data makers (Mitsuba 3 and numpy, pinned).
# The last line on stdout is the path of its python; everything else goes to stderr.
# NARROWBEAM_MITSUBA_ENV names another place than .venv-mitsuba in the repository root.
set -euo pipefail

pins=(mitsuba==3.9.1 numpy==2.4.6)
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
env_dir=${NARROWBEAM_MITSUBA_ENV:-$root/.venv-mitsuba}
stamp=$env_dir/narrowbeam-pins.txt
python=$env_dir/bin/python

fail() {
    echo "mitsuba_env.sh: $*" >&2
    exit 1
}

if [[ ! -x $python || ! -f $stamp || $(<"$stamp") != "${pins[*]}" ]]; then
    command -v python3 >/dev/null || fail "python3 is missing; install Python 3.11 or newer"
    python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
        fail "$(python3 --version) is too old; Python 3.11 or newer is needed"
    python3 -c 'import venv, ensurepip' 2>/dev/null ||
        fail "python3 has no venv module; install it (Debian, Ubuntu: apt-get install python3-venv)"
    echo "making $env_dir with ${pins[*]}" >&2
    rm -f "$stamp"
    python3 -m venv "$env_dir" >&2 || fail "cannot make a virtual environment in $env_dir"
    "$python" -m pip install --quiet --disable-pip-version-check "${pins[@]}" >&2 ||
        fail "pip could not install ${pins[*]}: no network, or no wheel for this platform?"
    echo "${pins[*]}" >"$stamp"
fi
echo "$python"
