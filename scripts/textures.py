"""Square textures, size_px on a side: edges, natural spectra, both; the same for the same rng."""

import numpy as np


def unequal_cells(rng, size_px):
    """Return the number of the cell that each pixel of a row falls in, cells 5 to 23 px wide."""
    widths = rng.integers(5, 24, size=size_px // 5 + 1)
    return np.repeat(np.arange(len(widths)), widths)[:size_px]


def checker(rng, size_px):
    """Return a checkerboard of 0 and 1 whose cells have unequal widths and heights."""
    return (unequal_cells(rng, size_px)[:, None] + unequal_cells(rng, size_px)) % 2


def power_noise(rng, exponent, size_px):
    """Return noise of amplitude spectrum 1/f^exponent: mean 0, standard deviation 1.

    It is cut from a larger periodic field, so that its own borders do not match.
    """
    n = 2 * size_px
    frequency = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.rfftfreq(n))
    frequency[0, 0] = np.inf
    spectrum = np.fft.rfft2(rng.normal(size=(n, n))) / frequency**exponent
    field = np.fft.irfft2(spectrum, s=(n, n))[:size_px, :size_px]
    return (field - field.mean()) / field.std()


def dead_leaves(rng, levels, size_px):
    """Return opaque disks of the given grey levels fallen on each other, with sharp edges."""
    image = np.full((size_px, size_px), levels[0])
    y, x = np.mgrid[:size_px, :size_px] + 0.5
    for _ in range(1500):
        radius_px = 3 / np.sqrt(1 - rng.random() * (1 - (3 / 28) ** 2))  # density 1/r³, to 28 px
        centre_x, centre_y = rng.uniform(-10, size_px + 10, size=2)
        image[np.hypot(x - centre_x, y - centre_y) < radius_px] = rng.choice(levels)
    return image


def natural_checker(rng, size_px):
    """Return a natural texture on a checkerboard."""
    detail = np.clip(0.55 + 0.22 * power_noise(rng, 1, size_px), 0.05, 1.2)
    return detail * (0.5 + 0.7 * checker(rng, size_px))
