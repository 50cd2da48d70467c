"""The scenes of the image synthesis: solids in a tub of a thin medium under parallel light.

Tub axes: x right, y away from the camera, z up, the medium's surface at z = 0; lengths in
centimetres. Camera axes, which scene files and Mitsuba get: x right, y down, z away.
"""

import math
from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from mitsuba_parts import medium_slab
from scene_file import Medium

# Half width of tub and floor: so wide that its sides do not matter.
HALF_WIDTH = 150.0
# Medium below the floor, which Mitsuba would skip if it lay on the slab's face.
BELOW_FLOOR = 1.0

# Narasimhan et al. 2006, as carried by public renderers: sigma_s, sigma_a (1/mm) and g of R, G, B.
LOWFAT_MILK = ((13.12, 15.44, 17.96), (0.00287, 0.00575, 0.0115), (0.932, 0.902, 0.859))
GRAPEFRUIT = ((0.155, 0.154, 0.160), (0.0859, 0.183, 0.253), (0.929, 0.929, 0.931))


@dataclass(frozen=True)
class Solid:
    """A ball or a box in the tub: middle, half size, colours of its checks, turn about z."""

    kind: str
    place: tuple
    half: float
    colours: tuple
    checks: tuple = (1, 1)
    turn_deg: float = 0.0


@dataclass(frozen=True)
class Tub:
    """Solids on and above a checkered floor, the medium that fills the tub, camera and light.

    measured: the pure liquid's coefficients; dilution: parts of water to one part of it.
    """

    title: str
    solids: tuple
    floor: float
    floor_colours: tuple
    measured: tuple
    dilution: float
    pitch_deg: float
    fov_x_deg: float
    camera: tuple
    light: tuple
    irradiance: tuple

    def media(self):
        """Return the medium of each channel, lengths in centimetres; g = 1 - 2b."""
        scale = 10 / self.dilution
        return [Medium(s * scale, a * scale, (1 - g) / 2) for s, a, g in zip(*self.measured)]

    def axes(self):
        """Return the rotation from tub axes to camera axes."""
        c, s = math.cos(math.radians(self.pitch_deg)), math.sin(math.radians(self.pitch_deg))
        return np.array([[1, 0, 0], [0, -s, -c], [0, c, -s]])

    def to_camera(self):
        """Return the transform from tub to camera axes; the camera is at the origin."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.axes()
        matrix[:3, 3] = -self.axes() @ np.array(self.camera)
        return mi.ScalarTransform4f(matrix)

    def normal(self):
        """Return the surface's normal, out of the medium, in camera axes."""
        return self.axes() @ np.array([0.0, 0.0, 1.0])

    def light_direction(self):
        """Return the unit vector along which light travels, in camera axes."""
        light = self.axes() @ np.array(self.light, dtype=float)
        return light / np.linalg.norm(light)

    def shapes(self, channel, black=False):
        """Return the solids and the floor as Mitsuba shapes that reflect one channel's light."""
        place = self.to_camera()
        floor = place.translate([0, 0, -self.floor]).scale([HALF_WIDTH, HALF_WIDTH, 1])
        tiles = HALF_WIDTH / 4.0
        shapes = {
            "floor": {
                "type": "rectangle",
                "to_world": floor,
                "bsdf": checks(self.floor_colours, (tiles, tiles), channel, black),
            }
        }
        for i, solid in enumerate(self.solids):
            turned = place.translate(list(solid.place)).rotate([0, 0, 1], solid.turn_deg)
            shapes[f"solid{i}"] = {
                "type": {"ball": "sphere", "box": "cube"}[solid.kind],
                "to_world": turned.scale(solid.half),
                "bsdf": checks(solid.colours, solid.checks, channel, black),
            }
        return shapes

    def slab(self, medium):
        """Return the medium as a Mitsuba shape."""
        slab = medium_slab(medium, -(self.floor + BELOW_FLOOR), 0.0, HALF_WIDTH)
        slab["to_world"] = self.to_camera() @ slab["to_world"]
        slab["interior"]["sample_emitters"] = True  # parallel light is met in no other way
        return slab

    def sun(self, channel):
        """Return the light as a Mitsuba emitter."""
        return {
            "type": "directional",
            "direction": list(self.light_direction()),
            "irradiance": self.irradiance[channel],
        }


