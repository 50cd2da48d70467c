"""Make a scene for `narrowbeam synthesize` with Mitsuba 3, and what Mitsuba itself sees there.

    python scripts/tub_mitsuba.py NAME --output FOLDER [--width PX] [--samples N --witness]

NAME is milk or juice (tub_scenes.py). Written are reflectance.exr and shading.exr (what share of
the light's irradiance reaches a pixel, shadows included), depth.exr, surface.exr and scene.toml.
With --witness also witness.exr, by path tracing: veil.R, ... with all shapes black, object.R, ...
the difference that their colours make, the variance of either, and the seconds on stdout. Runs on
llvm_ad_mono.
"""

import argparse
import sys
import time
from pathlib import Path

from mitsuba_render import parse_with_sampling, render, set_variant  # before exr_io
import mitsuba as mi
import numpy as np

from exr_io import write_exr
from mitsuba_parts import film, integrator
from scene_file import InputError
from tub_scenes import TUBS

CHANNELS = "RGB"
# Height over width of the image.
ASPECT = 0.75
# Clear images are means over a Fibonacci lattice of rays in each pixel.
RAYS, TURN = 55, 34
# Images are rounded to such steps, which lie far below what a picture shows, to be stored small.
STEP = 2.0**-9
DEPTH_STEP = 2.0**-8


class View:
    """The perspective camera at the origin as rays, (height, width) px."""

    def __init__(self, tub, width):
        self.width, self.height = width, round(ASPECT * width)
        self.step = 2 * np.tan(np.radians(tub.fov_x_deg) / 2) / width

    def rays(self, right=0.5, down=0.5):
        """Return unit directions through (right, down) in [0, 1) of every pixel, (n, 3)."""
        x = (np.arange(self.width) - self.width / 2 + right) * self.step
        y = (np.arange(self.height) - self.height / 2 + down) * self.step
        y, x = np.meshgrid(y, x, indexing="ij")
        rays = np.stack([x.ravel(), y.ravel(), np.ones(x.size)], axis=-1)
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)

    def image(self, values):
        return values.reshape(self.height, self.width)


def hits(world, rays):
    """Return where `rays` first meet a shape."""
    return world.ray_intersect(mi.Ray3f(mi.Point3f(0), mi.Vector3f(rays.T)))


def reflected(world, light, rays):
    """Return the reflectance that rays meet, and the share of the light's irradiance there."""
    found = hits(world, rays)
    reflectance = found.bsdf().eval_diffuse_reflectance(found)
    normal = np.array(found.n).T
    toward_light, toward_camera = -normal @ light, -np.einsum("ij,ij->i", normal, rays)
    shadow = np.array(world.ray_test(found.spawn_ray(mi.Vector3f((-light).tolist()))))
    lit = (toward_light * toward_camera > 0) & ~shadow
    share = np.where(lit, np.abs(toward_light), 0)
    return np.array(reflectance).reshape(-1, len(rays))[0], share


def clear_images(tub, view):
    """Return reflectances of the channels, shading, and planar depths of object and surface."""
    light = tub.light_direction()
    worlds = [mi.load_dict({"type": "scene", **tub.shapes(i)}) for i in range(3)]
    reflectance, lit, weight = np.zeros((3, view.width * view.height)), 0.0, 0.0
    for k in range(RAYS):
        rays = view.rays((k + 0.5) / RAYS, (k * TURN + 0.5) / RAYS % 1)
        for i, world in enumerate(worlds):
            found, share = reflected(world, light, rays)
            reflectance[i] += found / RAYS
            # So weighted, reflectance times shading is the mean of their product over the pixel.
            lit, weight = lit + found * share, weight + found
    rays = view.rays()
    depth = np.array(hits(worlds[0], rays).t) * rays[:, 2]
    normal, camera = tub.normal(), tub.to_camera() @ mi.ScalarPoint3f(0, 0, 0)
    surface = np.dot(np.array(camera).ravel(), normal) / (rays @ normal) * rays[:, 2]
    return reflectance, lit / weight, depth, surface


def rounded(values, step):
    return np.round(values / step) * step


