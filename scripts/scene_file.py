"""Read a narrowbeam scene file and the [medium] of a truth file.

Not supported, and refused by name: perspective cameras, surfaces given as images, further object
layers, borders other than zero, gain and veil.
"""

import math
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from exr_io import read_exr

# A depth beyond this holds no object.
FARTHEST_DEPTH = 1e9


class InputError(Exception):
    """A fault of the input; the message names file, key or pixel."""


@dataclass(frozen=True)
class Scene:
    """What the camera looks at; lengths in the scene's unit.

    radiance: dict of channel -> (height, width); depth: (height, width), NaN where nothing is;
    view: x, y, width, height of the observed part of the object image, in pixels.
    """

    radiance: dict
    depth: np.ndarray
    surface: float
    pixel_pitch: float
    view: tuple

    @property
    def deepest(self):
        """Depth of the deepest object point."""
        return float(np.nanmax(self.depth))


@dataclass(frozen=True)
class Medium:
    """sigma_s, sigma_a in 1/length; the phase function: a Gaussian of width b, rad², or if g is given Henyey-Greenstein's."""

    sigma_s: float
    sigma_a: float
    b: float | None
    g: float | None = None


def read_toml(path):
    """Return a TOML file as a dict."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from error


class Section:
    """One table of a TOML file that knows its own name for error messages."""

    def __init__(self, document, path, name):
        self.table = document.get(name, {})
        self.where = f"{path}: {name}"

    def fail(self, key, message):
        raise InputError(f"{self.where}.{key} {message}")

    def number(self, key, default=None):
        """A finite number."""
        value = self.table.get(key, default)
        if value is None:
            self.fail(key, "is missing")
        if not is_number(value):
            self.fail(key, f"must be a number, not {value!r}")
        return float(value)

    def pair(self, key, default):
        """Two whole numbers."""
        value = self.table.get(key, default)
        if not (isinstance(value, (list, tuple)) and [type(v) for v in value] == [int, int]):
            self.fail(key, f"must be two whole numbers, not {value!r}")
        return tuple(value)

    def only(self, key, *allowed):
        """Refuse any value but those allowed; the first is the default."""
        value = self.table.get(key, allowed[0])
        if value not in allowed:
            self.fail(key, f"= {value!r} is not supported; use {' or '.join(map(repr, allowed))}")


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def read_image(path):
    """Return the channels of an EXR file."""
    if not path.is_file():
        raise InputError(f"{path}: no such file")
    try:
        return read_exr(path)
    except RuntimeError as error:
        raise InputError(f"{path}: not a readable EXR image") from error


def read_scene(path):
    """Return the Scene of a scene file."""
    document = read_toml(path)
    folder = Path(path).parent
    objects, camera, observation = (
        Section(document, path, name) for name in ("object", "camera", "observation")
    )
    objects.only("border", "zero")
    objects.only("sampling", "pixel", "auto")  # a patch a pixel, of one radiance
    objects.only("depth_kind", "ray", "planar")  # one and the same for an orthographic camera
    observation.only("gain", 1.0, "free")
    observation.only("veil", 0.0, "free")
    if "layer" in objects.table:
        objects.fail("layer", "is not supported: one object layer only")
    if "fov_x_deg" in camera.table:
        camera.fail("fov_x_deg", "is not supported: orthographic cameras (pixel_pitch) only")

    radiance = read_radiance(objects, folder)
    shape = next(iter(radiance.values())).shape
    pixel_pitch = camera.number("pixel_pitch")
    if pixel_pitch <= 0:
        camera.fail("pixel_pitch", f"must be above 0, not {pixel_pitch}")
    surface = objects.number("surface", 0.0)
    depth = read_depth(objects, folder, shape)
    if (depth <= surface).any():
        y, x = np.argwhere(depth <= surface)[0]
        objects.fail("depth", f"lies before the medium's surface at pixel x={x}, y={y}")
    return Scene(radiance, depth, surface, pixel_pitch, read_view(observation, shape))


def read_radiance(objects, folder):
    """Return the object's channels: Y, or R, G and B."""
    if not isinstance(objects.table.get("radiance"), str):
        objects.fail("radiance", "is missing or not a file name")
    path = folder / objects.table["radiance"]
    channels = read_image(path)
    for names in (("R", "G", "B"), ("Y",)):
        if all(name in channels for name in names):
            break
    else:
        raise InputError(f"{path}: has channels {', '.join(channels)}; needs Y or R, G, B")
    for name in names:
        refuse_pixels(path, name, channels[name], ~(channels[name] >= 0))
    return {name: channels[name] for name in names}


