"""Make the object images and depth maps of the bundled datasets, the same bytes on every run.

    python scripts/make_targets.py

Each set has a random stream of its own. Radiances are linear, in (0, 1.5], about .5 on average;
depths are in the length unit of the set's scene.toml, which also gives the pixel pitch.
"""

import tomllib
from pathlib import Path

import mitsuba as mi
import numpy as np

from exr_io import write_exr

DATASETS = Path(__file__).resolve().parent.parent / "datasets"
SIZE_PX = 128


def unequal_cells(rng):
    """Return the number of the cell that each pixel of a row falls in, cells 5 to 23 px wide."""
    widths = rng.integers(5, 24, size=SIZE_PX // 5 + 1)
    return np.repeat(np.arange(len(widths)), widths)[:SIZE_PX]


def checker(rng):
    """Return a checkerboard of 0 and 1 whose cells have unequal widths and heights."""
    return (unequal_cells(rng)[:, None] + unequal_cells(rng)) % 2


def power_noise(rng, exponent):
    """Return noise of amplitude spectrum 1/f^exponent: mean 0, standard deviation 1.

    It is cut from a larger periodic field, so that its own borders do not match.
    """
    n = 2 * SIZE_PX
    frequency = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n))
    frequency[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.normal(size=(n, n))) / frequency**exponent
    field = np.fft.irfft2(spectrum, s=(n, n))[:SIZE_PX, :SIZE_PX]
    return (field - field.mean()) / field.std()


def dead_leaves(rng, levels):
    """Return opaque disks of the given grey levels fallen on each other, with sharp edges."""
    image = np.full((SIZE_PX, SIZE_PX), levels[0])
    y, x = np.mgrid[:SIZE_PX, :SIZE_PX] + 0.5
    for _ in range(1500):
        radius_px = 3 / np.sqrt(1 - rng.random() * (1 - (3 / 28) ** 2))  # density 1/r³, to 28 px
        centre_x, centre_y = rng.uniform(-10, SIZE_PX + 10, size=2)
        image[np.hypot(x - centre_x, y - centre_y) < radius_px] = rng.choice(levels)
    return image


def tilted_plane(pixel_pitch, mean_depth, tilt_deg, toward_deg):
    """Return the depth of a plane that recedes by tan(tilt) along a direction in the image.

    toward_deg is counted from right (0) to down (90).
    """
    rise = np.tan(np.radians(tilt_deg))
    toward = np.radians(toward_deg)
    centred = (np.arange(SIZE_PX) + 0.5 - SIZE_PX / 2) * pixel_pitch
    return mean_depth + rise * (np.cos(toward) * centred + np.sin(toward) * centred[:, None])


def shaded_checker(rng):
    """Return a checkerboard under smooth shading."""
    return (0.22 + 0.6 * checker(rng)) * (1 + 0.12 * np.clip(power_noise(rng, 3), -2.5, 2.5))


def natural(rng):
    """Return a texture with the amplitude spectrum of natural images."""
    return np.clip(0.5 + 0.28 * power_noise(rng, 1), 0.02, 1.2)


def natural_checker(rng):
    """Return a natural texture on a checkerboard."""
    return np.clip(0.55 + 0.22 * power_noise(rng, 1), 0.05, 1.2) * (0.5 + 0.7 * checker(rng))


# name: (seed, radiance, depth plane or None)
TARGETS = {
    "mitsuba-checker": (11, shaded_checker, None),
    "mitsuba-natural": (12, natural, None),
    "mitsuba-slope": (13, lambda rng: dead_leaves(rng, (0.12, 0.45, 0.95)), (2.5, 14, 0)),
    "traced-disks": (14, lambda rng: dead_leaves(rng, (0.15, 0.85)), None),
    "traced-slope": (15, natural_checker, (1.5, 11, 35)),
}


def main():
    mi.set_variant("scalar_rgb")
    for name, (seed, radiance, plane) in TARGETS.items():
        folder = DATASETS / name
        write_exr(folder / "object.exr", {"Y": radiance(np.random.default_rng(seed))})
        if plane:
            scene = tomllib.loads((folder / "scene.toml").read_text(encoding="utf-8"))
            depth = tilted_plane(scene["camera"]["pixel_pitch"], *plane)
            write_exr(folder / "depth.exr", {"Z": depth})


if __name__ == "__main__":
    main()