def write_scene(folder, tub, view):
    """Write the images and the scene file."""
    reflectance, shading, depth, surface = clear_images(tub, view)
    images = {c: view.image(rounded(v, STEP)) for c, v in zip(CHANNELS, reflectance)}
    write_exr(folder / "reflectance.exr", images)
    write_exr(folder / "shading.exr", {"Y": view.image(rounded(shading, STEP))})
    write_exr(folder / "depth.exr", {"Z": view.image(rounded(depth, DEPTH_STEP))})
    write_exr(folder / "surface.exr", {"Z": view.image(rounded(surface, DEPTH_STEP))})
    (folder / "scene.toml").write_text(scene_toml(tub), encoding="utf-8")


def scene_toml(tub):
    """Return the text of the scene file."""

    def row(values, digits=6):
        return "[" + ", ".join(f"{v:.{digits}g}" for v in values) + "]"

    media = tub.media()
    bottom = [np.mean(pair) for pair in zip(*tub.floor_colours)]
    return f"""# {tub.title}, 1 part to {tub.dilution:g} parts of water; lengths in centimetres
[object]
reflectance = "reflectance.exr"
shading = "shading.exr"
depth = "depth.exr"
depth_kind = "planar"
surface = "surface.exr"
border = "clamp"

[camera]
fov_x_deg = {tub.fov_x_deg:g}

[medium]
sigma_s = {row(m.sigma_s for m in media)}
sigma_a = {row(m.sigma_a for m in media)}
b = {row(m.b for m in media)}

[illumination]
direction = {row(tub.light_direction())}
irradiance = {row(tub.irradiance)}
normal = {row(tub.normal())}
bottom = {tub.floor:g}
bottom_reflectance = {row(bottom)}
"""


def sensor(tub, view):
    """Return the camera as a Mitsuba sensor."""
    look = mi.ScalarTransform4f().look_at(origin=[0, 0, 0], target=[0, 0, 1], up=[0, -1, 0])
    return {
        "type": "perspective",
        "to_world": look,
        "fov": tub.fov_x_deg,
        "fov_axis": "x",
        "near_clip": 0.1,
        "far_clip": 1000.0,
        "sampler": {"type": "independent"},
        "film": film(view.width, view.height),
    }


def witness(tub, view, samples, seed):
    """Return veil and object light as Mitsuba traces them, with variances."""
    pixels = view.width * view.height
    seen = {}
    for i, (channel, medium) in enumerate(zip(CHANNELS, tub.media())):
        both = []
        for black in (False, True):
            parts = {"integrator": integrator(), "sensor": sensor(tub, view), "sun": tub.sun(i)}
            shapes = {"medium": tub.slab(medium), **tub.shapes(i, black)}
            world = mi.load_dict({"type": "scene", **parts, **shapes})
            label = f"{channel}, {'veil' if black else 'all light'}"
            both.append(render(world, samples, pixels, [seed, i, int(black)], label)[:2])
        (total, total_variance), (veil, veil_variance) = both
        seen |= {f"veil.{channel}": veil, f"veil.{channel}.variance": veil_variance}
        seen |= {f"object.{channel}": total - veil}
        seen |= {f"object.{channel}.variance": total_variance + veil_variance}
    return seen


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("name", choices=TUBS)
    parser.add_argument("--output", required=True, metavar="FOLDER", type=Path)
    parser.add_argument("--width", type=int, default=320, metavar="PX", help="(%(default)s)")
    parser.add_argument("--witness", action="store_true", help="also trace what Mitsuba sees")
    arguments = parse_with_sampling(parser)
    try:
        set_variant("llvm_ad_mono")
    except InputError as error:
        print(f"tub_mitsuba.py: {error}", file=sys.stderr)
        sys.exit(2)
    tub = TUBS[arguments.name]
    view = View(tub, arguments.width)
    arguments.output.mkdir(parents=True, exist_ok=True)
    write_scene(arguments.output, tub, view)
    if arguments.witness:
        start = time.perf_counter()
        seen = witness(tub, view, arguments.samples, arguments.seed)
        print(f"traced in {time.perf_counter() - start:.0f} s")
        write_exr(arguments.output / "witness.exr", seen)


if __name__ == "__main__":
    main()
