"""The parts that every Mitsuba scene here is made of: emission, medium, film, integrator."""

import math

import mitsuba as mi
import numpy as np


def emission(radiance):
    """Return emitter and material of a shape that sends out `radiance` and reflects nothing.

    Texture place v = 0 is the first row of the image.
    """
    texture = {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(radiance[..., None], dtype=np.float32)),
        "raw": True,
        "filter_type": "nearest",
    }
    return {
        "emitter": {"type": "area", "radiance": texture},
        "bsdf": {"type": "diffuse", "reflectance": 0.0},
    }


def medium_slab(medium, front, back, half_width):
    """Return the slab of medium between two depths, its surface index matched, as a shape."""
    sigma_t = medium.sigma_s + medium.sigma_a
    return {
        "type": "cube",
        "to_world": mi.ScalarTransform4f()
        .translate([0, 0, (front + back) / 2])
        .scale([half_width, half_width, (back - front) / 2]),
        "bsdf": {"type": "null"},
        "interior": {
            "type": "homogeneous",
            "sigma_t": sigma_t,
            "albedo": medium.sigma_s / sigma_t if sigma_t > 0 else 0.0,
            "sample_emitters": False,  # hopeless through a narrow phase function
            "phase": phase_function(medium),
        },
    }


def phase_function(medium):
    """Return the phase function of a medium; Mitsuba's hg scatters forward for g > 0 too."""
    if medium.g is not None:
        return {"type": "hg", "g": medium.g}
    return {"type": "tabphase", "values": phase_table(medium.b)}


def phase_nodes(b):
    """Return the cosines at which a lobe of width `b` is tabulated, regular from -1 to 1 (forward).

    exp(-(1 - cos theta)/(2b)) is nearly the lobe, and its width in cos theta is 2b: with fifty
    nodes to this width linear interpolation errs by 3e-5.
    """
    return np.linspace(-1, 1, max(8001, math.ceil(50 / b) + 1))


def phase_table(b):
    """Return p(theta) ∝ exp(-theta²/(4b)) at these nodes, as text.

    Mitsuba normalises the table and cannot read denormal numbers.
    """
    theta = np.arccos(phase_nodes(b))
    values = np.maximum(np.exp(-(theta**2) / (4 * b)), 1e-30)
    return ", ".join(f"{v:.8e}" for v in values)


def film(width, height, **crop):
    """Return a film whose pixels are the mean over their area; `crop` as Mitsuba names it."""
    return {
        "type": "hdrfilm",
        "width": width,
        "height": height,
        "pixel_format": "luminance",
        "component_format": "float32",
        "rfilter": {"type": "box"},
        **crop,
    }


def integrator():
    """Return a path tracer that adds the second moment, for the variance of its mean."""
    return {
        "type": "moment",
        # No Russian roulette, no limit on the number of scatterings.
        "path": {"type": "volpath", "max_depth": -1, "rr_depth": 2**31 - 1},
    }
