"""Take simulated photographs of a scene in clear and in turbid water: a camera to test with.

    python scripts/photograph.py NAME --output datasets/photo-NAME [--samples 1024]

Mitsuba renders the linear radiance of the turbid scene with two texels a pixel, wider than the
frame; in clear air the camera sees the texture itself. Both then pass the same camera: lens blur,
warp, pixels, vignetting, gain, veil, shot and read noise, quantisation and the transfer curve.
RECIPES says what each set is; their seeds were fixed before the first fit. Depth maps are 16-bit
PNG files.
"""

import argparse
import json
import shlex
import struct
import sys
from dataclasses import dataclass
from pathlib import Path

from mitsuba_render import render, set_variant  # before exr_io
import mitsuba as mi
import numpy as np

from mitsuba_world import mitsuba_scene
from scene_file import Medium, Scene
from textures import natural_checker

TEXELS = 2
# Pixels around the frame that are rendered, for lens and warp, and texture around them that sends light in.
RENDERED_PX = 8
AROUND_PX = 40


@dataclass(frozen=True)
class Camera:
    """How one photograph is taken; lengths in pixels, radiances in units of the clear image's white.

    gain: exposure; veil: (middle, change across x, change across y); vignetting: loss of light in the
    corners; shift, turn_deg and scale: how the picture lies against the clear one.
    """

    lens: float = 0.6
    gain: float = 1.0
    veil: tuple = (0.0, 0.0, 0.0)
    vignetting: float = 0.0
    shift: tuple = (0.0, 0.0)
    turn_deg: float = 0.0
    scale: float = 1.0
    read: float = 0.001
    shot: float = 0.004


@dataclass(frozen=True)
class Recipe:
    """A set of photographs: one clear, and a turbid one for each depth."""

    seed: int
    pitch: float
    depths: tuple
    media: tuple
    clear: Camera
    turbid: tuple
    format: str
    transfer: str
    tilt: float = 0.0
    size: tuple = (128, 96)

    @property
    def texels(self):
        """Width and height of the whole scene, texels."""
        return tuple(TEXELS * (side + 2 * (RENDERED_PX + AROUND_PX)) for side in self.size)


B8 = (np.radians(8) ** 2) / 4
B10 = (np.radians(10) ** 2) / 4

RECIPES = {
    # Grey, one depth: a tripod that moved a little, another exposure, a veil with a slope.
    "board": Recipe(
        seed=101,
        size=(192, 144),
        pitch=0.008,
        depths=(1.0,),
        media=(Medium(1.0, 0.08, B8),),
        clear=Camera(),
        turbid=(Camera(gain=0.9, veil=(0.03, 0.02, 0.01), shift=(0.35, -0.6)),),
        format="png16",
        transfer="linear",
    ),
    # Colour, 8 bits and a lossy file: what a telephone writes.
    "colour": Recipe(
        seed=102,
        pitch=0.01,
        depths=(1.5,),
        media=(Medium(0.6, 0.22, B10), Medium(0.7, 0.06, B10), Medium(0.85, 0.04, B10)),
        clear=Camera(),
        turbid=(Camera(gain=1.2, veil=(0.04, 0.0, 0.0), shift=(-0.4, 0.2)),),
        format="jpeg",
        transfer="srgb",
    ),
    # A wall that recedes, with its depth map; turned and scaled, with vignetting.
    "slope": Recipe(
        seed=103,
        pitch=0.008,
        depths=(1.2,),
        media=(Medium(1.1, 0.1, B8),),
        clear=Camera(vignetting=0.06),
        turbid=(Camera(gain=1.0, vignetting=0.09, shift=(0.2, 0.3), turn_deg=0.15, scale=1.002),),
        format="tiff16",
        transfer="linear",
        tilt=0.45,
    ),
    # Two depths with exposures that are known: absorption is determined.
    "depths": Recipe(
        seed=104,
        size=(192, 144),
        pitch=0.008,
        depths=(0.8, 1.5),
        media=(Medium(0.9, 0.15, B8),),
        clear=Camera(),
        turbid=(Camera(gain=1.0, shift=(0.1, 0.25)), Camera(gain=1.8, lens=0.7, shift=(-0.3, 0.5))),
        format="png16",
        transfer="linear",
    ),
}


