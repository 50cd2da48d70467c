"""Render the observation of a narrowbeam scene with Mitsuba 3, the independent witness.

    python scripts/observe_mitsuba.py SCENE.toml TRUTH.toml --output observed.exr

SCENE.toml gives object, depth, surface and camera, TRUTH.toml the [medium]; scene_file.py says
what is not supported. The output has channels Y and Y.variance (or R, R.variance, ...): the
radiance and the variance of its mean. The [provenance] table for TRUTH.toml goes to stdout,
progress to stderr.
"""

import argparse
import sys
from pathlib import Path

from mitsuba_render import (  # before exr_io
    parse_with_sampling,
    provenance,
    relative_noise,
    render,
    set_variant,
)
from exr_io import write_exr
from mitsuba_world import MEDIUM_BEHIND, mitsuba_scene
from scene_file import InputError, read_media, read_scene


def observe(scene, media, samples, seed, behind):
    """Return the channels of the observation and the samples per pixel that were taken."""
    _, _, width, height = scene.view
    observed = {}
    for i, (channel, medium) in enumerate(zip(scene.radiance, media)):
        world = mitsuba_scene(scene, channel, medium, behind)
        mean, variance, taken = render(world, samples, width * height, [seed, i], channel)
        observed |= {channel: mean, f"{channel}.variance": variance}
    return observed, taken


def parse_arguments():
    """Return the command line's arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add = parser.add_argument
    add("scene", metavar="SCENE.toml")
    add("truth", metavar="TRUTH.toml", help="file with the [medium]")
    add("--output", required=True, metavar="FILE.exr")
    add("--variant", help="Mitsuba variant (llvm_ad_mono where LLVM works, else scalar_rgb)")
    add(
        "--behind",
        type=float,
        default=MEDIUM_BEHIND,
        metavar="X",
        help="how far the medium goes on behind the object, in its depths (%(default)s). Next to nothing makes the plane "
        "beside a flat object black: through a deep medium, wide lobes send light past the object and back",
    )
    return parse_with_sampling(parser)


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
    observed, samples = observe(
        scene, media, arguments.samples, arguments.seed, arguments.behind
    )
    write_exr(arguments.output, observed)
    noise = [relative_noise(observed, channel) for channel in scene.radiance]
    print(provenance("observe_mitsuba.py", variant, samples, arguments.seed, noise))


if __name__ == "__main__":
    main()