def read_depth(objects, folder, shape):
    """Return the depth of every pixel, NaN where there is no object."""
    value = objects.table.get("depth")
    if not isinstance(value, str):
        depth = objects.number("depth")
        if depth <= 0:
            objects.fail("depth", f"must be above 0, not {depth}")
        return np.full(shape, depth)
    path = folder / value
    channels = read_image(path)
    if len(channels) != 1:
        raise InputError(f"{path}: has channels {', '.join(channels)}; a depth map has one")
    [(name, depth)] = channels.items()
    if depth.shape != shape:
        raise InputError(f"{path}: is {size(depth.shape)} pixels, the object image {size(shape)}")
    refuse_pixels(path, name, depth, np.isnan(depth))
    present = (depth > 0) & (depth <= FARTHEST_DEPTH)
    if not present.any():
        raise InputError(f"{path}: no pixel holds an object")
    return np.where(present, depth.astype(float), np.nan)


def size(shape):
    return f"{shape[1]}x{shape[0]}"


def refuse_pixels(path, name, values, bad):
    """Fail with the first pixel for which `bad` holds."""
    if bad.any():
        y, x = np.argwhere(bad)[0]
        raise InputError(f"{path}: {name} is {values[y, x]} at pixel x={x}, y={y}")


def read_view(observation, shape):
    """Return x, y, width, height of the observed part of the object image, in pixels."""
    height, width = shape
    w, h = observation.pair("size_px", (width, height))
    x, y = observation.pair("offset_px", ((width - w) // 2, (height - h) // 2))
    if min(w, h) < 1 or min(x, y) < 0 or x + w > width or y + h > height:
        observation.fail("size_px", f"{w}x{h} at {x},{y} does not fit in {size(shape)} pixels")
    return x, y, w, h


def read_media(path, channels):
    """Return one Medium for each channel."""
    medium = Section(read_toml(path), path, "medium")
    if not medium.table:
        raise InputError(f"{path}: table [medium] is missing")
    sigma_s = read_coefficient(medium, "sigma_s", len(channels))
    sigma_a = read_coefficient(medium, "sigma_a", len(channels))
    shapes = [key for key in ("b", "spread_angle_deg", "g") if key in medium.table]
    if len(shapes) != 1:
        medium.fail("b", "or medium.spread_angle_deg or medium.g must be given, and only one of them")
    if "g" in medium.table:
        g = read_coefficient(medium, "g", len(channels))
        if not all(0 < value < 1 for value in g):
            medium.fail("g", f"must be between 0 and 1, exclusive, not {g}")
        return [Medium(*values) for values in zip(sigma_s, sigma_a, [None] * len(g), g)]
    if "b" in medium.table:
        b = read_coefficient(medium, "b", len(channels))
    else:
        angles = read_coefficient(medium, "spread_angle_deg", len(channels))
        b = [math.radians(angle) ** 2 / 4 for angle in angles]
    if min(b) <= 0:
        medium.fail("b", "or medium.spread_angle_deg must be above 0")
    return [Medium(*values) for values in zip(sigma_s, sigma_a, b)]


def read_coefficient(medium, key, count):
    """Return `count` values of a key that holds one number or one for each channel."""
    value = medium.table.get(key)
    if value is None:
        medium.fail(key, "is missing")
    values = value if isinstance(value, list) else [value] * count
    if len(values) != count:
        medium.fail(key, f"has {len(values)} values for {count} channel(s)")
    if not all(is_number(v) and v >= 0 for v in values):
        medium.fail(key, f"must hold numbers that are not negative, not {value!r}")
    return values
