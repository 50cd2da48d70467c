"""Make the object images and depth maps of the bundled datasets, the same bytes on every run.

Also the bright square of tests/witness/squares.

    python scripts/make_targets.py

Each set has a random stream of its own. Radiances are linear, in (0, 1.5], about .5 on average;
depths are in the length unit of the set's scene.toml, which also gives the pixel pitch.
"""

import tomllib
from pathlib import Path

import mitsuba as mi
import numpy as np

from exr_io import write_exr
from textures import checker, dead_leaves, natural_checker, power_noise

ROOT = Path(__file__).resolve().parent.parent
DATASETS = ROOT / "datasets"
SQUARE = ROOT / "tests" / "witness" / "squares" / "object.exr"
SIZE_PX = 128
WIDE_PX = 64


def tilted_plane(pixel_pitch, mean_depth, tilt_deg, toward_deg):
    """Return the depth of a plane that recedes by tan(tilt) along a direction in the image.

    toward_deg is counted from right (0) to down (90).
    """
    rise = np.tan(np.radians(tilt_deg))
    toward = np.radians(toward_deg)
    centred = (np.arange(SIZE_PX) + 0.5 - SIZE_PX / 2) * pixel_pitch
    return mean_depth + rise * (np.cos(toward) * centred + np.sin(toward) * centred[:, None])


def shaded_checker(rng, size_px=SIZE_PX):
    """Return a checkerboard under smooth shading."""
    cells = 0.22 + 0.6 * checker(rng, size_px)
    return cells * (1 + 0.12 * np.clip(power_noise(rng, 3, size_px), -2.5, 2.5))


def wide_checker(rng):
    """Return a small checkerboard, for kernels that are wide."""
    return shaded_checker(rng, WIDE_PX)


def natural(rng):
    """Return a texture with the amplitude spectrum of natural images."""
    return np.clip(0.5 + 0.28 * power_noise(rng, 1, SIZE_PX), 0.02, 1.2)


def bright_square(size_px=48, side_px=8):
    """Return a square of radiance 1 in the middle of black."""
    image = np.zeros((size_px, size_px))
    middle = slice((size_px - side_px) // 2, (size_px + side_px) // 2)
    image[middle, middle] = 1
    return image


# name: (seed, radiance, depth plane or None)
TARGETS = {
    "mitsuba-checker": (11, shaded_checker, None),
    "mitsuba-natural": (12, natural, None),
    "mitsuba-slope": (13, lambda rng: dead_leaves(rng, (0.12, 0.45, 0.95), SIZE_PX), (2.5, 14, 0)),
    "wide-20": (21, wide_checker, None),
    "wide-30": (22, wide_checker, None),
    "wide-30-thick": (23, wide_checker, None),
    "wide-45": (24, wide_checker, None),
    "wide-45-thin": (25, wide_checker, None),
    "hg-90": (26, wide_checker, None),
    "traced-disks": (14, lambda rng: dead_leaves(rng, (0.15, 0.85), SIZE_PX), None),
    "traced-slope": (15, lambda rng: natural_checker(rng, SIZE_PX), (1.5, 11, 35)),
}


def main():
    mi.set_variant("scalar_rgb")
    write_exr(SQUARE, {"Y": bright_square()})
    for name, (seed, radiance, plane) in TARGETS.items():
        folder = DATASETS / name
        write_exr(folder / "object.exr", {"Y": radiance(np.random.default_rng(seed))})
        if plane:
            scene = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
            depth = tilted_plane(scene["camera"]["pixel_pitch"], *plane)
            write_exr(folder / "depth.exr", {"Z": depth})


if __name__ == "__main__":
    main()
