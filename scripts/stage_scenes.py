"""The staged scenes: whole shapes in a slab of medium, so that what is hidden is really there.

Axes: x right and y down in the image, z away from the camera, lengths in metres. Depths are
counted from z = 0, where a perspective camera stands; an orthographic one stands before the slab.
Every shape sends out light on the side that faces outwards or to the camera; all else is dark.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from mitsuba_parts import emission, film, integrator, medium_slab
from scene_file import Medium
from textures import dead_leaves, natural_checker, power_noise

# The slab's reach beside and behind the shapes, in depths of the farthest that is seen: generous,
# yet not so wide that the single precision of its front face shifts the image.
BESIDE = 5.0
BEHIND = 1.5
# Distance of an orthographic camera from the slab.
CAMERA_BEFORE = 1.0


@dataclass(frozen=True)
class Stage:
    """Shapes by name, medium and camera.

    shapes: makes the shapes anew, as Mitsuba dictionaries; size_px, view_px: of the square object
    image and its central part that is observed; surface, deepest: depths of the slab's front and of
    the farthest point that is seen; one of pixel_pitch (orthographic) and fov_x_deg is given.
    """

    title: str
    shapes: Callable
    size_px: int
    view_px: int
    surface: float
    deepest: float
    sigma_s: float
    sigma_a: float
    spread_angle_deg: float
    pixel_pitch: float | None = None
    fov_x_deg: float | None = None

    @property
    def step(self):
        """What a pixel adds to x: a length, or for a perspective camera a length per depth."""
        if self.fov_x_deg is None:
            return self.pixel_pitch
        return 2 * math.tan(math.radians(self.fov_x_deg) / 2) / self.size_px

    @property
    def half_width(self):
        """Half the width that the object image spans at the farthest point."""
        return self.step * self.size_px / 2 * (1 if self.fov_x_deg is None else self.deepest)

    @property
    def medium(self):
        """The medium as the slab takes it."""
        b = math.radians(self.spread_angle_deg) ** 2 / 4
        return Medium(self.sigma_s, self.sigma_a, b)


def sensor(stage):
    """Return the camera, its film cropped to the view."""
    corner = (stage.size_px - stage.view_px) // 2
    crop = {"crop_offset_x": corner, "crop_offset_y": corner}
    crop |= {"crop_width": stage.view_px, "crop_height": stage.view_px}
    if stage.fov_x_deg is None:
        z, half_width = stage.surface - CAMERA_BEFORE, stage.half_width
        lens = {"type": "orthographic"}
    else:
        z, half_width = 0.0, 1.0
        lens = {"type": "perspective", "fov": stage.fov_x_deg, "fov_axis": "x"}
    look = mi.ScalarTransform4f().look_at(origin=[0, 0, z], target=[0, 0, z + 1], up=[0, -1, 0])
    return lens | {
        "to_world": look.scale([half_width, half_width, 1]),
        "near_clip": 0.1,
        "far_clip": 100.0,
        "sampler": {"type": "independent"},
        "film": film(stage.size_px, stage.size_px, **crop),
    }


def stage_world(stage):
    """Return the Mitsuba scene of the shapes in their medium."""
    half_width = BESIDE * stage.deepest + stage.half_width
    slab = medium_slab(stage.medium, stage.surface, BEHIND * stage.deepest, half_width)
    parts = {"integrator": integrator(), "sensor": sensor(stage), "medium": slab}
    return mi.load_dict({"type": "scene", **parts, **stage.shapes()})


def facing_rectangle(radiance, to_world):
    """Return a square from -1 to 1 in x and y that shows an image to a camera before it.

    Its normal, towards -z, and the image go where `to_world` takes them.
    """
    turned = to_world.rotate([1, 0, 0], 180)  # texture places now run upwards
    return {"type": "rectangle", "to_world": turned, **emission(radiance[::-1])}


def leaves_with_detail(rng, size_px):
    """Return disks fallen on each other, with a natural texture on them."""
    leaves = dead_leaves(rng, (0.12, 0.45, 0.95), size_px)
    return leaves * np.clip(1 + 0.25 * power_noise(rng, 1, size_px), 0.3, 1.7)


# Half planes: a near one on the left before a far one that fills the image.
PLANES_PX = 192
PLANES_PITCH = 0.026
NEAR, FAR = 1.0, 2.5


def planes():
    """Return the two planes; their texels are the pixels of the image."""
    half = PLANES_PX * PLANES_PITCH / 2
    near = leaves_with_detail(np.random.default_rng(21), PLANES_PX)[:, : PLANES_PX // 2]
    far = natural_checker(np.random.default_rng(22), PLANES_PX)
    place = mi.ScalarTransform4f
    return {
        "near": facing_rectangle(
            near, place().translate([-half / 2, 0, NEAR]).scale([half / 2, half, 1])
        ),
        "far": facing_rectangle(far, place().translate([0, 0, FAR]).scale([half, half, 1])),
    }


# One plane, steeply tilted about the vertical.
TILT_PX = 192
TILT_PITCH = 0.0211
TILT_DEG = 40.0
TILT_MIDDLE = 2.0


def tilt():
    """Return the plane; the columns of its texels are those of the image."""
    half = TILT_PX * TILT_PITCH / 2
    texture = leaves_with_detail(np.random.default_rng(23), TILT_PX)
    place = mi.ScalarTransform4f().translate([0, 0, TILT_MIDDLE]).rotate([0, 1, 0], -TILT_DEG)
    along = half / math.cos(math.radians(TILT_DEG))
    return {"plane": facing_rectangle(texture, place.scale([along, half, 1]))}


# A ball just above the ground and a box on it, seen from above; the view's axis meets the ground
# at depth GROUND. Places are on the ground: right, and away from the camera.
GROUND = 2.0
DOWN_DEG = 45.0
GROUND_HALF = 4.0
BALL_RADIUS = 0.22
BALL_GAP = 0.03
BALL_PLACE = (-0.23, -0.15)
BOX_HALF = 0.19
BOX_PLACE = (0.27, 0.1)
BOX_TURN_DEG = 32.0


def stage():
    """Return the ground, the ball and the box."""
    # Ground axes: x right, y away from the camera, z up.
    ground_to_camera = (
        mi.ScalarTransform4f().translate([0, 0, GROUND]).rotate([1, 0, 0], 90 + DOWN_DEG)
    )
    ground = natural_checker(np.random.default_rng(24), 1024)
    ball = natural_checker(np.random.default_rng(25), 192)
    box = leaves_with_detail(np.random.default_rng(26), 64)

    centre = np.array(ground_to_camera @ mi.ScalarPoint3f([*BALL_PLACE, BALL_GAP + BALL_RADIUS]))
    away = mi.ScalarTransform4f().look_at(origin=centre, target=2 * centre, up=[0, -1, 0])
    # The texture's seam to the far side, its poles to the left and the right, out of view.
    ball_place = away.scale(BALL_RADIUS).rotate([0, 1, 0], -90)
    box_place = ground_to_camera.translate([*BOX_PLACE, BOX_HALF]).rotate([0, 0, 1], BOX_TURN_DEG)
    ground_place = ground_to_camera.translate([0, GROUND_HALF / 2, 0])
    return {
        "ground": {
            "type": "rectangle",
            "to_world": ground_place.scale([GROUND_HALF, GROUND_HALF, 1]),
            **emission(ground),
        },
        "ball": {"type": "sphere", "to_world": ball_place, **emission(ball)},
        "box": {"type": "cube", "to_world": box_place.scale(BOX_HALF), **emission(box)},
    }


STAGES = {
    "planes": Stage(
        title="Two textured planes, the near one covering the left half",
        shapes=planes,
        size_px=PLANES_PX,
        view_px=PLANES_PX,
        surface=0.0,
        deepest=FAR,
        sigma_s=0.8,
        sigma_a=0.06,
        spread_angle_deg=10.0,
        pixel_pitch=PLANES_PITCH,
    ),
    "tilt": Stage(
        title="Fallen disks on a plane tilted 40 degrees",
        shapes=tilt,
        size_px=TILT_PX,
        view_px=TILT_PX,
        surface=0.0,
        deepest=3.7,
        sigma_s=0.8,
        sigma_a=0.05,
        spread_angle_deg=9.0,
        pixel_pitch=TILT_PITCH,
    ),
    "stage": Stage(
        title="A ball and a box on the ground before a perspective camera",
        shapes=stage,
        size_px=288,
        view_px=168,
        surface=0.5,
        deepest=4.4,
        sigma_s=0.7,
        sigma_a=0.05,
        spread_angle_deg=8.0,
        fov_x_deg=57.0,
    ),
}
