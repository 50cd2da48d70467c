"""Render a Mitsuba scene in batches: mean, variance of the mean, and where they come from.

Import before any other module that imports mitsuba: llvm.py must come first.
"""

import json
import math
import shlex
import sys

import llvm  # before mitsuba
import mitsuba as mi
import numpy as np

from scene_file import InputError

# Batches of samples are rendered one by one, each at most this many paths (bounds the memory).
PATHS_PER_BATCH = 2**22
MIN_BATCHES = 16


def set_variant(name):
    """Set the Mitsuba variant and return its name.

    Without a name: llvm_ad_mono where LLVM works, else scalar_rgb (2-3x slower). Spectral variants
    are refused: they would give the radiance a colour.
    """
    name = name or ("llvm_ad_mono" if llvm.AVAILABLE else "scalar_rgb")
    usable = [v for v in mi.variants() if v.endswith(("_mono", "_rgb"))]
    if name not in usable:
        raise InputError(f"--variant {name} is not supported; use one of {', '.join(usable)}")
    try:
        mi.set_variant(name)
    except ImportError as error:
        raise InputError(f"--variant {name} does not run here: {error}") from error
    mi.set_log_level(mi.LogLevel.Error)
    return name


def parse_with_sampling(parser):
    """Add --samples and --seed to `parser` and return the checked arguments."""
    add = parser.add_argument
    add("--samples", type=int, default=1024, help="paths per pixel, at least (%(default)s)")
    add("--seed", type=int, default=0, help="(%(default)s)")
    arguments = parser.parse_args()
    if arguments.samples < 1 or arguments.seed < 0:
        parser.error("--samples must be at least 1 and --seed at least 0")
    return arguments


def batch_sizes(samples, pixels):
    """Return how many batches of how many samples per pixel make at least `samples`."""
    batches = max(MIN_BATCHES, math.ceil(samples * pixels / PATHS_PER_BATCH))
    return batches, math.ceil(samples / batches)


def render(world, samples, pixels, seed, label):
    """Return each pixel's mean radiance, the variance of that mean, and the samples taken.

    `samples` per pixel at least; `seed` is a list of whole numbers, `label` what progress is of.
    """
    batches, per_batch = batch_sizes(samples, pixels)
    names = world.integrator().aov_names()
    extra = -len(names)  # these channels come last
    mean_at, square_at = (extra + names.index(name) for name in ("path.Y", "m2_path.Y"))
    mean = square = 0.0
    for i, batch_seed in enumerate(np.random.SeedSequence(seed).generate_state(batches)):
        image = np.array(mi.render(world, spp=per_batch, seed=int(batch_seed)), dtype=float)
        mean = mean + image[..., mean_at] / batches
        square = square + image[..., square_at] / batches
        print(f"{label}: batch {i + 1} of {batches}", file=sys.stderr, flush=True)
    taken = batches * per_batch
    return mean, np.maximum(square - mean**2, 0) / (taken - 1), taken


def relative_noise(observed, channel):
    """Return the root mean square noise of a pixel over the mean radiance."""
    return math.sqrt(observed[f"{channel}.variance"].mean()) / observed[channel].mean()


def provenance(script, variant, samples, seed, noise):
    """Return the [provenance] table of a truth file; `noise` is a list, one value a channel."""
    command = shlex.join(["python", *sys.argv])
    values = ", ".join(f"{value:.4f}" for value in noise)
    return "\n".join(
        [
            "[provenance]",
            f'program = "Mitsuba 3, scripts/{script}"',
            f'version = "{mi.__version__}"',
            f'variant = "{variant}"',
            f"samples = {samples}",
            f"seed = {seed}",
            f"command = {json.dumps(command)}",
            "# root mean square noise of a pixel over the mean radiance",
            f"noise = {values}" if len(noise) == 1 else f"noise = [{values}]",
        ]
    )