def texture(recipe, channel):
    """Return the radiance of the whole scene in one channel, texel by texel."""
    width, height = recipe.texels
    board = natural_checker(np.random.default_rng([recipe.seed, 0]), width)[:height]
    return 0.62 * np.clip(board, 0.03, None) * (1 - 0.15 * channel)


def blur(image, width):
    """Return the image blurred by a Gaussian of standard deviation `width` texels."""
    w_y = 2 * np.pi * np.fft.fftfreq(image.shape[0])[:, None]
    w_x = 2 * np.pi * np.fft.rfftfreq(image.shape[1])
    factor = np.exp(-(w_x**2 + w_y**2) * width**2 / 2)
    return np.fft.irfft2(np.fft.rfft2(image) * factor, s=image.shape)


def cubic(image, y, x):
    """Return the image at fractional places, by Catmull and Rom's cubics."""
    row, column = np.floor(y).astype(int), np.floor(x).astype(int)
    result = np.zeros(y.shape)

    def weights(t):
        return (
            -t / 2 + t**2 - t**3 / 2,
            1 - 5 * t**2 / 2 + 3 * t**3 / 2,
            t / 2 + 2 * t**2 - 3 * t**3 / 2,
            -(t**2) / 2 + t**3 / 2,
        )

    for i, v in enumerate(weights(y - row)):
        for j, u in enumerate(weights(x - column)):
            result += v * u * image[row + i - 1, column + j - 1]
    return result


def seen(camera, radiance):
    """Return what falls on the sensor: `radiance` has the rendered margin around the frame."""
    height, width = (side - 2 * TEXELS * RENDERED_PX for side in radiance.shape)
    sharp = blur(radiance, TEXELS * camera.lens)
    margin = TEXELS * RENDERED_PX
    y, x = np.mgrid[:height, :width].astype(float)
    middle_y, middle_x = (height - 1) / 2, (width - 1) / 2
    angle = np.radians(camera.turn_deg)
    # What the camera shows at a place lay elsewhere in the clear picture.
    dx = (x - middle_x - TEXELS * camera.shift[0]) / camera.scale
    dy = (y - middle_y - TEXELS * camera.shift[1]) / camera.scale
    from_x = middle_x + np.cos(angle) * dx + np.sin(angle) * dy
    from_y = middle_y - np.sin(angle) * dx + np.cos(angle) * dy
    moved = cubic(sharp, from_y + margin, from_x + margin)
    return binned(moved)


