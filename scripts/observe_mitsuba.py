"""Render the observation of a narrowbeam scene with Mitsuba 3, the independent witness.

    python scripts/observe_mitsuba.py SCENE.toml TRUTH.toml --output observed.exr

SCENE.toml gives object, depth, surface and camera, TRUTH.toml the [medium]; scene_file.py says
what is not supported. The output has channels Y and Y.variance (or R, R.variance, ...): the
radiance and the variance of its mean. The [provenance] table for TRUTH.toml goes to stdout,
progress to stderr.
"""

import argparse
import json
import math
import shlex
import sys
from pathlib import Path

import llvm  # before mitsuba
import mitsuba as mi
import numpy as np

from exr_io import write_exr
from mitsuba_world import mitsuba_scene
from scene_file import InputError, read_media, read_scene

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


def batch_sizes(samples, pixels):
    """Return how many batches of how many samples per pixel make at least `samples`."""
    batches = max(MIN_BATCHES, math.ceil(samples * pixels / PATHS_PER_BATCH))
    return batches, math.ceil(samples / batches)


def render_channel(scene, channel, medium, batches, per_batch, seeds):
    """Return mean radiance and variance of the mean of each pixel of the view."""
    world = mitsuba_scene(scene, channel, medium)
    names = world.integrator().aov_names()
    extra = -len(names)  # these channels come last
    mean_at, square_at = (extra + names.index(name) for name in ("path.Y", "m2_path.Y"))
    mean = square = 0.0
    for i, seed in enumerate(seeds):
        image = np.array(mi.render(world, spp=per_batch, seed=int(seed)), dtype=float)
        mean = mean + image[..., mean_at] / batches
        square = square + image[..., square_at] / batches
        print(f"{channel}: batch {i + 1} of {batches}", file=sys.stderr, flush=True)
    return mean, np.maximum(square - mean**2, 0) / (batches * per_batch - 1)


def observe(scene, media, samples, seed):
    """Return the channels of the observation and the samples per pixel that were taken."""
    _, _, width, height = scene.view
    batches, per_batch = batch_sizes(samples, width * height)
    observed = {}
    for i, (channel, medium) in enumerate(zip(scene.radiance, media)):
        seeds = np.random.SeedSequence([seed, i]).generate_state(batches)
        mean, variance = render_channel(scene, channel, medium, batches, per_batch, seeds)
        observed |= {channel: mean, f"{channel}.variance": variance}
    return observed, batches * per_batch


def relative_noise(observed, channel):
    """Return the root mean square noise of a pixel over the mean radiance."""
    return math.sqrt(observed[f"{channel}.variance"].mean()) / observed[channel].mean()


def provenance(arguments, variant, samples, noise):
    """Return the [provenance] table of the truth file."""
    command = shlex.join(["python", *sys.argv])
    values = ", ".join(f"{value:.4f}" for value in noise)
    return "\n".join(
        [
            "[provenance]",
            'program = "Mitsuba 3, scripts/observe_mitsuba.py"',
            f'version = "{mi.__version__}"',
            f'variant = "{variant}"',
            f"samples = {samples}",
            f"seed = {arguments.seed}",
            f"command = {json.dumps(command)}",
            "# root mean square noise of a pixel over the mean radiance",
            f"noise = {values}" if len(noise) == 1 else f"noise = [{values}]",
        ]
    )


def parse_arguments():
    """Return the command line's arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add = parser.add_argument
    add("scene", metavar="SCENE.toml")
    add("truth", metavar="TRUTH.toml", help="file with the [medium]")
    add("--output", required=True, metavar="FILE.exr")
    add("--samples", type=int, default=1024, help="paths per pixel, at least (%(default)s)")
    add("--seed", type=int, default=0, help="(%(default)s)")
    add("--variant", help="Mitsuba variant (llvm_ad_mono where LLVM works, else scalar_rgb)")
    arguments = parser.parse_args()
    if arguments.samples < 1 or arguments.seed < 0:
        parser.error("--samples must be at least 1 and --seed at least 0")
    return arguments


def main():
    arguments = parse_arguments()
    try:
        variant = set_variant(arguments.variant)
        scene = read_scene(arguments.scene)
        media = read_media(arguments.truth, scene.radiance)
        if not Path(arguments.output).parent.is_dir():
            raise InputError(f"{arguments.output}: no such folder")
    except InputError as error:
        print(f"observe_mitsuba.py: {error}", file=sys.stderr)
        sys.exit(2)
    observed, samples = observe(scene, media, arguments.samples, arguments.seed)
    write_exr(arguments.output, observed)
    noise = [relative_noise(observed, channel) for channel in scene.radiance]
    print(provenance(arguments, variant, samples, noise))


if __name__ == "__main__":
    main()
