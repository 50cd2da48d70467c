"""Build the Mitsuba scene of an observation: emitting object, slab of medium, camera.

World axes: x right and y down in the image, z away from the camera, origin at the centre of the
object image on the plane from which depths are counted. One world unit is the depth of the
deepest object point, so that Mitsuba's ray offsets suit any length unit.
"""

from dataclasses import replace

import mitsuba as mi
import numpy as np

from mitsuba_parts import emission, film, integrator, medium_slab

# Extent of the world, in depths of the deepest object point. The medium only has to be generous;
# much wider, and the single precision of its front face shifts the image by parts of a pixel.
MEDIUM_BEHIND = 0.5
MEDIUM_BESIDE = 5.0
CAMERA_BEFORE = 0.5

# Depth steps of more pixel pitches than this between neighbours are edges, not slopes.
EDGE_PITCHES = 4.0


def shifted(image, dy, dx):
    """Return image[y + dy, x + dx] for every pixel, NaN beyond the image."""
    height, width = image.shape
    padded = np.pad(image, 1, constant_values=np.nan)
    return padded[1 + dy : 1 + dy + height, 1 + dx : 1 + dx + width]


def slope(depth, edge, dy, dx):
    """Return the depth step per pixel along (dy, dx), from those neighbours not beyond an edge."""
    steps = np.stack([shifted(depth, dy, dx) - depth, depth - shifted(depth, -dy, -dx)])
    steps[~(np.abs(steps) <= edge)] = np.nan
    known = np.isfinite(steps)
    return np.where(known, steps, 0).sum(0) / np.maximum(known.sum(0), 1)


def corner_depths(depth, edge, sy, sx):
    """Return the depth of the pixel corner towards (sy, sx) as each pixel's own patch has it.

    Each pixel extends its centre depth to the corner along its slopes; the patches that meet at
    a corner without an edge between them take the mean, so that they join. A plane stays exact.
    """
    height, width = depth.shape
    rise_y, rise_x = slope(depth, edge, 1, 0), slope(depth, edge, 0, 1)
    total = np.zeros((height, width))
    count = np.zeros((height, width))
    # In an order fixed by position in the image: patches that join add up the same numbers alike.
    for dy in sorted((0, sy)):
        for dx in sorted((0, sx)):
            toward_y, toward_x = (sy / 2 - dy), (sx / 2 - dx)
            guess = shifted(depth + toward_y * rise_y + toward_x * rise_x, dy, dx)
            joined = np.abs(shifted(depth, dy, dx) - depth) <= edge
            total += np.where(joined, guess, 0)
            count += joined
    return total / np.maximum(count, 1)


def object_patches(scene):
    """Return the object, one quadrangle a pixel: vertices (n, 4, 3), texture places (n, 4, 2).

    Corners run top left, bottom left, bottom right, top right. All four corners of a patch have
    the texture place of the pixel's centre: the radiance of a patch is that of its pixel.
    """
    height, width = scene.depth.shape
    rows, columns = np.nonzero(np.isfinite(scene.depth))
    vertices = []
    for sy, sx in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        x = (columns + (1 + sx) / 2 - width / 2) * scene.pixel_pitch
        y = (rows + (1 + sy) / 2 - height / 2) * scene.pixel_pitch
        z = corner_depths(scene.depth, EDGE_PITCHES * scene.pixel_pitch, sy, sx)[rows, columns]
        vertices.append(np.stack([x, y, z], axis=-1))
    centres = np.stack([(columns + 0.5) / width, (rows + 0.5) / height], axis=-1)
    return np.stack(vertices, axis=1) / scene.deepest, np.repeat(centres[:, None], 4, axis=1)


def object_mesh(scene, channel):
    """Return the Mitsuba mesh that sends out the radiance of one channel towards the camera."""
    properties = mi.Properties()
    for key, value in emission(scene.radiance[channel]).items():
        properties[key] = mi.load_dict(value)

    vertices, places = object_patches(scene)
    first = 4 * np.arange(len(vertices), dtype=np.uint32)[:, None]
    faces = first + np.array([0, 2, 3, 0, 1, 2], dtype=np.uint32)  # normals towards -z
    mesh = mi.Mesh("object", 4 * len(vertices), 2 * len(vertices), properties, False, True)
    parameters = mi.traverse(mesh)
    for key, values in (
        ("vertex_positions", vertices.astype(np.float32)),
        ("vertex_texcoords", places.astype(np.float32)),
        ("faces", faces),
    ):
        parameters[key] = type(parameters[key])(values.ravel())
    parameters.update()
    return mesh


def medium_box(scene, medium, behind):
    """Return the slab of medium around the object."""
    height, width = scene.depth.shape
    half_width = MEDIUM_BESIDE + max(height, width) / 2 * scene.pixel_pitch / scene.deepest
    sigma_s, sigma_a = medium.sigma_s * scene.deepest, medium.sigma_a * scene.deepest
    scaled = replace(medium, sigma_s=sigma_s, sigma_a=sigma_a)
    return medium_slab(scaled, scene.surface / scene.deepest, 1 + behind, half_width)


def camera(scene):
    """Return the orthographic camera on the view, as a Mitsuba sensor."""
    height, width = scene.depth.shape
    x0, y0, w, h = scene.view
    pitch = scene.pixel_pitch / scene.deepest
    x, y = (x0 + w / 2 - width / 2) * pitch, (y0 + h / 2 - height / 2) * pitch
    z = scene.surface / scene.deepest - CAMERA_BEFORE
    look = mi.ScalarTransform4f().look_at(origin=[x, y, z], target=[x, y, z + 1], up=[0, -1, 0])
    return {
        "type": "orthographic",
        "to_world": look.scale([w / 2 * pitch, w / 2 * pitch, 1]),
        "near_clip": CAMERA_BEFORE / 2,
        "far_clip": 10.0,
        "sampler": {"type": "independent"},
        "film": film(w, h),
    }


def mitsuba_scene(scene, channel, medium, behind=MEDIUM_BEHIND):
    """Return the Mitsuba scene of one channel; its integrator adds the second moment.

    behind: how far the medium goes on behind the deepest object point, in depths of that.
    """
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": integrator(),
            "sensor": camera(scene),
            "object": object_mesh(scene, channel),
            "medium": medium_box(scene, medium, behind),
        }
    )
