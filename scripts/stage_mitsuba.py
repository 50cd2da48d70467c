"""Make a dataset from whole shapes with Mitsuba 3: what lies behind a near surface is there.

    python scripts/stage_mitsuba.py NAME --output FOLDER

NAME is planes, tilt or stage (stage_scenes.py). Written are object.exr and depth.exr, of what the
camera sees in clear air; observed.exr, through the medium; scene.toml and truth.toml. Where one
surface hides another, so are behind.exr and behind_depth.exr, of the surface right behind what the
camera sees, and layers.toml, the scene with them as a further layer. Runs on llvm_ad_mono.
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
import mitsuba as mi
import numpy as np

from exr_io import write_exr
from scene_file import InputError
from stage_scenes import STAGES, stage_world

BEHIND_TOML = """
[[object.layer]]
radiance = "behind.exr"
depth = "behind_depth.exr"
"""

# The clear radiance of a pixel is the mean over a Fibonacci lattice of rays: neither rows nor
# columns, which would meet an edge along the image's axes all at once.
RAYS, TURN = 377, 233

# What lies this close behind a solid, in metres, touches it and is covered by it.
CONTACT = 1e-3


def pixel_rays(stage, right, down):
    """Return the rays through (right, down) in [0, 1) of every pixel, and their cosines to z."""
    steps = np.arange(stage.size_px) - stage.size_px / 2
    y, x = np.meshgrid((steps + down) * stage.step, (steps + right) * stage.step, indexing="ij")
    x, y, zero = x.ravel(), y.ravel(), np.zeros(x.size)
    if stage.fov_x_deg is None:
        cosine = zero + 1
        return mi.Ray3f(mi.Point3f(x, y, zero), mi.Vector3f(zero, zero, cosine)), cosine
    cosine = 1 / np.sqrt(x**2 + y**2 + 1)
    return mi.Ray3f(mi.Point3f(0), mi.Vector3f(x * cosine, y * cosine, cosine)), cosine


def hit(shape, rays):
    """Return where rays enter and leave a convex shape, inf where they miss it; its radiance."""
    entry = shape.ray_intersect(rays)
    rest = shape.ray_intersect(entry.spawn_ray(rays.d))
    front = np.array(entry.t, dtype=float)
    through = np.where(np.array(rest.is_valid()), np.array(rest.t, dtype=float), 0)
    radiance = entry.emitter(shape).eval(entry, entry.is_valid())
    return front, front + through, np.array(radiance, dtype=float).ravel()


def nearest(distance, radiance):
    """Return which shape is nearest on each ray, its distance and its radiance."""
    which = distance.argmin(axis=0)[None]
    return which, *(np.take_along_axis(v, which, axis=0)[0] for v in (distance, radiance))


def two_surfaces(shapes, rays):
    """Return distance and radiance of the first surface and of the next that faces the camera.

    The distance is inf and the radiance 0 where there is none.
    """
    hits = (hit(shape, rays) for shape in shapes)
    front, back, radiance = (np.stack(values) for values in zip(*hits))
    first, *seen = nearest(front, radiance)
    beyond = front > np.take_along_axis(back, first, axis=0) + CONTACT
    _, *hidden = nearest(np.where(beyond, front, np.inf), np.where(beyond, radiance, 0))
    return seen, hidden


def clear_images(stage):
    """Return radiance and planar depth of the first surface, and of the one behind it.

    Depths are those at pixel centres, 0 where nothing is; radiances are means over those rays of a
    pixel that meet such a surface, 0 where the depth is.
    """
    shapes = [
        mi.load_dict({"type": "scene", name: shape}) for name, shape in stage.shapes().items()
    ]
    size = (stage.size_px, stage.size_px)
    total, count = np.zeros((2, 2, stage.size_px**2))
    for k in range(RAYS):
        rays, _ = pixel_rays(stage, (k + 0.5) / RAYS, (k * TURN + 0.5) / RAYS % 1)
        for i, (distance, radiance) in enumerate(two_surfaces(shapes, rays)):
            total[i] += radiance
            count[i] += np.isfinite(distance)
    rays, cosine = pixel_rays(stage, 0.5, 0.5)
    for i, (distance, _) in enumerate(two_surfaces(shapes, rays)):
        present = np.isfinite(distance)
        radiance = np.where(present, total[i] / np.maximum(count[i], 1), 0)
        depth = np.where(present, distance, 0) * cosine
        yield radiance.reshape(size), depth.reshape(size)


def scene_toml(stage, layer=""):
    """Return the text of a scene file; `layer` is its table of a further layer."""
    if stage.fov_x_deg is None:
        camera = f"pixel_pitch = {stage.pixel_pitch}"
    else:
        camera = f"fov_x_deg = {stage.fov_x_deg}"
    return f"""# {stage.title}, seen through a slab by Mitsuba; lengths in metres
[object]
radiance = "object.exr"
depth = "depth.exr"
depth_kind = "planar"
surface = {stage.surface}
border = "zero"
sampling = "pixel"
{layer}
[camera]
{camera}

[observation]
image = "observed.exr"
gain = 1.0
veil = 0.0
"""


def truth_toml(stage, name, origin):
    """Return the text of the truth file; `origin` is its [provenance] table."""
    return f"""# The medium that made datasets/mitsuba-{name}; lengths in metres
[medium]
sigma_s = {stage.sigma_s}
sigma_a = {stage.sigma_a}
spread_angle_deg = {stage.spread_angle_deg}

{origin}
"""


def write_clear(folder, stage):
    """Write the clear images and the scene files."""
    (radiance, depth), (behind, behind_depth) = clear_images(stage)
    write_exr(folder / "object.exr", {"Y": radiance})
    write_exr(folder / "depth.exr", {"Z": depth})
    (folder / "scene.toml").write_text(scene_toml(stage), encoding="utf-8")
    if behind_depth.any():
        write_exr(folder / "behind.exr", {"Y": behind})
        write_exr(folder / "behind_depth.exr", {"Z": behind_depth})
        (folder / "layers.toml").write_text(scene_toml(stage, BEHIND_TOML), encoding="utf-8")


def parse_arguments():
    """Return the command line's arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    add = parser.add_argument
    add("name", choices=STAGES)
    add("--output", required=True, metavar="FOLDER", type=Path)
    return parse_with_sampling(parser)


def main():
    arguments = parse_arguments()
    try:
        variant = set_variant("llvm_ad_mono")
    except InputError as error:
        print(f"stage_mitsuba.py: {error}", file=sys.stderr)
        sys.exit(2)
    folder, name, stage = arguments.output, arguments.name, STAGES[arguments.name]
    folder.mkdir(parents=True, exist_ok=True)
    write_clear(folder, stage)

    seed = [arguments.seed, 0]
    world = stage_world(stage)
    mean, variance, taken = render(world, arguments.samples, stage.view_px**2, seed, name)
    observed = {"Y": mean, "Y.variance": variance}
    write_exr(folder / "observed.exr", observed)

    noise = [relative_noise(observed, "Y")]
    origin = provenance("stage_mitsuba.py", variant, taken, arguments.seed, noise)
    (folder / "truth.toml").write_text(truth_toml(stage, name, origin), encoding="utf-8")
    print(origin)


if __name__ == "__main__":
    main()
