"""Point Mitsuba at a libLLVM that works. Import before mitsuba, which loads the library on import.

AVAILABLE says whether the llvm_* variants run here. LLVM 15 and older is too old; the Rust
toolchain carries a newer one.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

VARIABLE = "DRJIT_LIBLLVM_PATH"

PROBE = """
import mitsuba as mi
mi.set_variant('llvm_ad_mono')
import drjit as dr
assert dr.all(dr.minimum(dr.arange(mi.Float, 4), 2) <= 2)
"""


def candidates():
    """Return settings of VARIABLE to try; the empty one leaves the choice to Mitsuba."""
    if VARIABLE in os.environ:
        return [os.environ[VARIABLE]]
    query = ["rustc", "--print", "sysroot"]
    try:
        sysroot = subprocess.run(query, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return [""]
    return [*map(str, sorted(Path(sysroot, "lib").glob("libLLVM*"))), ""]


def works(library):
    """Try a library in a process of its own, since one that is too old ends the process.

    The home folder is a fresh one: a kernel from Mitsuba's cache there would need no LLVM.
    """
    with tempfile.TemporaryDirectory() as home:
        environment = os.environ | {VARIABLE: library, "HOME": home}
        probe = [sys.executable, "-c", PROBE]
        return subprocess.run(probe, env=environment, capture_output=True).returncode == 0


def find():
    """Set VARIABLE to the first candidate that works; return whether there is one."""
    for library in candidates():
        if works(library):
            os.environ[VARIABLE] = library
            return True
    return False


AVAILABLE = find()