def checks(colours, counts, channel, black):
    """Return a Lambertian checkerboard of two colours, the channel's part of it."""
    first, second = (0.0 if black else colour[channel] for colour in colours)
    texture = {
        "type": "checkerboard",
        "color0": first,
        "color1": second,
        "to_uv": mi.ScalarTransform4f().scale([*counts, 1]),
    }
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": texture}}


WHITE = (0.85, 0.85, 0.85)
RED, DARK_RED = (0.80, 0.08, 0.06), (0.35, 0.03, 0.03)
BLUE, DARK_BLUE = (0.07, 0.22, 0.75), (0.03, 0.08, 0.30)
GREEN, DARK_GREEN = (0.10, 0.55, 0.14), (0.04, 0.20, 0.06)
YELLOW, ORANGE = (0.90, 0.68, 0.06), (0.88, 0.34, 0.04)
BLACK = (0.04, 0.04, 0.04)
PURPLE = (0.45, 0.10, 0.55)

TUBS = {
    "milk": Tub(
        title="Balls and boxes sink in thin milk",
        solids=(
            Solid("ball", (-9.0, -5.5, -3.2), 3.0, (RED, WHITE), (8, 4)),
            Solid("box", (1.5, -7.0, -5.0), 2.6, (YELLOW, DARK_BLUE), (2, 2), 28),
            Solid("ball", (10.0, -2.0, -6.4), 3.2, (BLUE, WHITE), (8, 4)),
            Solid("box", (-6.0, 5.0, -8.6), 3.0, (GREEN, WHITE), (2, 2), -20),
            Solid("ball", (3.0, 5.0, -10.6), 3.2, (ORANGE, BLACK), (8, 4)),
            Solid("ball", (14.0, 9.0, -11.0), 3.0, (PURPLE, WHITE), (8, 4)),
            Solid("ball", (-16.0, 7.0, -11.0), 3.0, (YELLOW, RED), (8, 4)),
        ),
        floor=14.0,
        floor_colours=(WHITE, (0.12, 0.13, 0.16)),
        measured=LOWFAT_MILK,
        dilution=1000.0,
        pitch_deg=52.0,
        fov_x_deg=31.0,
        camera=(-1.0, -40.0, 48.0),
        light=(0.45, 0.35, -1.0),
        irradiance=(3.2, 3.0, 2.8),
    ),
    "juice": Tub(
        title="A stair of boxes leads down into thin grapefruit juice",
        solids=(
            *(
                Solid(
                    "box",
                    (-13.5 + 6.4 * i, -6.5 + 3.2 * i, -3.6 - 2.6 * i),
                    3.0,
                    (WHITE, BLACK),
                    (3, 3),
                )
                for i in range(5)
            ),
            Solid("ball", (7.5, -9.0, -3.2), 2.8, (BLUE, WHITE), (8, 4)),
            Solid("ball", (-13.0, 6.5, -9.0), 3.0, (GREEN, WHITE), (8, 4)),
            Solid("ball", (14.5, -3.5, -11.5), 2.8, (YELLOW, DARK_RED), (8, 4)),
            Solid("ball", (-2.0, 11.0, -14.0), 3.0, (WHITE, PURPLE), (8, 4)),
        ),
        floor=17.0,
        floor_colours=(WHITE, (0.25, 0.30, 0.30)),
        measured=GRAPEFRUIT,
        dilution=30.0,
        pitch_deg=52.0,
        fov_x_deg=31.0,
        camera=(0.0, -42.5, 46.0),
        light=(-0.45, 0.30, -1.0),
        irradiance=(3.2, 3.0, 2.8),
    ),
}