def binned(image):
    """Return the mean of the texels of each pixel."""
    height, width = (side // TEXELS for side in image.shape)
    return image.reshape(height, TEXELS, width, TEXELS).mean(axis=(1, 3))


def exposed(camera, light, rng):
    """Return the noisy signal of a sensor on which `light` falls."""
    height, width = light.shape
    y = (np.arange(height)[:, None] + 0.5) / height - 0.5
    x = (np.arange(width) + 0.5) / width - 0.5
    corner = (0.5 * width) ** 2 + (0.5 * height) ** 2
    square = ((x * width) ** 2 + (y * height) ** 2) / corner
    middle, across, down = camera.veil
    signal = camera.gain * (1 - camera.vignetting * square) * light + middle + across * x + down * y
    deviation = np.sqrt(camera.read**2 + camera.shot**2 * np.maximum(signal, 0))
    return signal + deviation * rng.standard_normal(signal.shape)


def srgb(linear):
    """Return the encoded values of linear ones in 0..1 (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def write(path, image, kind, transfer):
    """Write an image of shape (height, width, channels), linear, in 0..1."""
    linear = np.clip(image, 0, 1)
    coded = srgb(linear) if transfer == "srgb" else linear
    largest = 255 if kind == "jpeg" else 65535
    codes = np.rint(coded * largest).astype(np.uint8 if kind == "jpeg" else np.uint16)
    if kind == "tiff16":
        write_tiff(path, codes)
    elif kind == "jpeg":
        mi.Bitmap(codes).write(str(path), mi.Bitmap.FileFormat.JPEG, 95)
    else:
        mi.Bitmap(codes).write(str(path), mi.Bitmap.FileFormat.PNG)


def write_tiff(path, codes):
    """Write 16-bit codes as a TIFF file without compression."""
    height, width, samples = codes.shape
    data = codes.astype("<u2").tobytes()
    entries = [
        (256, 3, 1, width),
        (257, 3, 1, height),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (273, 4, 1, 8),
        (277, 3, 1, samples),
        (278, 3, 1, height),
        (279, 4, 1, len(data)),
    ]
    directory = struct.pack("<H", len(entries))
    directory += b"".join(struct.pack("<HHII", *entry) for entry in entries) + bytes(4)
    Path(path).write_bytes(struct.pack("<2sHI", b"II", 42, 8 + len(data)) + data + directory)


def depth_of(recipe, depth):
    """Return the distance of every texel of the scene."""
    width, height = recipe.texels
    x = (np.arange(width) + 0.5 - width / 2) * recipe.pitch / TEXELS
    return np.tile(depth + recipe.tilt * x, (height, 1))


def turbid_radiance(recipe, number, textures, samples):
    """Return what arrives at the camera from depth number `number`, channel by channel."""
    edge = TEXELS * AROUND_PX
    view = (edge, edge, textures[0].shape[1] - 2 * edge, textures[0].shape[0] - 2 * edge)
    arrived = []
    for i, (light, medium) in enumerate(zip(textures, recipe.media)):
        scene = Scene({"Y": light}, depth_of(recipe, recipe.depths[number]), 0.0, recipe.pitch / TEXELS, view)
        world = mitsuba_scene(scene, "Y", medium)
        seed = [recipe.seed, number, i]
        mean, _, _ = render(world, samples, view[2] * view[3], seed, f"depth {number}, channel {i}")
        arrived.append(mean)
    return arrived


SUFFIX = {"png16": "png", "jpeg": "jpg", "tiff16": "tif"}


def photograph(recipe, folder, samples):
    """Write all photographs of a recipe, and its depth map if it has one."""
    rng = np.random.default_rng(recipe.seed)
    textures = [texture(recipe, i) for i in range(len(recipe.media))]
    if len(textures) == 3:
        textures = [t * (0.75 + 0.25 * np.roll(t, 17 * i, axis=1) / t.mean()) for i, t in enumerate(textures)]
    edge = TEXELS * AROUND_PX
    clear = [t[edge:-edge, edge:-edge] for t in textures]

    def take(camera, radiances, name):
        pictures = [exposed(camera, seen(camera, light), rng) for light in radiances]
        path = folder / f"{name}.{SUFFIX[recipe.format]}"
        write(path, np.stack(pictures, axis=-1), recipe.format, recipe.transfer)

    take(recipe.clear, clear, "clear")
    for number, camera in enumerate(recipe.turbid):
        arrived = turbid_radiance(recipe, number, textures, samples)
        take(camera, arrived, "turbid" if number == 0 else f"turbid-{number + 1}")
    if recipe.tilt:
        margin = TEXELS * (RENDERED_PX + AROUND_PX)
        inner = depth_of(recipe, recipe.depths[0])[margin:-margin, margin:-margin]
        # In tenths of a thousandth of the unit of length.
        codes = np.rint(binned(inner) * 1e4).astype(np.uint16)[..., None]
        mi.Bitmap(codes).write(str(folder / "depth.png"), mi.Bitmap.FileFormat.PNG)


def truth(recipe, variant, samples):
    """Return the truth file."""

    def numbers(values):
        values = [float(v) for v in values]
        return repr(values[0]) if len(values) == 1 else repr(values)

    lines = ["[medium]"]
    lines += [f"{key} = {numbers(getattr(m, key) for m in recipe.media)}" for key in ("sigma_s", "sigma_a", "b")]
    for camera in (recipe.clear, *recipe.turbid):
        lines += ["", "[[camera]]"]
        lines += [f"{key} = {json.dumps(value)}" for key, value in vars(camera).items()]
    lines += [
        "",
        "[provenance]",
        'program = "Mitsuba 3, scripts/photograph.py"',
        f'version = "{mi.__version__}"',
        f'variant = "{variant}"',
        f"samples = {samples}",
        f"seed = {recipe.seed}",
        f"command = {json.dumps(shlex.join(['python', *sys.argv]))}",
    ]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("name", choices=RECIPES)
    parser.add_argument("--output", required=True, type=Path, metavar="DIR")
    parser.add_argument("--samples", type=int, default=1024, help="paths per texel (%(default)s)")
    arguments = parser.parse_args()
    variant = set_variant(None)
    recipe = RECIPES[arguments.name]
    arguments.output.mkdir(parents=True, exist_ok=True)
    photograph(recipe, arguments.output, arguments.samples)
    (arguments.output / "truth.toml").write_text(truth(recipe, variant, arguments.samples), encoding="utf-8")


if __name__ == "__main__":
    main()
